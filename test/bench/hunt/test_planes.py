"""The independent plane: never wider than the truth, and as wide as it where pairs are plain."""

import numpy as np
import pytest
from numba import config

from bench.hunt import exact, planes, starts

COUNT = 40
SEEDS = 1 if config.DISABLE_JIT else 3


def pairs(seed):
    rng = np.random.default_rng(seed)
    made = (starts.random_pair(rng) for _ in range(4 * COUNT))
    return [case for case in made if starts.valid(case)][:COUNT]


@pytest.mark.parametrize('seed', range(SEEDS))
def test_no_plane_is_wider_than_the_truth_and_most_attain_it(seed):
    cases = pairs(seed)
    gaps, normals = planes.widest(planes.packed(cases), np.zeros((len(cases), 1, 3)))
    truths = np.array([exact.distance(case) for case in cases])
    extents = np.array([case.extent for case in cases])
    assert ((gaps - truths) / extents <= exact.SEARCH).all()
    assert np.count_nonzero((truths - gaps) / extents <= 1e-9) >= 0.8 * len(cases)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-12)


def test_the_gap_along_a_normal_is_that_of_the_direction_found():
    cases = pairs(3)[:8]
    packed = planes.packed(cases)
    gaps, normals = planes.widest(packed, np.zeros((len(cases), 1, 3)))
    np.testing.assert_allclose(planes.gaps(packed, -normals), gaps, rtol=1e-12)
