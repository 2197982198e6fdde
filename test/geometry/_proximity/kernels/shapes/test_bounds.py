"""Intervals from bounds alone contain the truth, wherever a hull lies about its origin."""

import numpy as np
import pytest
from oracles.forms import hull_of, signed_distance

from drake_geom_ros.cross_check.surfaces import support_value_of
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
    PAIR_WIDTH,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.shapes import bounds
from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import PosedShape, shape_radii
from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import hull_parameters
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.pairs.bounds_alone import bounding_interval
from drake_geom_ros.geometry.meshes.source import MeshData, coarse_hull_of, hull_surface
from truth.bodies.random_bodies import random_directions, random_rotation


def inner_radius(kind, shape):
    return shape_radii(np.array([kind]), np.array([0, len(shape)]), shape)[1][0]


@pytest.mark.parametrize('beside', [0.0, 0.05, 0.3])
def test_a_hull_beside_its_origin(beside):
    rng = np.random.default_rng(1)
    for _ in range(6):
        vertices = rng.uniform(-0.1, 0.1, (8, 3)) + np.array([beside, 0.0, 0.0])
        hull, ball = hull_of(vertices), np.array([0.1])
        R, p = random_rotation(rng), rng.uniform(-0.02, 0.02, 3)
        out = np.zeros(PAIR_WIDTH)
        bounding_interval(
            PosedShape(SPHERE, ball, np.eye(3), inner_radius(SPHERE, ball)),
            PosedShape(CONVEX, hull, R, inner_radius(CONVEX, hull)),
            p,
            out,
        )
        poses = (np.eye(3), np.zeros(3)), (R, p)
        phi, _ = signed_distance((SPHERE, ball), poses[0], (CONVEX, hull), poses[1])
        assert abs(out[DISTANCE] - phi) <= out[ERROR_BOUND]


@pytest.mark.parametrize('count', [4, 9, 64, 301])
def test_the_box_of_a_hull_is_that_of_its_vertices(count):
    rng = np.random.default_rng(count)
    vertices = rng.uniform(-0.1, 0.2, (count, 3))
    hull, R, half = hull_of(vertices), random_rotation(rng), np.zeros(3)
    bounds.box_half_extents(CONVEX, hull, R, half)
    np.testing.assert_allclose(half, np.abs(vertices @ R.T).max(axis=0), rtol=1e-15)


SIZES = {
    SPHERE: [0.3],
    BOX: [0.3, 0.5, 0.7],
    CAPSULE: [0.2, 0.6],
    CYLINDER: [0.4, 0.25],
    ELLIPSOID: [0.3, 0.5, 0.7],
}


@pytest.mark.parametrize('kind', SIZES)
def test_support_values_are_those_of_the_shapes(kind):
    rng, size = np.random.default_rng(2), np.array(SIZES[kind])
    for n in random_rotation(rng):
        expected = support_value_of((kind, size), n)
        assert bounds.support_value(kind, size, tuple(n)) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ('kind', 'radius'),
    [(SPHERE, 0.3), (BOX, 0.3), (CAPSULE, 0.2), (CYLINDER, 0.25), (ELLIPSOID, 0.3)],
)
def test_the_ball_inside_touches_the_nearest_face(kind, radius):
    for turn in range(3):
        size = np.array(SIZES[kind])
        if kind in (BOX, ELLIPSOID):
            size = np.roll(size, turn)
        assert inner_radius(kind, size) == radius


@pytest.mark.parametrize('kind', SIZES)
def test_intervals_are_those_of_the_balls_inside_and_of_the_planes(kind):
    """Beside a ball, along the line of centres; over a plane they are exact."""
    rng, size = np.random.default_rng(3), np.array(SIZES[kind])
    for away in (2.0, 0.1, 0.0):
        R, ball, out = random_rotation(rng), np.array([0.25]), np.zeros(PAIR_WIDTH)
        n = random_rotation(rng)[0]
        body = PosedShape(kind, size, R, inner_radius(kind, size))
        bounding_interval(body, PosedShape(SPHERE, ball, np.eye(3), 0.25), away * n, out)
        # Concentric, the x axis of A stands for the line of centres.
        upper = away - body.inner_radius - 0.25
        lower = away - support_value_of((kind, size), R.T @ (n if away else R[:, 0])) - 0.25
        assert out[DISTANCE] == pytest.approx(0.5 * (lower + upper), abs=1e-15)
        assert out[ERROR_BOUND] == pytest.approx(0.5 * (upper - lower), abs=1e-14)
        plane = PosedShape(HALF_SPACE, np.zeros(0), random_rotation(rng), 0.0)
        nhat = plane.R_WG[:, 2]
        height = away * (n @ nhat) - support_value_of((kind, size), -R.T @ nhat)
        for A, B, p, side in ((plane, body, away * n, -1.0), (body, plane, -away * n, 1.0)):
            bounding_interval(A, B, p, out)
            assert out[DISTANCE] == pytest.approx(height, abs=1e-15)
            assert out[ERROR_BOUND] < 1e-14
            assert out[NORMAL : NORMAL + 3] == pytest.approx(side * nhat, abs=1e-15)
            witnesses = out[WITNESS_A : WITNESS_A + 3] - out[WITNESS_B : WITNESS_B + 3]
            assert witnesses == pytest.approx(height * side * nhat, abs=1e-15)


def test_the_vertex_towards_a_ball_bounds_from_above():
    corners = np.array(np.meshgrid(*[[-0.1, 0.1]] * 3)).T.reshape(-1, 3)
    hull, ball, out = hull_of(corners), np.array([0.25]), np.zeros(PAIR_WIDTH)
    bodies = PosedShape(CONVEX, hull, np.eye(3), 0.0), PosedShape(SPHERE, ball, np.eye(3), 0.25)
    p = np.array([2.0, 3.0, 6.0])
    upper = np.linalg.norm(p - 0.1) - 0.25
    for A, B, p_AB in ((*bodies, p), (*bodies[::-1], -p)):
        bounding_interval(A, B, p_AB, out)
        assert out[DISTANCE] + out[ERROR_BOUND] == pytest.approx(upper, abs=1e-13)


@pytest.mark.parametrize('count', [130, 700])
@pytest.mark.parametrize('thickness', [1.0, 1e-3])
def test_the_box_of_a_coarse_hull_and_its_reach_holds_all_vertices(count, thickness):
    rng = np.random.default_rng(count)
    mesh = MeshData(0.2 * random_directions(rng, count) * [1.0, 1.0, thickness] + [0.1, 0.0, 0.3])
    vertices, triangles = hull_surface(mesh, np.ones(3))
    coarse, half = coarse_hull_of(mesh, np.ones(3)), np.zeros(3)
    hull = hull_parameters(vertices, triangles, coarse)
    for _ in range(20):
        R = random_rotation(rng)
        bounds.box_half_extents(CONVEX, hull, R, half)
        least = np.abs(vertices @ R.T).max(axis=0)
        assert (half >= least).all()
        assert (half <= least + coarse.reach * (1.0 + 1e-12)).all()
