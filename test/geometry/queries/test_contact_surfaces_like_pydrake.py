"""Contact surfaces beside pydrake's: on its meshes face by face, on ours in area and force."""

import logging
import os

import numpy as np
import pytest
from oracles.contact_scenes import Body, query_of, surfaces

import drake_geom_ros.geometry as ours
from drake_geom_ros.geometry._contact_surfaces import packing
from drake_geom_ros.geometry._contact_surfaces.arrays import (
    AREA,
    FIRST_MOMENT,
    FORCE,
    LAST,
    PRESSES,
    PRESSURE,
    SWALLOWED,
    Geometries,
)
from drake_geom_ros.geometry._contact_surfaces.asking import Posed, surfaces_of
from drake_geom_ros.geometry.meshes.volume_mesh import OUTER_FACES
from drake_geom_ros.geometry.meshes.volume_surface import neighbours_of
from truth.bodies.random_bodies import random_rotation

theirs = pytest.importorskip('pydrake.geometry', exc_type=ImportError)
logging.getLogger('drake').setLevel(logging.ERROR)
SIZES = {'Sphere': 1, 'Box': 3, 'Cylinder': 2, 'Capsule': 2, 'Ellipsoid': 3}
# CONTACT_POSES=2000 takes a minute: docs/contact_surfaces.md says what it shows.
POSES = int(os.environ.get('CONTACT_POSES', '350'))
# What each of the two is, with its modulus; 0 is rigid.
PAIRS = [('body', 1e5, 'body', 2e5), ('body', 1e5, 'body', 0.0), ('body', 0.0, 'body', 1e5)]
PAIRS += [('body', 1e5, 'HalfSpace', 0.0), ('HalfSpace', 0.0, 'body', 1e5)]
PAIRS += [('body', 0.0, 'HalfSpace', 1e5), ('HalfSpace', 1e5, 'body', 0.0)]


def random_body(random, kind, modulus):
    hint = float(random.uniform(0.25, 1.0))
    if kind == 'HalfSpace':
        return Body(kind, (), modulus, hint)
    kind = random.choice([*SIZES, 'Convex'])
    if kind == 'Convex':
        return Body('Convex', tuple(map(tuple, random.normal(size=(12, 3)))), modulus, hint)
    return Body(str(kind), tuple(random.uniform(0.5, 1.5, SIZES[kind]).tolist()), modulus, hint)


def cases(count, seed):
    random = np.random.default_rng(seed)
    for number in range(count):
        first, a, second, b = PAIRS[number % len(PAIRS)]
        bodies = [random_body(random, first, a), random_body(random, second, b)]
        yield bodies, [(random_rotation(random), random.normal(size=3) * 0.5) for _ in range(2)]


def packed_of_theirs(mesh, body):
    """Return pydrake's mesh of a body, packed for our kernels."""
    if body.kind == 'HalfSpace':
        return packing.packed_half_space(body.modulus / body.hint)
    points = np.array(mesh.vertices())
    if isinstance(mesh, theirs.TriangleSurfaceMesh):
        rows = [[t.vertex(i) for i in range(3)] for t in mesh.triangles()]
        return packing.packed_surface(points, np.array(rows))
    elements = np.array([[t.vertex(i) for i in range(4)] for t in mesh.tetrahedra()])
    beyond = neighbours_of(elements)
    pressures = np.full(len(points), body.modulus)
    pressures[np.unique(elements[:, OUTER_FACES].reshape(-1, 3)[beyond.ravel() < 0])] = 0.0
    return packing.packed_volume(points, elements, pressures, beyond)


def their_sums(surface):
    """Return the force on M (3,) [N], and the integral of the pressure [N]."""
    force, total = np.zeros(3), 0.0
    field = surface.poly_e_MN()
    for k in range(surface.num_faces()):
        part = surface.area(k) * field.EvaluateCartesian(k, surface.centroid(k))
        force, total = force + part * surface.face_normal(k), total + part
    return force, total


