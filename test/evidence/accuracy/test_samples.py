"""Samples: as far apart as made, the same for the same seed, their truth that of a search."""

import numpy as np
import pytest

from drake_geom_ros.evidence.accuracy.cases import Case
from drake_geom_ros.evidence.accuracy.samples import CONFIGURATIONS, sample, stream
from drake_geom_ros.evidence.truth import convex as truth

CASES = [
    Case('Box', 'Cylinder'),
    Case('Ellipsoid', 'Ellipsoid'),
    Case('HalfSpace', 'Convex', 8),
    Case('Convex', 'Convex', 64),
    Case('Point', 'Capsule'),
]


@pytest.mark.parametrize('case', CASES, ids=lambda case: case.name)
def test_pairs_that_do_not_overlap_are_as_far_apart_as_made(case):
    rng = stream(case.name, 0)
    for configuration, gap in CONFIGURATIONS.items():
        made = sample(case, configuration, rng)
        if gap is not None and gap >= 0.0:
            assert made.truth == pytest.approx(gap, abs=1e-15)
            pair = made.a.support(), made.X_WA, made.b.support(), made.X_WB
            assert truth.signed_distance(*pair)[0] == pytest.approx(made.truth, abs=1e-15)
        elif gap is not None:
            # The best way out may be shorter than the one that they were put together along.
            assert made.truth >= gap - 1e-15


def test_samples_depend_on_seed_and_case_alone():
    first, again, other = (
        sample(CASES[0], 'apart', stream(CASES[0].name, seed)) for seed in (0, 0, 1)
    )
    assert first.truth == again.truth
    np.testing.assert_array_equal(first.X_WB[1], again.X_WB[1])
    assert not np.array_equal(first.X_WB[1], other.X_WB[1])


def test_contained_pairs_have_their_origins_next_to_each_other():
    made = sample(CASES[1], 'contained', stream(CASES[1].name, 0))
    assert np.linalg.norm(made.X_WB[1]) == pytest.approx(0.01)
    assert made.truth < -0.02
    assert made.size > 0.2
