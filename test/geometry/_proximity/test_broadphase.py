"""The broad phase against all pairs: nothing within reach is missed, nothing is twice."""

import math

import numpy as np
import pytest
from oracles.worlds import geometry_table, random_world

from drake_geom_ros.geometry._proximity.broadphase import candidate_pairs
from drake_geom_ros.geometry._proximity.world import FrameTable, World


def all_pairs(world):
    i, j = np.triu_indices(world.geometry_count, k=1)
    free = ~(world.anchored[i] & world.anchored[j])
    return np.column_stack((i[free], j[free]))


def box_gaps(world, pairs):
    """Return the distance of the pairs' boxes [m]."""
    i, j = pairs.T
    apart = np.abs(world.p_WGs[i] - world.p_WGs[j])
    gap = apart - world.half_extents[i] - world.half_extents[j]
    return np.linalg.norm(np.maximum(gap, 0.0), axis=1)


@pytest.mark.parametrize('max_distance', [0.0, 0.1, 0.7, math.inf])
@pytest.mark.parametrize('anchored', [0, 12])
def test_candidates_are_the_pairs_of_boxes_within_reach(max_distance, anchored):
    for seed in range(5):
        world = random_world(np.random.default_rng(seed), 40, anchored=anchored)
        expected = all_pairs(world)
        expected = expected[box_gaps(world, expected) <= max_distance]
        np.testing.assert_array_equal(candidate_pairs(world, max_distance), expected)


def test_many_overlapping_bodies_outgrow_the_first_guess_of_room():
    world = random_world(np.random.default_rng(0), 60, spread=0.01)
    pairs = all_pairs(world)
    expected = pairs[box_gaps(world, pairs) <= 0.0]
    assert len(expected) > 1000
    np.testing.assert_array_equal(candidate_pairs(world, 0.0), expected)


@pytest.mark.parametrize('count', [0, 1])
def test_scenes_without_a_pair(count):
    world = random_world(np.random.default_rng(0), count)
    assert candidate_pairs(world, 0.0).shape == (0, 2)
    assert candidate_pairs(world, math.inf).shape == (0, 2)


def test_a_half_space_meets_what_reaches_its_plane():
    # A floor, and spheres of radius 0.1 at heights around it; the last is anchored as well.
    heights = np.array([0.5, 0.25, 0.05, -3.0, -3.0])
    frames = FrameTable(np.arange(1, 6), np.zeros(5, dtype=np.int64))
    p_FGs = np.zeros((6, 3))
    p_FGs[1:, 2] = heights
    table = geometry_table([0, 1, 2, 3, 4, 0], [6, 1, 1, 1, 1, 1], [[], *[[0.1]] * 5], None, p_FGs)
    world = World(frames, table)
    world.update()

    def against_floor(distance):
        return [j for i, j in candidate_pairs(world, distance).tolist() if i == 0]

    assert against_floor(0.0) == [3, 4]
    assert against_floor(0.2) == [2, 3, 4]
    assert against_floor(math.inf) == [1, 2, 3, 4]


def test_touching_boxes_far_away_are_candidates():
    # 0.1 + 0.2 is not 0.3: rounding must not lose a pair that touches.
    frames = FrameTable(np.arange(1, 4), np.zeros(3, dtype=np.int64))
    world = World(frames, geometry_table([1, 2], [1, 1], [[0.1], [0.2]]))
    offset = 1e6
    ps = np.array([[offset, offset, 0.0], [offset + 0.3, offset, 0.0]])
    world.set_poses(np.array([1, 2]), np.tile(np.eye(3), (2, 1, 1)), ps)
    world.update()
    assert candidate_pairs(world, 0.0).tolist() == [[0, 1]]
