"""Eight boxes or triangles at a time, and the tree of them, against one by one."""

import math

import numpy as np
import pytest
from oracles.exact_surfaces import squared_distance
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.geometry._proximity.kernels.solids import lane_tree, lanes, nearest_triangles
from drake_geom_ros.geometry._proximity.kernels.solids.solid import tree_of
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.tolerances import LANE_ERROR


def test_gaps_of_boxes_are_those_of_each():
    rng = np.random.default_rng(1)
    corners = np.sort(rng.normal(size=(2, 3, 8)), axis=0)
    q, gaps = (0.3, -0.2, 0.9), np.zeros(8)
    bits, nearest = lanes.near_boxes(corners.ravel(), 0, q, 0.5, gaps)
    beyond = np.maximum(np.maximum(corners[0].T - q, q - corners[1].T), 0.0)
    np.testing.assert_allclose(gaps, np.linalg.norm(beyond, axis=1), rtol=1e-15)
    assert bits == sum(1 << k for k in range(8) if gaps[k] <= 0.5)
    assert nearest == np.argmin(gaps)


@pytest.mark.parametrize('width', [1.0, 1e-2, 1e-4, 1e-7, 0.0])
def test_the_nearest_triangle_is_always_among_those_that_may_be(width):
    rng = np.random.default_rng(int(1e8 * width))
    for _ in range(200):
        corners = rng.normal(size=(8, 3, 3))
        corners[:, 2] = corners[:, 0] + rng.uniform(0, 1, (8, 1)) * (corners[:, 1] - corners[:, 0])
        corners[:, 2] += width * rng.normal(size=(8, 3))
        q = tuple(corners[0].mean(axis=0) + 10.0 ** rng.uniform(-12, 0) * rng.normal(size=3))
        packed = corners.reshape(8, 9).T.ravel().copy()
        bits = lanes.near_triangles(packed, 0, q, math.inf, LANE_ERROR * 10.0)
        away = [math.sqrt(squared_distance(one, q)) for one in corners]
        assert bits >> int(np.argmin(away)) & 1


@pytest.mark.parametrize(('name', 'cuts'), [('L', 1), ('U', 2), ('ring', 5), ('L', 12)])
def test_every_triangle_is_in_one_block_within_its_boxes(name, cuts):
    parameters = kernel_form(solid(name, cuts=cuts))[1]
    tree = tree_of(SOLID, parameters)
    found = lane_tree.lane_tree_of(tree)
    ends = [lane_tree.first_of_block(tree, found, k) for k in range(found.blocks + 1)]
    assert (ends[0], ends[-1]) == (0, tree.triangles)
    assert all(0 < size <= lanes.LANES for size in np.diff(ends))
    corners = parameters[tree.corners :][: 9 * tree.triangles].reshape(-1, 9)
    blocks = parameters[found.blocks_at :][: lanes.TRIANGLE_LANES * found.blocks]
    for block, first, last in zip(blocks.reshape(-1, 9, 8), ends, ends[1:], strict=False):
        np.testing.assert_array_equal(block.T[: last - first], corners[first:last])


@pytest.mark.parametrize(('name', 'cuts'), [('L', 1), ('ring', 3), ('U', 8)])
def test_the_walk_finds_all_that_are_nearest(name, cuts):
    parameters = kernel_form(solid(name, cuts=cuts))[1]
    tree = tree_of(SOLID, parameters)
    found = lane_tree.lane_tree_of(tree)
    corners = parameters[tree.corners :][: 9 * tree.triangles].reshape(-1, 3, 3)
    rng = np.random.default_rng(cuts)
    for q in (*rng.uniform(-1, 4, (30, 3)), (1.0, 1.0, 0.5), (0.5, 0.5, 0.5)):
        room, q = nearest_triangles.scratch_for(found, 64), tuple(map(float, q))
        count = nearest_triangles.nearest_triangles(parameters, tree, found, q, 5.0, room)
        away = np.array([math.sqrt(squared_distance(one, q)) for one in corners])
        expected = np.flatnonzero(away <= away.min() + 1e-13)
        assert sorted(room.triangles[:count]) == expected.tolist()
        np.testing.assert_allclose(room.away[:count], away.min(), rtol=0, atol=1e-14)


def test_where_there_is_no_room_it_says_so():
    parameters = kernel_form(solid('ring', cuts=3))[1]
    tree = tree_of(SOLID, parameters)
    found = lane_tree.lane_tree_of(tree)
    room = nearest_triangles.scratch_for(found, 2)
    count = nearest_triangles.nearest_triangles(
        parameters, tree, found, (1.0, 1.0, 1.0), 5.0, room
    )
    assert count == nearest_triangles.FULL