def test_on_its_meshes_it_is_the_same_face_by_face():
    compared = swallowed = 0
    for bodies, poses in cases(POSES, seed=42):
        query, ids, (scene, _context) = query_of(bodies, poses, theirs)
        expected = query.ComputeContactSurfaces(theirs.HydroelasticContactRepresentation.kPolygon)
        inspector = scene.model_inspector()
        packed = packing.packed(
            [
                packed_of_theirs(inspector.maybe_get_hydroelastic_mesh(id), body)
                for id, body in zip(ids, bodies, strict=True)
            ]
        )
        Rs, ps = (np.array([pose[k] for pose in poses]) for k in (0, 1))
        rows = np.arange(2)
        posed = Posed(packed, Geometries(rows, rows, Rs, ps))
        out = surfaces_of(posed, np.array([[0, 1]])).surfaces()
        assert bool(expected) == (out.states[0] == PRESSES) == bool(len(out.found))
        swallowed += bool(out.states[0] == SWALLOWED)
        for surface in expected:
            compared += 1
            sums, (force, total) = out.sums[0], their_sums(surface)
            assert surface.num_faces() == out.found[0, LAST]
            assert sums[AREA] == pytest.approx(surface.total_area(), rel=1e-12)
            assert sums[PRESSURE] == pytest.approx(total, rel=1e-12)
            np.testing.assert_allclose(
                sums[FORCE : FORCE + 3], force, rtol=0.0, atol=1e-12 * total
            )
            centroid = sums[FIRST_MOMENT : FIRST_MOMENT + 3] / sums[AREA]
            np.testing.assert_allclose(centroid, surface.centroid(), rtol=0.0, atol=1e-12)
    assert compared > 0.7 * POSES
    assert swallowed > 0  # of which pydrake says nothing


def test_on_our_meshes_areas_and_forces_are_the_same():
    compared = 0
    for bodies, poses in cases(140, seed=43):
        (expected, mine) = (surfaces(bodies, poses, geometry) for geometry in (theirs, ours))
        assert len(expected) == len(mine)
        for a, b in zip(expected, mine, strict=True):
            compared += 1
            force, total = their_sums(a)
            assert b.total_area() == pytest.approx(a.total_area(), rel=1e-9, abs=1e-12)
            np.testing.assert_allclose(b.force_on_M_W(), force, rtol=0.0, atol=1e-9 * total)
            np.testing.assert_allclose(b.centroid(), a.centroid(), rtol=0.0, atol=1e-9)
            assert (b.HasGradE_M(), b.HasGradE_N()) == (a.HasGradE_M(), a.HasGradE_N())
    assert compared > 100


def test_a_box_that_is_cut_otherwise_presses_as_hard():
    random = np.random.default_rng(45)
    bodies = [Body('Box', (1.0, 1.0, 3.0), 1e5), Body('Sphere', (0.8,), 1e5)]
    compared = 0
    for _ in range(20):
        poses = [(random_rotation(random), random.normal(size=3) * 0.5) for _ in range(2)]
        (expected, mine) = (surfaces(bodies, poses, geometry) for geometry in (theirs, ours))
        for a, b in zip(expected, mine, strict=True):
            compared += 1
            force, total = their_sums(a)
            assert b.total_area() == pytest.approx(a.total_area(), rel=1e-9)
            np.testing.assert_allclose(b.force_on_M_W(), force, rtol=0.0, atol=1e-9 * total)
    assert compared > 10


def test_triangles_and_vertices_of_two_bodies():
    for bodies, poses in cases(21, seed=44):
        if 'HalfSpace' in [body.kind for body in bodies]:
            continue
        for name in ('kTriangle', 'kPolygon'):
            (expected, mine) = (
                surfaces(bodies, poses, geometry, name) for geometry in (theirs, ours)
            )
            for a, b in zip(expected, mine, strict=True):
                assert a.is_triangle() == b.is_triangle()
                if all(body.kind in ('Sphere', 'Ellipsoid') for body in bodies):
                    assert (a.num_faces(), a.num_vertices()) == (b.num_faces(), b.num_vertices())
                assert a.face_normal(0) @ a.face_normal(0) == pytest.approx(1.0)
