"""Boxes of cores, gaps of boxes, and walks over two trees, against all pairs of leaves."""

import itertools

import numpy as np
import pytest
from oracles.forms import hull_of, kernel_form
from oracles.solids import solid

from drake_geom_ros.cross_check.surfaces import support_value_of
from drake_geom_ros.geometry._proximity.kernels.solids import solid as tree
from drake_geom_ros.geometry._proximity.kernels.trees import boxes, walks
from drake_geom_ros.geometry._proximity.kinds import BOX, CONVEX, CYLINDER, SOLID
from truth.bodies.random_bodies import random_rotation

L = kernel_form(solid('L', cuts=2))[1]


@pytest.mark.parametrize(('kind', 'size'), [(BOX, [0.3, 0.2, 0.1]), (CYLINDER, [0.3, 0.5])])
def test_the_box_of_a_core_touches_it_on_every_side(kind, size):
    box = tree.box_of_core(kind, np.array(size))
    assert box.middle == (0.0, 0.0, 0.0)
    assert box.half == tuple(support_value_of((kind, size), n) for n in np.eye(3))


def test_the_box_of_a_hull_is_between_its_ends():
    vertices = np.random.default_rng(1).normal(size=(7, 3))
    box = tree.box_of_core(CONVEX, hull_of(vertices))
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    np.testing.assert_allclose(box.middle, (low + high) / 2, rtol=0, atol=1e-15)
    np.testing.assert_allclose(box.half, (high - low) / 2, rtol=0, atol=1e-15)


def test_the_middle_of_a_triangle_is_the_mean_of_its_corners():
    found = tree.tree_of(SOLID, L)
    for j in range(found.triangles):
        at = found.corners + 9 * j
        corners = L[at : at + 9].reshape(3, 3)
        middle = tree.middle_of_triangle(L, found, j)
        assert middle == pytest.approx(corners.mean(axis=0), abs=1e-15)


@pytest.mark.parametrize('axis', range(3))
@pytest.mark.parametrize('turned', [False, True])
def test_the_gap_of_boxes_is_that_along_an_axis_of_either(axis, turned):
    rng = np.random.default_rng(axis)
    R = random_rotation(rng)
    one = boxes.NodeBox((0.1, 0.2, 0.3), (0.5, 0.4, 0.3))
    other = boxes.NodeBox((-0.3, 0.1, 0.2), (0.2, 0.6, 0.7))
    n = R[:, axis] if turned else np.eye(3)[axis]
    reach = support_value_of((BOX, one.half), R.T @ n)
    reach += support_value_of((BOX, other.half), n)
    for gap in (0.5, 1e-3):
        p = np.array(other.middle) + (reach + gap) * n - R @ one.middle
        found = boxes.separation_of_turned_boxes(one, R, tuple(p), other)
        assert gap - 1e-14 <= found
        # It is a lower bound of the distance of any two points of theirs.
        u, v = rng.uniform(-1, 1, (2, 4000, 3))
        a = p + (one.middle + one.half * u) @ R.T
        assert found <= np.linalg.norm(a - (other.middle + other.half * v), axis=1).min()
    assert boxes.separation_of_turned_boxes(one, R, tuple(-R @ one.middle), other) == 0.0


@pytest.mark.parametrize('limit', [0.0, 0.3, 100.0])
def test_a_walk_hands_out_all_leaves_within_its_limit_once(limit):
    R, p = random_rotation(np.random.default_rng(5)), (0.7, 0.2, 0.6)
    A, B = tree.body_of(SOLID, L, R), tree.solid_of(L)
    path, top, told, left_out = walks.walk(A, B, p), 1, [], np.inf
    while True:
        top, i, j, skipped = walks.next_leaves(A, B, p, path, top, limit)
        left_out = min(left_out, skipped)
        if i < 0:
            break
        told.append((i, j))
    assert len(told) == len(set(told))
    assert left_out > limit

    def box(body, leaf):
        return boxes.box_of_node(body.shape, body.tree, leaf + body.tree.leaves - 1)

    leaves = range(A.tree.leaves)
    for i, j in set(itertools.product(leaves, leaves)) - set(told):
        assert (
            boxes.separation_of_turned_boxes(box(A, i), R, p, box(B, j)) > limit - 1e-14
        )  # rounding
