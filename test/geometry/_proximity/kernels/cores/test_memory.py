"""What two hulls keep is recalled as it was, and nothing that is no closed surface."""

import numpy as np
import pytest
from oracles.core_pairs import core_pair

from drake_geom_ros.geometry import Convex, MeshData
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import MEMORY_WIDTH
from drake_geom_ros.geometry._proximity.kernels.cores import memory, small_polytope
from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import hull_parameters
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from truth.bodies.random_bodies import random_directions

OCTAHEDRON = (
    *((0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)),
    *((2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)),
)


def _pair(rng):
    vertices = random_directions(rng, 12)
    shape = hull_parameters(*Convex.FromMeshData(MeshData(vertices)).hull_surface())
    return core_pair(CONVEX, shape, np.eye(3), CONVEX, shape, np.eye(3), (0.3, 0.2, 0.1))


class _Room:
    """What a polytope grows in; the views do not keep the block alive."""

    def __init__(self):
        self.block = np.zeros(small_polytope.growth_numbers())
        arrays = small_polytope.growth_arrays(self.block)
        self.points, self.corners, _, self.masks, _, _ = arrays

    def faces(self, total):
        """Return the corners (total, 3) of the faces."""
        rows = np.asarray(self.corners).reshape(3, -1)
        return rows[:, :total].T.copy()


def _kept(rng, faces):
    """Return (memory, room) of a surface whose vertices are any pairs of vertices."""
    room, kept = _Room(), np.zeros(MEMORY_WIDTH)
    for f, corners in enumerate(faces):
        small_polytope.set_corners(room.corners, f, *corners)
    i, j = rng.integers(1, 12, (2, 6))
    room.points[:6, small_polytope.NAME] = i + memory.NAMES * j
    memory.keep(kept, room.points, room.corners, len(faces), room.masks)
    return kept, room


def test_what_is_kept_is_recalled_as_it_was():
    rng = np.random.default_rng(8)
    pair, again = _pair(rng), _Room()
    kept, room = _kept(rng, OCTAHEDRON)
    found = memory.recall(kept, pair, again.points, again.corners, again.masks)
    assert found == (6, 8)
    names = [r.points[r.faces(8), small_polytope.NAME] for r in (room, again)]
    np.testing.assert_array_equal(names[1], names[0])
    a, b = (again.points[:6, k : k + 3] for k in (3, 6))
    np.testing.assert_array_equal(again.points[:6, :3], a - b)


def test_no_more_is_kept_than_there_is_room_for():
    kept, _ = _kept(np.random.default_rng(1), 6 * OCTAHEDRON)
    assert kept[0] == 0.0


@pytest.mark.parametrize('column', range(6))
def test_a_surface_with_one_corner_wrong_is_not_closed(column):
    rng = np.random.default_rng(9)
    room = _Room()
    kept, _ = _kept(rng, OCTAHEDRON)
    for bit in range(8):
        wrong = kept.copy()
        bits = int(wrong[memory.FIRST_FACE + 1])
        wrong[memory.FIRST_FACE + 1] = float(bits ^ (1 << (8 * column + bit)))
        found = memory.recall(wrong, _pair(rng), room.points, room.corners, room.masks)
        assert found == (0, 0)


@pytest.mark.parametrize(
    'faces', [OCTAHEDRON[:7], OCTAHEDRON + OCTAHEDRON, (*OCTAHEDRON[1:], (0, 4, 2))]
)
def test_a_surface_with_a_hole_twice_or_turned_is_not_closed(faces):
    rng = np.random.default_rng(10)
    room = _Room()
    kept, _ = _kept(rng, faces)
    found = memory.recall(kept, _pair(rng), room.points, room.corners, room.masks)
    assert found == (0, 0)


def test_numbers_that_are_none_are_not_recalled():
    rng = np.random.default_rng(11)
    pair, room = _pair(rng), _Room()
    for place in (0, 1, memory.FIRST_NAME, memory.FIRST_FACE):
        for value in (-1.0, np.nan, np.inf, 1e300, 2.0**48):
            kept, _ = _kept(rng, OCTAHEDRON)
            kept[place] = value
            found = memory.recall(kept, pair, room.points, room.corners, room.masks)
            assert found == (0, 0)
