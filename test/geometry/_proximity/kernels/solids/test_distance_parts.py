"""Slabs between leaves, pushes kept by direction, leaves that are close: against all there are."""

import itertools

import numpy as np
import pytest
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.cross_check.surfaces import support_value_of
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF, CLOSED, OVERLAP
from drake_geom_ros.geometry._proximity.kernels.solids import contacts, leaves
from drake_geom_ros.geometry._proximity.kernels.solids.separating_axes import widest_slab
from drake_geom_ros.geometry._proximity.kernels.solids.solid import SolidPair, body_of, solid_of
from drake_geom_ros.geometry._proximity.kinds import BOX, SOLID
from truth.bodies.random_bodies import random_rotation

L = kernel_form(solid('L'))[1]


def _corners(body, j):
    at = body.tree.corners + 9 * j
    return body.shape[at : at + 9].reshape(3, 3)


@pytest.mark.parametrize('p', [(1.5, 0.2, 0.3), (0.4, 0.1, -0.05), (3.0, -2.0, 1.0)])
def test_the_widest_slab_between_a_box_and_a_triangle_is_their_distance_or_depth(p):
    """Of a box and a triangle the axes tried are all there are; negative where they overlap."""
    R, half, B = random_rotation(np.random.default_rng(3)), np.array([0.3, 0.2, 0.1]), solid_of(L)
    A = body_of(BOX, half, R)
    for j in range(B.tree.triangles):
        corners = _corners(B, j) - p
        edges = np.roll(corners, -1, axis=0) - corners
        axes = [np.cross(edges[0], edges[1])]
        axes += [np.cross(e, u) for e, u in itertools.product(edges, R.T)]
        widths = []
        for n in axes:
            for m in (n, -n):
                m = m / np.linalg.norm(m)
                widths.append((corners @ m).min() - support_value_of((BOX, half), R.T @ m))
        width, n = widest_slab(A, 0, B, j, p, 1e-15, np.inf)
        assert width == pytest.approx(max(widths), abs=1e-14)
        assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-15)
        assert (corners @ n).min() - support_value_of((BOX, half), R.T @ n) == pytest.approx(width)


@pytest.mark.parametrize('p', [(0.9, 0.2, 0.1), (2.0, -0.3, 0.7)])
def test_the_widest_slab_between_two_triangles_is_along_a_normal_or_across_two_edges(p):
    """Of triangles these are all axes; negative where they cross."""
    R, B = random_rotation(np.random.default_rng(7)), solid_of(L)
    A = body_of(SOLID, L, R)
    for i, j in itertools.product(range(A.tree.triangles), range(0, B.tree.triangles, 5)):
        mine, its = _corners(A, i) @ R.T, _corners(B, j) - p
        edges = [np.roll(corners, -1, axis=0) - corners for corners in (mine, its)]
        axes = [np.cross(e[0], e[1]) for e in edges]
        axes += [np.cross(e, u) for e, u in itertools.product(*edges)]
        units = [s * n / np.linalg.norm(n) for n in axes for s in (1, -1)]
        width, n = widest_slab(A, i, B, j, p, 1e-15, np.inf)
        widths = [(its @ u).min() - (mine @ u).max() for u in units]
        assert width == pytest.approx(max(widths), abs=1e-14)
        assert (its @ n).min() - (mine @ n).max() == pytest.approx(width, abs=1e-14)


@pytest.mark.parametrize('limit', [0.0, 1e-9, 0.4])
def test_axes_and_gjk_say_the_same_of_triangles_within_a_limit(limit):
    """Whether they cross, are beyond it, or how near they are."""
    pair = SolidPair(
        body_of(SOLID, L, random_rotation(np.random.default_rng(9))),
        solid_of(L),
        (0.7, 0.3, 0.2),
        8.0,
        1e-9,
        0.0,
    )
    told = set()
    for i, j in itertools.product(range(pair.A.tree.triangles), repeat=2):
        expected = leaves.separation_of_leaves(pair, i, j, (1.0, 0.0, 0.0), limit)
        found = leaves.separation_within(pair, i, j, (1.0, 0.0, 0.0), limit)
        assert (found.end == OVERLAP) == (expected.end == OVERLAP)
        assert (found.end == CLOSED) <= (expected.end == CLOSED)
        if expected.end == CLOSED and expected.upper <= limit:
            assert found == expected
        assert found.end != BEYOND_CUTOFF or limit < found.lower
        told.add((found.end, expected.end))
    assert {(OVERLAP, OVERLAP), (BEYOND_CUTOFF, BEYOND_CUTOFF)} <= told
    assert limit < 0.1 or (CLOSED, CLOSED) in told


def _lies_at(height, body, j):
    return (_corners(body, j)[:, 2] == height).all()


@pytest.mark.parametrize('off', [-1e-13, 0.0, 1e-13])
def test_of_faces_that_lie_flush_the_slab_is_into_the_other_body(off):
    """One L on another, in it or above it by less than rounding may be."""
    A, B, p = body_of(SOLID, L, np.eye(3)), solid_of(L), (0.0, 0.0, 1.0 + off)
    pairs = itertools.product(range(A.tree.triangles), repeat=2)
    faces = [(i, j) for i, j in pairs if _lies_at(0.0, A, i) and _lies_at(1.0, B, j)]
    assert faces
    for i, j in faces:
        width, n = widest_slab(A, i, B, j, p, 1e-12, np.inf)
        assert width >= abs(off) - 1e-15
        if width <= 1e-12:  # they have more than an edge in common
            assert n == (0.0, 0.0, -1.0)


def test_pushes_are_kept_by_direction_the_longest_of_each_while_there_is_room():
    slots, count = np.zeros((2, 4)), 0
    x, y, z = (tuple(n) for n in np.eye(3))
    for m, s in ((x, 1.0), (x, 3.0), (x, 2.0), (y, 5.0), (z, 7.0), (y, 6.0)):
        count = contacts.add_slot(slots, count, m, s)
    assert count == 2
    np.testing.assert_array_equal(slots, [[*x, 3.0], [*y, 6.0]])


def test_pairs_of_leaves_that_are_close_are_told_once_each():
    A, B = body_of(SOLID, L, np.eye(3)), solid_of(L)
    p = (0.0, 0.0, 1.0)  # one on the other
    found = np.full((1000, contacts.CLOSE_WIDTH), -1.0)
    pair, down = SolidPair(A, B, p, 8.0, 1e-9, 0.0), (0.0, 0.0, -1.0)
    count = contacts.close_pairs(pair, down, 1e-12, found)
    told = {(int(i), int(j)) for i, j in found[:count, :2]}
    assert len(told) == count
    assert (found[count:] == -1).all()
    expected, some = set(), range(0, A.tree.triangles, 6)
    for i, j in itertools.product(some, range(B.tree.triangles)):
        gap = leaves.separation_of_leaves(pair, i, j, down, 1e-12)
        if gap.upper <= 1e-12:
            expected.add((i, j))
    assert {pair for pair in told if pair[0] in some} == expected != set()
