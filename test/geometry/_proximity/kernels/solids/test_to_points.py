"""Points against solids: distance and side, against fractions; no digit depends on the others."""

from functools import cache

import numpy as np
import pytest
import trimesh
from mpmath import mp
from oracles.exact_surfaces import DIGITS, signed_distance
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import Mesh, MeshData, Sphere
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies import grids
from truth.bodies.random_bodies import random_directions, random_rotation


def _mesh(cells, lines, cuts=1):
    vertices, triangles = grids.surface(cells, [np.array(line) for line in lines], cuts)
    return np.array(vertices), np.array(triangles)


def _sheared(cells, seed):
    """A solid of slanted needles: no face is along an axis, and no two are in one plane."""
    vertices, triangles = _mesh(cells, [np.arange(8.0)] * 3)
    shear = np.random.default_rng(seed).normal(size=(3, 3)) * [1.0, 1e-4, 30.0]
    return vertices @ shear * np.sign(np.linalg.det(shear)), triangles


def _cavity():
    """A cube around a hollow ball: its middle is as far from every triangle."""
    ball = trimesh.creation.icosphere(2, 0.25)
    vertices, triangles = _mesh(grids.CUBE, [np.array([-0.5, 0.5])] * 3)
    faces = np.vstack((triangles, np.array(ball.faces)[:, ::-1] + len(vertices)))
    return np.vstack((vertices, ball.vertices)), faces


SOLIDS = {
    'flat': lambda: _mesh(grids.L, [[0.0, 1.5, 3.0], [0.0, 150.0, 300.0], [0.0, 0.03]]),
    'corner': lambda: _mesh(grids.CORNER, [[0.1, 0.2, 0.3]] * 3, cuts=2),
    'in map coordinates': lambda: _mesh(
        grids.U, [5e5 + np.arange(4.0), 4e6 + np.arange(3.0), [0.0, 1.0]]
    ),
    'needles': lambda: _sheared(grids.L, 1),
    'more needles': lambda: _sheared(grids.RING, 2),
    'cavity': _cavity,
}


@cache
def solid(name):
    """Corners (n, 3, 3) of a solid, and its scene."""
    vertices, triangles = SOLIDS[name]()
    scene = ShapeScene(Mesh.FromMeshData(MeshData(vertices, triangles)), solid=True)
    return vertices[triangles], scene


def places(corners, count, seed):
    """Points beside the faces, edges and corners of a surface: 1e-17 to 1 of its size away."""
    rng = np.random.default_rng(seed)
    size = float(np.ptp(corners, axis=(0, 1)).max())
    some = corners[rng.integers(len(corners), size=count)]
    shares = rng.dirichlet([1.0, 1.0, 1.0], size=count)
    shares[::4, 2] = 0.0  # on an edge
    shares[1::8] = [1.0, 0.0, 0.0]  # at a corner
    shares /= shares.sum(axis=1, keepdims=True)
    on_surface = (some * shares[:, :, None]).sum(axis=1)
    ways = np.cross(some[:, 1] - some[:, 0], some[:, 2] - some[:, 0])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    ways[2::4] = random_directions(rng, count)[2::4]
    lengths = size * 10.0 ** rng.uniform(-17, 0, (count, 1)) * rng.choice([-1, 1], (count, 1))
    return on_surface + lengths * ways


def outside_its_bound(corners, found, points):
    """By how many bounds each answer is beyond its own."""
    with mp.workdps(DIGITS):
        truths = [signed_distance(corners, q) for q in points]
        off = [abs(d - truth) for d, truth in zip(found.distance, truths, strict=True)]
        return [float(o / e) for o, e in zip(off, found.error_bound, strict=True)]


