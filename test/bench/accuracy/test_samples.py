"""Samples: as far apart as made, the same for the same seed, their truth that of a search."""

import numpy as np
import pytest

from bench.accuracy.cases import ShapePair
from bench.accuracy.samples import CONFIGURATIONS, stream
from truth.references import convex as truth

CASES = [
    ShapePair('Box', 'Cylinder'),
    ShapePair('Ellipsoid', 'Ellipsoid'),
    ShapePair('HalfSpace', 'Convex', 8),
    ShapePair('Convex', 'Convex', 64),
    ShapePair('Point', 'Capsule'),
]


@pytest.mark.parametrize('case', CASES, ids=lambda case: case.name)
def test_pairs_that_do_not_overlap_are_as_far_apart_as_made(case):
    rng = stream(case.name, 0)
    for configuration, gap in CONFIGURATIONS.items():
        made = case.sample(configuration, rng)
        if gap is not None and gap >= 0.0:
            assert made.distance == pytest.approx(gap, abs=1e-15)
            assert truth.signed_distance(made.a, made.b)[0] == pytest.approx(
                made.distance, abs=1e-15
            )
        elif gap is not None:
            # The best way out may be shorter than the one that they were put together along.
            assert made.distance >= gap - 1e-15


def test_samples_depend_on_seed_and_case_alone():
    first, again, other = (
        CASES[0].sample('apart', stream(CASES[0].name, seed)) for seed in (0, 0, 1)
    )
    assert first.distance == again.distance
    np.testing.assert_array_equal(first.b.p, again.b.p)
    assert not np.array_equal(first.b.p, other.b.p)


def test_contained_pairs_have_their_origins_next_to_each_other():
    made = CASES[1].sample('contained', stream(CASES[1].name, 0))
    assert np.linalg.norm(made.b.p) == pytest.approx(0.01)
    assert made.distance < -0.02
    assert made.extent > 0.2
