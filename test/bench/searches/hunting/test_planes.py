"""The independent plane: never wider than the truth, and as wide as it where pairs are plain."""

import numpy as np
import pytest
from numba import config

from bench.searches.hunting import planes, starts
from drake_geom_ros.cross_check.bodies import Body, Pair
from truth.references.convex import of_any_size
from truth.tolerances import SEARCH

COUNT = 40
SEEDS = 1 if config.DISABLE_JIT else 3


def some_pairs(seed):
    rng = np.random.default_rng(seed)
    made = (starts.random_pair(rng) for _ in range(4 * COUNT))
    return [pair for pair in made if starts.valid(pair)][:COUNT]


@pytest.mark.parametrize('seed', range(SEEDS))
def test_no_plane_is_wider_than_the_truth_and_most_attain_it(seed):
    pairs = some_pairs(seed)
    gaps, normals = planes.widest(planes.packed(pairs), np.zeros((len(pairs), 1, 3)))
    truths = np.array([of_any_size(pair) for pair in pairs])
    extents = np.array([pair.extent for pair in pairs])
    assert ((gaps - truths) / extents <= SEARCH).all()
    assert np.count_nonzero((truths - gaps) / extents <= 1e-9) >= 0.8 * len(pairs)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-12)


def test_the_gap_along_a_normal_is_that_of_the_direction_found():
    pairs = some_pairs(3)[:8]
    packed = planes.packed(pairs)
    gaps, normals = planes.widest(packed, np.zeros((len(pairs), 1, 3)))
    np.testing.assert_allclose(planes.gaps(packed, -normals), gaps, rtol=1e-12)


def test_hulls_that_no_scene_takes_are_not_hunted_with():
    flat = Body('Convex', ((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1e-13)))
    assert not starts.valid(Pair(Body('Sphere', (1.0,)), flat))
    assert starts.valid(Pair(Body('Sphere', (1.0,)), Body('Box', (1.0, 1.0, 1e-9))))
