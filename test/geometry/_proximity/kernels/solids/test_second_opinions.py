"""Solids as libigl and Manifold see them: where points are, and what two have in common.

Both are on PyPI: ``requirements/peers.txt`` has the version of libigl, ``lock.txt`` that of
Manifold. Without them nothing is asked here.
"""

import numpy as np
import pytest
import trimesh
from numba import config
from oracles.forms import HERE, in_order, row_of
from oracles.hard_cases.interlocked import CELLS, of_cells, polycube

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kinds import OPEN
from truth.bodies.random_bodies import random_rotation

PAIRS = 4 if config.DISABLE_JIT else 60
POINTS = 20 if config.DISABLE_JIT else 400


def random_solid(rng):
    """A polycube, or a torus with dents, none of it convex."""
    if rng.random() < 0.5:
        return of_cells(polycube(rng, 3, int(rng.integers(4, 12))), CELLS)
    mesh = trimesh.creation.torus(1.0, 0.3, major_sections=14, minor_sections=9)
    dents = 1.0 + 0.1 * np.sin(5.0 * mesh.vertices[:, :1] + rng.uniform(0, 6))
    return Body('Solid', mesh.vertices * dents * [1, 1, 1.5], triangles=mesh.faces)


def in_world(body):
    """Vertices in World (n, 3) and triangles (m, 3), as arrays."""
    return np.asarray(body.size) @ body.R.T + body.p, np.asarray(body.triangles)


def test_points_are_as_far_in_and_out_as_libigl_says():
    igl = pytest.importorskip('igl')
    rng = np.random.default_rng(31)
    inside = 0
    for _ in range(6):
        body = random_solid(rng)
        vertices, triangles = in_world(body)
        triangles = triangles.astype(np.int64)
        low, high = vertices.min(axis=0) - 0.3, vertices.max(axis=0) + 0.3
        points = rng.uniform(low, high, (POINTS // 6, 3))
        by_winding = igl.SIGNED_DISTANCE_TYPE_WINDING_NUMBER
        distances = igl.signed_distance(points, vertices, triangles, sign_type=by_winding)[0]
        numbers = igl.winding_number(vertices, triangles, points)
        told = zip(points, np.ravel(distances), np.ravel(numbers), strict=True)
        for q, distance, number in told:
            out = row_of(Body('Sphere', (0.0,), p=q), body)
            assert out[calling.DISTANCE] == pytest.approx(distance, abs=1e-9)
            assert (out[calling.DISTANCE] < 0.0) == (number > 0.5)
            inside += number > 0.5
    assert inside > POINTS // 20


def manifold_of(manifold3d, body):
    """A body as Manifold takes it."""
    vertices, triangles = in_world(body)
    mesh = manifold3d.Mesh64(
        np.ascontiguousarray(vertices), np.ascontiguousarray(triangles, dtype=np.uint64)
    )
    return manifold3d.Manifold(mesh)


def is_manifold(manifold3d, *bodies):
    """Whether Manifold takes them: not where four faces meet in an edge."""
    return all(manifold_of(manifold3d, x).status() == manifold3d.Error.NoError for x in bodies)


def common(manifold3d, a, b):
    """The volume that two bodies have in common [m^3]."""
    return (manifold_of(manifold3d, a) ^ manifold_of(manifold3d, b)).volume()


def test_what_overlaps_has_a_volume_in_common_and_the_way_out_parts_it():
    manifold3d = pytest.importorskip('manifold3d')
    rng = np.random.default_rng(32)
    told = {True: 0, False: 0}
    for _ in range(PAIRS):
        A, B = random_solid(rng), random_solid(rng)
        A = A.placed(random_rotation(rng), rng.uniform(-1.5, 2.5, 3))
        A, B = in_order(A, B)
        out = row_of(A, B)
        distance, bound = out[calling.DISTANCE], out[calling.ERROR_BOUND]
        volume = common(manifold3d, A, B) if is_manifold(manifold3d, A, B) else 0.0
        if abs(distance) < 1e-6 or not is_manifold(manifold3d, A, B):
            continue
        told[distance < 0.0] += 1
        assert (volume > 1e-12) == (distance < 0.0), (distance, bound, volume)
        if distance < 0.0:
            parted = A.at(A.p - (distance - 1e-9) * out[1:4])
            assert common(manifold3d, parted, B) <= 1e-9
            if out[calling.METHOD] != OPEN:  # less than it may be at least does not part them
                short = max(-distance - bound - 1e-6, 0.0)
                assert common(manifold3d, A.at(A.p + 0.99 * short * out[1:4]), B) > 0.0
    assert min(told.values()) >= PAIRS // 10


def test_polycubes_on_their_lattice_touch_where_manifold_finds_no_volume():
    """Places of halves: many are flush, and what is in common there is told without error."""
    manifold3d = pytest.importorskip('manifold3d')
    rng = np.random.default_rng(33)
    flush = 0
    for _ in range(PAIRS):
        A, B = (of_cells(polycube(rng, 3, int(rng.integers(4, 10))), CELLS) for _ in range(2))
        A, B = in_order(A.at(rng.integers(-6, 7, 3) / 2.0), B)  # convex ones are hulls
        if not is_manifold(manifold3d, A, B):
            continue
        distance = row_of(A, B)[calling.DISTANCE]
        volume = common(manifold3d, A, B)
        assert (volume > 1e-9) == (distance < -1e-9)
        flush += abs(distance) < 1e-12
        R = random_rotation(rng)
        turned = row_of(A.moved(R, HERE), B.moved(R, HERE))
        if volume > 1e-9:
            assert turned[calling.DISTANCE] < -1e-9
        else:
            assert turned[calling.DISTANCE] + turned[calling.ERROR_BOUND] >= -1e-12
    assert flush