@pytest.mark.parametrize('name', SOLIDS)
def test_no_point_beside_a_surface_is_outside_its_bound(name):
    corners, scene = solid(name)
    points = places(corners, 40 if name == 'cavity' else 300, seed=3)
    found = scene.posed([0, 0, 0]).query.ComputeSignedDistanceToPoint(points)
    assert max(outside_its_bound(corners, found, points)) <= 1.0
    # And the bound is rounding, of the surface's size and not of its coordinates', but for poses.
    size = float(np.ptp(corners, axis=(0, 1)).max())
    roundings = 1e-14 * size + 1e-15 * np.abs(points).max()
    assert (found.error_bound <= 8.0 * roundings).all()


def test_beneath_a_face_of_a_large_flat_solid_the_sign_is_in_the_bound():
    corners, scene = solid('flat')
    rng = np.random.default_rng(1)
    depths = 10.0 ** rng.uniform(np.log10(3e-15), -9, 400)
    points = np.column_stack((rng.uniform(0, 1.5, 400), rng.uniform(0, 300, 400), 0.03 - depths))
    found = scene.posed([0, 0, 0]).query.ComputeSignedDistanceToPoint(points)
    assert max(outside_its_bound(corners, found, points)) <= 1.0


def test_of_a_ball_smaller_than_rounding_the_sign_is_in_the_bound_too():
    corners, _ = solid('flat')
    mesh = Mesh.FromMeshData(MeshData(*SOLIDS['flat']()))
    scene, radius = ShapeScene(mesh, Sphere(1e-14), solid=True), 1e-14
    for depth in 10.0 ** np.linspace(-14, -10, 40):
        p = [0.4, 100.0, 0.03 - depth]
        pair = scene.pair([0, 0, 0], p)
        truth = float(signed_distance(corners, p)) - radius
        assert abs(pair.distance - truth) <= pair.error_bound


@pytest.mark.parametrize('name', ['flat', 'corner', 'needles'])
def test_the_pose_is_in_the_bound(name):
    corners, scene = solid(name)
    rng = np.random.default_rng(5)
    R, p = random_rotation(rng), rng.normal(size=3)
    points = places(corners, 60, seed=6)
    query = scene.posed(RigidTransform(RotationMatrix(R), p)).query
    found = query.ComputeSignedDistanceToPoint(points @ R.T + p)
    assert max(outside_its_bound(corners, found, points)) <= 1.0


def test_as_many_triangles_as_there_are_may_be_the_nearest():
    corners, scene = solid('cavity')
    found = scene.posed([0, 0, 0]).query.ComputeSignedDistanceToPoint(np.zeros((1, 3)))
    assert max(outside_its_bound(corners, found, np.zeros((1, 3)))) <= 1.0
    assert found.distance[0] > 0.0
    assert not found.is_grad_W_unique[0]


@pytest.mark.parametrize('name', SOLIDS)
def test_no_digit_depends_on_the_points_asked_beside_it(name):
    corners, scene = solid(name)
    query = scene.posed([0, 0, 0]).query
    points = places(corners, 100, seed=7)
    together = query.ComputeSignedDistanceToPoint(points)
    backwards = query.ComputeSignedDistanceToPoint(points[::-1])
    columns = 'distance', 'error_bound', 'grad_W', 'p_GN', 'is_grad_W_unique'
    for column in columns:
        one, other = getattr(together, column), getattr(backwards, column)
        np.testing.assert_array_equal(one, other[::-1])
        alone = [getattr(query.ComputeSignedDistanceToPoint(q), column)[0] for q in points[::9]]
        np.testing.assert_array_equal(one[::9], alone)


def test_the_nearest_point_and_the_gradient_belong_together():
    corners, scene = solid('corner')
    points = places(corners, 300, seed=9)
    found = scene.posed([0, 0, 0]).query.ComputeSignedDistanceToPoint(points)
    clear = np.abs(found.distance) > 1e-9
    ways = (points - found.p_GN)[clear]
    np.testing.assert_allclose(
        ways, (found.distance[:, None] * found.grad_W)[clear], rtol=0, atol=1e-15
    )
    np.testing.assert_allclose(np.linalg.norm(found.grad_W, axis=1), 1.0, rtol=0, atol=1e-14)
    assert clear.sum() > 50
