"""Timed scenes hold the pairs that they are said to hold, whatever way these are turned."""

import numpy as np
import pytest

from bench.accuracy.cases import ShapePair
from bench.accuracy.samples import CONFIGURATIONS, stream
from bench.accuracy.timed import FARTHEST, side_by_side
from truth.judging.asking import PENETRATION, POINTS, SIGNED_DISTANCE


def samples_of(case):
    rng = stream(case.name, 0)
    return [case.sample(configuration, rng) for configuration in CONFIGURATIONS]


@pytest.mark.parametrize(
    'case',
    [
        ShapePair('Sphere', 'Box'),
        ShapePair('Sphere', 'HalfSpace'),
        ShapePair('HalfSpace', 'Convex', 8),
    ],
)
def test_pairs_side_by_side_keep_their_distances(case):
    known = samples_of(case)
    timed = side_by_side(known)
    assert timed.found(FARTHEST) == len(known)
    distances = timed._ask(SIGNED_DISTANCE, 'exact', np.zeros((0, 3)))[0]
    expected = sorted(pair.distance for pair in known)
    np.testing.assert_allclose(sorted(distances), expected, rtol=0, atol=1e-12)


def test_points_meet_their_own_shape_only():
    known = samples_of(ShapePair('Point', 'Box'))
    timed = side_by_side(known)
    seconds = timed.cycle(POINTS, 'exact', np.random.default_rng(0), len(known))
    assert 0.0 < seconds.kernels < seconds.whole


def test_a_cycle_finds_no_answer_of_the_last_one():
    known = [pair for pair in samples_of(ShapePair('Sphere', 'Box')) if pair.distance < -1e-9]
    timed = side_by_side(known)
    rng = np.random.default_rng(1)
    for _ in range(2):
        timed.cycle(PENETRATION, 'exact', rng, len(known))
        assert timed._asked.effects().cached_pairs == 0
