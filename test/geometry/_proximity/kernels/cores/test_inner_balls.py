"""Balls within two cores: never deeper than a width of their overlap, exact where they fit."""

import math

import numpy as np
import pytest
from oracles.core_pairs import core_pair, core_widths
from oracles.forms import hull_of
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
)
from drake_geom_ros.geometry._proximity.kernels.cores import inner_balls
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    SPHERE,
)
from drake_geom_ros.geometry.shapes.primitives import for_queries
from truth.bodies.random_bodies import random_directions, random_rotation

SHAPES = [Box(0.2, 0.4, 0.6), Cylinder(0.2, 0.5), Ellipsoid(0.3, 0.2, 0.25), Capsule(0.1, 0.4)]
GRID = np.linspace(-0.8, 0.8, 41)


def pair_of(A, B, R_WA, R_WB, p):
    return core_pair(
        *(*for_queries(A).in_pairs, R_WA),
        *(*for_queries(B).in_pairs, R_WB, p),
    )


@pytest.mark.parametrize('A', SHAPES, ids=lambda shape: type(shape).__name__)
@pytest.mark.parametrize('B', SHAPES, ids=lambda shape: type(shape).__name__)
def test_no_point_is_deeper_than_any_width_of_the_overlap(A, B):
    rng = np.random.default_rng(0)
    for _ in range(10):
        p = rng.uniform(-0.2, 0.2, 3)
        pair = pair_of(A, B, random_rotation(rng), random_rotation(rng), p)
        least = core_widths(pair, random_directions(rng, 200)).min()
        for c in rng.uniform(-0.3, 0.3, (20, 3)):
            assert inner_balls.depth_in_both(pair, tuple(c), 0.0)[0] <= least + 1e-15
        assert inner_balls.deepest(pair, (0.1, 0.0, 0.0), tuple(p), 1.0) <= least + 1e-15


def test_a_corner_in_a_cylinder_is_as_deep_as_it_is_in_there():
    # The corner (0.1, 0.1, 0.1) of a box is 0.05 from the barrel.
    box, cylinder = Box(0.2, 0.2, 0.2), Cylinder(0.1, 1.0)
    p = (0.1 + 0.03, 0.1 + 0.04, 0.1)
    pair = pair_of(box, cylinder, np.eye(3), np.eye(3), p)
    a, b = (0.1, 0.1, 0.1), (0.1 - 0.03, 0.1 - 0.04, 0.1)
    depth, unique, c = inner_balls.depth_between(pair, a, b, 1e-12)
    assert depth == pytest.approx(0.05, abs=1e-16)
    assert unique
    assert c == a


def test_of_two_directions_as_short_neither_is_the_only_one():
    box, point = Box(2.0, 2.0, 2.0), Capsule(0.1, 0.2)
    pair = pair_of(box, point, np.eye(3), np.eye(3), (0.5, 0.5, 0.0))
    assert not inner_balls.depth_in_both(pair, (0.5, 0.5, 0.0), 1e-12)[1]
    assert inner_balls.depth_in_both(pair, (0.5, 0.4, 0.0), 1e-12)[1]
    assert inner_balls.depth_in_both(pair, (0.5, 0.4, 0.0), 1e-12)[0] == 0.5 - 0.1


def test_the_deepest_point_is_found_along_an_edge():
    # The axis of the cylinder goes through an edge of the box: a ring of equal directions.
    box, cylinder = Box(0.2, 0.4, 2.0), Cylinder(0.3, 2.0)
    pair = pair_of(box, cylinder, np.eye(3), np.eye(3), (0.1, 0.2, 0.1))
    corner, off = (0.1, 0.2, -0.85), (-0.1, 0.0, -0.85)
    assert inner_balls.deepest(pair, corner, off, 2.0) == pytest.approx(0.3, abs=1e-15)


