"""Bounds of the distance from boxes: never more than it is, and tight."""

import numpy as np
from oracles.worlds import bounded, geometry_table, random_world

from drake_geom_ros.geometry._proximity.pairs.distance_bounds import (
    separation_from_plane,
    separation_of_aabbs,
)
from drake_geom_ros.geometry._proximity.world.world import FrameTable, World


def test_touching_boxes_far_away_are_not_apart():
    # 0.1 + 0.2 is not 0.3: rounding must not lose a pair that touches.
    offset, half = 1e6, np.array([[0.1] * 3, [0.2] * 3])
    p = np.array([[offset, offset, 0.0], [offset + 0.3, offset, 0.0]])
    assert separation_of_aabbs(p, half, 0, 1) == 0.0


def test_gaps_are_lower_bounds_and_tight():
    rng = np.random.default_rng(1)
    world = random_world(rng, 40)
    for i in range(39):
        apart = np.abs(world.p_WGs[i] - world.p_WGs[i + 1])
        gap = apart - world.half_extents[i] - world.half_extents[i + 1]
        expected = np.linalg.norm(np.maximum(gap, 0.0))
        found = separation_of_aabbs(world.p_WGs, world.half_extents, i, i + 1)
        assert expected - 1e-14 <= found <= expected


def test_the_gap_above_a_plane():
    # A floor at z = 1, and a box whose lowest point is at z = 1.4.
    frames = FrameTable(np.arange(1, 3), np.zeros(2, dtype=np.int64))
    p_FGs = np.array([[5.0, 5.0, 1.0], [0.0, 0.0, 0.0]])
    table = geometry_table([0, 1], [6, 2], [[], [0.3, 0.2, 0.1]], None, p_FGs)
    world = World(frames, table)
    world.set_poses(np.array([1]), np.eye(3)[None], np.array([[0.0, 0.0, 1.5]]))
    world.update()
    gap = separation_from_plane(0, 1, bounded(world))
    assert 0.4 - 1e-13 <= gap <= 0.4