@pytest.mark.parametrize('A', SHAPES, ids=lambda shape: type(shape).__name__)
@pytest.mark.parametrize('B', SHAPES[1:3], ids=lambda shape: type(shape).__name__)
def test_the_deepest_point_of_a_line_is_found_up_to_a_17000th_of_it(A, B):
    rng = np.random.default_rng(1)
    pair = pair_of(A, B, random_rotation(rng), random_rotation(rng), rng.uniform(-0.2, 0.2, 3))
    c, u = rng.uniform(-0.1, 0.1, 3), random_rotation(rng)[0]
    depth, at = inner_balls.deepest_along(pair, tuple(c), tuple(u), 0.8)
    assert inner_balls.depth_in_both(pair, at, 0.0)[0] == depth
    way = np.dot(np.subtract(at, c), u)
    np.testing.assert_allclose(c + way * u, at, rtol=0, atol=1e-15)
    # No depth changes by more than the way, and there are two.
    along = [inner_balls.depth_in_both(pair, tuple(c + t * u), 0.0)[0] for t in GRID]
    assert depth >= max(along) - 2.0 * 1.6 / 17000.0


@pytest.mark.parametrize(
    ('kind', 'shape', 'q', 'depth', 'unique'),
    [
        (BOX, [1.0, 2.0, 3.0], (0.25, 1.5, 0.0), 0.5, True),
        (BOX, [1.0, 2.0, 3.0], (0.5, 1.5, 0.0), 0.5, False),
        (BOX, [1.0, 2.0, 3.0], (1.0, 0.0, 0.0), 0.0, False),
        (BOX, [1.0, 2.0, 3.0], (1.0, 2.0, 7.0), -4.0, False),
        (CYLINDER, [1.0, 2.0], (0.0, 0.25, 1.5), 0.5, True),
        (CYLINDER, [1.0, 2.0], (0.0, 0.5, -1.5), 0.5, False),
        (ELLIPSOID, [1.0, 1.0, 0.5], (0.0, 0.0, 0.125), 0.125, True),  # less a ball of 0.25 m
        (CAPSULE, [0.5, 2.0], (0.0, 3.0, -6.0), -5.0, False),  # a segment
        (SPHERE, [0.5], (2.0, 3.0, 6.0), -7.0, False),  # a point
        (CONVEX, [1.0, 0.0, 0.0, 0.0], (0.0, 0.0, 0.0), -math.inf, False),
    ],
)
def test_the_depth_of_a_point_in_a_core(kind, shape, q, depth, unique):
    found = inner_balls.depth_of_point(kind, np.array(shape), q, 1e-12)
    assert found == (pytest.approx(depth, rel=1e-15, abs=1e-15), unique)


def test_of_a_hull_the_deepest_vertex_is_told():
    rng = np.random.default_rng(2)
    for _ in range(20):
        vertices, R, R_hull = rng.normal(size=(5, 3)), random_rotation(rng), random_rotation(rng)
        hull, p, shape = hull_of(vertices), rng.normal(size=3), np.ones(3)
        seen = (p + vertices @ R_hull.T) @ R
        depths = [inner_balls.depth_of_point(BOX, shape, tuple(q), 0.0)[0] for q in seen]
        found = inner_balls.deepest_vertex(BOX, shape, R, hull, R_hull, tuple(p))
        assert found == pytest.approx(max(depths), abs=1e-14)
        pair = core_pair(BOX, shape, R, CONVEX, hull, R_hull, p)
        assert inner_balls.deepest(pair, (0.0, 0.0, 0.0), tuple(p), 1.0) == found


@pytest.mark.parametrize('step', [0.0, 1e-15, 1e-12])
@pytest.mark.parametrize(
    ('A', 'B', 'p_AB', 'depth'),
    [
        (Box(1, 1, 1), Cylinder(0.5, 2), [0.5, 0.5, 0], 0.5),
        (Box(1, 1, 1), Ellipsoid(0.5, 0.5, 1.0), [0.5, 0.5, 0], 0.5),
        (Box(1, 2, 1), Ellipsoid(0.5, 0.5, 0.5), [0.5, 1.0, 0.5], 0.5),
    ],
)
def test_a_ring_of_equal_directions_keeps_the_promise(A, B, p_AB, depth, step):
    scene = ShapeScene(A, B).posed([0, 0, 0], p_AB + step * np.array([0.6, -0.5, 0.3]))
    answer = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert abs(answer.distance[0] + depth) <= 2.0 * step + answer.error_bound[0]
    assert not answer.breaks_promise().any()
