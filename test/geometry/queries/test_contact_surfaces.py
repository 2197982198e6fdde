"""Contact surfaces: closed forms, laws, cases on the edge, and what is refused."""

import gc
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.contact_scenes import Body, query_of

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    GeometryError,
    GeometrySet,
    HydroelasticContactRepresentation,
    ProximityProperties,
    RoleAssign,
)
from drake_geom_ros.geometry._contact_surfaces import asking, packing
from drake_geom_ros.geometry.queries import contact_bodies
from truth.bodies.random_bodies import random_rotation

TRIANGLES = HydroelasticContactRepresentation.kTriangle
POLYGONS = HydroelasticContactRepresentation.kPolygon
UPRIGHT = np.eye(3)


def one(bodies, poses, representation=POLYGONS):
    """Return the only surface of two bodies."""
    (surface,) = query_of(bodies, poses)[0].ComputeContactSurfaces(representation)
    return surface


# Closed forms.


def test_a_box_on_a_rigid_plane():
    # The pressure of a box grows from a face to the half of its least size: E d / (h / 2).
    size, depth, modulus = (0.2, 0.3, 0.1), 0.01, 1e5
    box = Body('Box', size, modulus)
    surface = one(
        [Body('HalfSpace', (), 0.0), box], [(UPRIGHT, [0, 0, 0]), (UPRIGHT, [1, 2, 0.04])]
    )
    # Near the sides they are nearer: the pressure falls to 0 over the last 'depth' all around.
    pressed = 0.0
    x, w = np.polynomial.legendre.leggauss(40)
    for low, high in ((0, depth), (depth, size[0] / 2)):
        at = 0.5 * (high - low) * x + 0.5 * (high + low)
        for a, wa in zip(at, 0.5 * (high - low) * w, strict=True):
            inner = min(a, depth)
            # Over y: rises to 'inner', then constant.
            pressed += 2 * wa * (size[1] * inner - inner**2)
    assert surface.total_area() == pytest.approx(size[0] * size[1], rel=1e-12)
    force = surface.force_on_M_W()
    np.testing.assert_allclose(force[:2], 0.0, rtol=0, atol=1e-9)
    assert -force[2] == pytest.approx(modulus / (size[2] / 2) * pressed, rel=1e-9)
    np.testing.assert_allclose(surface.centre_of_pressure(), [1, 2, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(surface.centroid(), [1, 2, 0], rtol=0, atol=1e-12)


@pytest.mark.parametrize(('hint', 'error', 'missing'), [(0.2, 0.3, 0.182), (0.05, 0.025, 0.011)])
def test_a_ball_in_a_rigid_plane(hint, error, missing):
    # p = E (1 - r / R) within a circle of radius c in a plane at height h: c^2 = R^2 - h^2, and
    # the force is 2 pi E times the integral of (1 - sqrt(s^2 + h^2) / R) s ds.
    R, h, modulus = 0.5, 0.4, 1e5
    surface = one(
        [Body('HalfSpace', (), 0.0), Body('Sphere', (R,), modulus, hint)],
        [(UPRIGHT, [0, 0, 0]), (random_rotation(np.random.default_rng(1)), [0.1, -0.2, h])],
    )
    area = math.pi * (R**2 - h**2)
    force = 2 * math.pi * modulus * ((R**2 - h**2) / 2 - (R**3 - h**3) / (3 * R))
    # As docs/contact_surfaces.md says.
    assert surface.total_area() == pytest.approx((1.0 - missing) * area, rel=1e-3)
    assert -surface.force_on_M_W()[2] == pytest.approx(force, rel=error)
    np.testing.assert_allclose(
        surface.centre_of_pressure(), [0.1, -0.2, 0], rtol=0, atol=0.05 * error
    )


def test_two_like_balls_meet_in_the_middle():
    R, h = 0.5, 0.4
    balls = [Body('Sphere', (R,), 1e5, 0.05)] * 2
    surface = one(balls, [(UPRIGHT, [0, 0, -h]), (UPRIGHT, [0, 0, h])])
    points = surface.polygon_arrays()[0]
    np.testing.assert_allclose(points[:, 2], 0.0, rtol=0, atol=1e-12)
    assert surface.total_area() == pytest.approx(math.pi * (R**2 - h**2), rel=0.02)
    assert surface.id_M() < surface.id_N()
    np.testing.assert_allclose(surface.face_normal(0), [0, 0, -1], rtol=0, atol=1e-12)
    assert surface.EvaluateGradE_M_W(0)[2] < 0.0 < surface.EvaluateGradE_N_W(0)[2]


def test_a_rigid_ball_in_a_soft_slab():
    # p = E d / thickness over the cap: the vertical force is the volume below times E / thickness.
    R, h, thickness = 0.5, 0.4, 0.2
    bodies = [Body('HalfSpace', (), 1e5, thickness), Body('Sphere', (R,), 0.0, 0.03)]
    surface = one(bodies, [(UPRIGHT, [0, 0, 0]), (UPRIGHT, [0, 0, h])])
    d = R - h
    volume = math.pi * d**2 * (3 * R - d) / 3
    assert -surface.force_on_M_W()[2] == pytest.approx(volume * 1e5 / thickness, rel=0.02)
    assert (surface.HasGradE_M(), surface.HasGradE_N()) == (True, False)
    with pytest.raises(GeometryError, match='N is rigid'):
        surface.EvaluateGradE_N_W(0)


def test_a_soft_ball_in_a_soft_slab_is_answered():
    # The slab as stiff as can be is a rigid one.
    ball, pose = Body('Sphere', (0.5,), 1e5, 0.1), (UPRIGHT, [0, 0, 0.4])
    soft, rigid = (
        one([Body('HalfSpace', (), modulus, 0.1), ball], [(UPRIGHT, [0, 0, 0]), pose])
        for modulus in (1e12, 0.0)
    )
    assert soft.total_area() == pytest.approx(rigid.total_area(), rel=1e-4)
    np.testing.assert_allclose(soft.force_on_M_W(), rigid.force_on_M_W(), rtol=1e-4, atol=1e-2)
    assert soft.HasGradE_M()
    assert soft.HasGradE_N()


# Laws.

KINDS = (
    ('Sphere', (0.5,)),
    ('Box', (0.8, 1.0, 1.2)),
    ('Cylinder', (0.4, 1.1)),
    ('Cylinder', (0.6, 0.5)),
    ('Capsule', (0.4, 0.6)),
    ('Ellipsoid', (0.4, 0.6, 0.5)),
    ('Convex', ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.7, 0.7, 0.7))),
    ('HalfSpace', ()),
)


@st.composite
def contacts(draw):
    """Draw two bodies that can have a surface, and their poses."""
    first, second = draw(st.sampled_from(KINDS[:-1])), draw(st.sampled_from(KINDS))
    modulus = draw(st.sampled_from([0.0, 1e4, 1e5]))
    bodies = [Body(*first, 1e5), Body(*second, modulus)]
    if draw(st.booleans()):
        bodies.reverse()
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    return bodies, [(random_rotation(random), random.normal(size=3) * 0.4) for _ in range(2)]


def same(a, b, size=1.0):
    """Assert that two lists of surfaces are as large, as strong, and where they are."""
    assert len(a) == len(b)
    for x, y in zip(a, b, strict=True):
        assert x.total_area() == pytest.approx(y.total_area(), rel=1e-8, abs=1e-10)
        np.testing.assert_allclose(x.centroid(), y.centroid(), rtol=0, atol=1e-7 * size)


@given(contacts())
@settings(max_examples=60, deadline=None)
def test_the_order_of_the_bodies_changes_nothing(drawn):
    bodies, poses = drawn
    a, swallowed = query_of(bodies, poses)[0].ComputeContactSurfacesWithFallback()
    b, also = query_of(bodies, poses, order=[1, 0])[0].ComputeContactSurfacesWithFallback()
    same(a, b)
    assert len(swallowed) == len(also)
    for x, y in zip(a, b, strict=True):
        np.testing.assert_allclose(x.force_on_M_W(), -y.force_on_M_W(), rtol=1e-8, atol=1e-6)
        np.testing.assert_allclose(
            x.torque_on_M_Wo_W(), -y.torque_on_M_Wo_W(), rtol=1e-7, atol=1e-6
        )


@given(contacts(), st.integers(0, 2**32))
@settings(max_examples=60, deadline=None)
def test_a_common_motion_moves_the_surface(drawn, seed):
    bodies, poses = drawn
    random = np.random.default_rng(seed)
    R, p = random_rotation(random), random.normal(size=3)
    moved = [(R @ R_WB, R @ p_WB + p) for R_WB, p_WB in poses]
    a, swallowed = query_of(bodies, poses)[0].ComputeContactSurfacesWithFallback()
    b, also = query_of(bodies, moved)[0].ComputeContactSurfacesWithFallback()
    assert (len(a), len(swallowed)) == (len(b), len(also))
    for x, y in zip(a, b, strict=True):
        assert x.total_area() == pytest.approx(y.total_area(), rel=1e-8, abs=1e-10)
        np.testing.assert_allclose(R @ x.centroid() + p, y.centroid(), rtol=0, atol=1e-7)
        np.testing.assert_allclose(R @ x.force_on_M_W(), y.force_on_M_W(), rtol=1e-7, atol=1e-5)


@given(contacts())
@settings(max_examples=40, deadline=None)
def test_both_representations_say_the_same(drawn):
    query = query_of(*drawn)[0]
    for polygons, triangles in zip(
        query.ComputeContactSurfacesWithFallback(POLYGONS)[0],
        query.ComputeContactSurfacesWithFallback(TRIANGLES)[0],
        strict=True,
    ):
        assert triangles.num_faces() == polygons.num_vertices()
        mesh, field = triangles.tri_mesh_W(), triangles.tri_e_MN()
        areas = [triangles.area(k) for k in range(triangles.num_faces())]
        assert sum(areas) == pytest.approx(polygons.total_area(), rel=1e-9)
        assert polygons.poly_mesh_W().total_area() == pytest.approx(sum(areas), rel=1e-9)
        np.testing.assert_allclose(mesh.centroid(), polygons.centroid(), rtol=0, atol=1e-8)
        force = sum(
            area * field.EvaluateCartesian(k, mesh.element_centroid(k)) * triangles.face_normal(k)
            for k, area in enumerate(areas)
        )
        scale = 1e-9 * np.abs(field._values).max() * sum(areas)
        np.testing.assert_allclose(force, polygons.force_on_M_W(), rtol=1e-8, atol=10 * scale)
        largest = int(np.argmax(areas))
        np.testing.assert_allclose(
            mesh.face_normal(largest), triangles.face_normal(largest), rtol=0, atol=1e-6
        )


FLUSH = {
    'boxes on one another': (('Box', (1.0, 1.0, 1.0)), ('Box', (1.0, 1.0, 1.0)), 0.7),
    'a box under a wider one': (('Box', (1.0, 1.0, 1.0)), ('Box', (2.0, 1.0, 1.0)), 0.7),
    'cylinders on one another': (('Cylinder', (0.5, 1.0)), ('Cylinder', (0.5, 1.0)), 0.7),
    'a box in a slab': (('HalfSpace', ()), ('Box', (1.0, 1.0, 1.0)), 0.2),
}


@pytest.mark.parametrize('name', FLUSH)
def test_a_common_motion_of_flush_bodies_changes_nothing(name):
    # Where sides are flush both pressures are the same in a whole volume: turned, they differ by
    # rounding, which must not count as a direction.
    first, second, height = FLUSH[name]
    bodies = [Body(*first, 1e5, 0.5), Body(*second, 1e5)]
    offset = np.array([0, 0, height])
    still = one(bodies, [(UPRIGHT, np.zeros(3)), (UPRIGHT, offset)])
    random = np.random.default_rng(42)
    for _ in range(40):
        R, p = random_rotation(random), random.normal(size=3)
        moved = one(bodies, [(R, p), (R, R @ offset + p)])
        assert moved.num_faces() == still.num_faces()
        assert moved.total_area() == pytest.approx(still.total_area(), rel=1e-10)
        np.testing.assert_allclose(
            moved.force_on_M_W(), R @ still.force_on_M_W(), rtol=0.0, atol=1e-9 * 21900
        )


def test_far_from_the_origin_nothing_is_lost():
    # Positions and shift are sums of few powers of two: the poses in each other are the same.
    bodies = [Body('Sphere', (0.5,), 1e5), Body('Box', (0.5, 0.25, 0.5), 1e5)]
    turned = random_rotation(np.random.default_rng(7))
    near = [(turned, np.zeros(3)), (UPRIGHT, np.array([0.25, 0.125, 0.375]))]
    shift = np.array([2.0**20, -(2.0**21), 2.0**19])
    a, b = one(bodies, near), one(bodies, [(R, p + shift) for R, p in near])
    assert b.num_faces() == a.num_faces()
    assert b.total_area() == pytest.approx(a.total_area(), rel=1e-13)
    size = np.linalg.norm(a.force_on_M_W())
    np.testing.assert_allclose(b.force_on_M_W(), a.force_on_M_W(), rtol=0.0, atol=1e-13 * size)
    # A position in World is rounded to 2^-32 m there, once.
    for of in ('centroid', 'centre_of_pressure'):
        moved = getattr(b, of)() - shift
        np.testing.assert_allclose(moved, getattr(a, of)(), rtol=0.0, atol=2.0**-30)


# On the edge.


def all_numbers(results):
    surfaces = [results[k] for k in range(len(results))]
    return np.concatenate(
        [np.zeros(1)]
        + [np.ravel(x) for s in surfaces for x in (*s.polygon_arrays()[:2], s._faces, s._sums)]
    )


@pytest.mark.parametrize('scale', [1e-3, 1.0, 1e3])
@pytest.mark.parametrize('modulus', [0.0, 1e5])
def test_boxes_flush_touching_and_within_each_other(scale, modulus):
    half, whole = np.array([0.5, 0.5, 0.5]) * scale, np.array([1.0, 1.0, 1.0]) * scale
    big, small = Body('Box', tuple(whole), 1e5), Body('Box', tuple(half), modulus, 0.1 * scale)
    turned = random_rotation(np.random.default_rng(3))
    for R in (UPRIGHT, turned):
        for bodies in ([big, small], [small, big]):
            for offset, area in (
                ([0, 0, 0.75], 0.0),  # touching
                ([0, 0, 0.5], 0.25),
                ([0.25, 0, 0.5], None),  # a side is flush
                ([0.25, 0.25, 0.25], None),  # in a corner
                ([0, 0, 0], None),  # within, concentric
                ([0.5, 0.5, 0.5], None),  # its middle on a corner
            ):
                poses = [(R, np.zeros(3)), (R, R @ np.array(offset) * scale)]
                if bodies[0] is small:
                    poses.reverse()
                query = query_of(bodies, poses)[0]
                results, swallowed = query.ComputeContactSurfacesWithFallback()
                # Bodies that overlap have a surface, or are told.
                assert len(results) + len(swallowed) == (area != 0.0)
                assert np.isfinite(all_numbers(results)).all()
                if area == 0.0:
                    assert sum(results.areas) <= 1e-9 * scale**2
                elif area is not None and modulus == 0.0:
                    (surface,) = results
                    # The face within, and the sides that are not left out for their normals.
                    assert surface.total_area() >= area * scale**2 * (1 - 1e-9)


def test_a_rigid_face_between_tetrahedra_counts_once():
    # The bottom of the small box is the plane in which the tetrahedra of the big one meet.
    for R in (UPRIGHT, random_rotation(np.random.default_rng(5))):
        for bodies in ([Body('Box', (2.0, 2.0, 1.0), 1e5), Body('Box', (0.5, 0.5, 0.5), 0.0)],):
            poses = [(R, np.zeros(3)), (R, R @ np.array([0.1, 0.05, 0.25]))]
            (surface,) = query_of(bodies, poses)[0].ComputeContactSurfaces()
            down = [
                surface.area(k)
                for k in range(surface.num_faces())
                if surface.face_normal(k) @ R[:, 2] < -0.999
            ]
            assert sum(down) == pytest.approx(0.25, rel=1e-9)


@pytest.mark.parametrize('scale', [1e-3, 1.0, 1e3])
def test_balls_concentric_touching_and_apart(scale):
    ball = Body('Sphere', (scale,), 1e5, 0.5 * scale)
    for other in (ball, Body('Sphere', (0.5 * scale,), 0.0, 0.3 * scale)):
        for x in (0.0, 1e-17, 1e-9, 0.5, 1.5, 2.0, 3.0):
            poses = [(UPRIGHT, np.zeros(3)), (UPRIGHT, np.array([x * scale, 0, 0]))]
            query = query_of([ball, other], poses)[0]
            results, swallowed = query.ComputeContactSurfacesWithFallback()
            assert np.isfinite(all_numbers(results)).all()
            reach = 2.0 if other is ball else 1.5
            assert len(results) + len(swallowed) == (x < reach)
    touching = [(UPRIGHT, np.zeros(3)), (UPRIGHT, np.array([2.0 * scale, 0, 0]))]
    assert len(query_of([ball, ball], touching)[0].ComputeContactSurfaces()) == 0


def box_mesh(half, *, inside_out=False):
    """Return corners and triangles of a cube."""
    corners = half * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in squares for t in ((a, b, c), (a, c, d))]
    return corners, [t[::-1] for t in triangles] if inside_out else triangles


SMALL = Body('Sphere', (0.2,), 1e4, 0.1)
SWALLOWED = {
    'a ball in a rigid box': (Body('Box', (2.0, 2.0, 2.0), 0.0), SMALL, (0.5, 0.3, 0.1)),
    'a ball in a rigid mesh': (Body('Mesh', box_mesh(1.0), 0.0), SMALL, (0.5, 0.3, 0.1)),
    'a ball in a stiffer one': (Body('Sphere', (1.0,), 1e5), SMALL, (0.1, 0.0, 0.0)),
    'a rigid ball about the middle of a soft one': (
        Body('Sphere', (1.0,), 1e5),
        Body('Sphere', (0.2,), 0.0, 0.1),
        (0.0, 0.0, 0.0),
    ),
    'a ball under a rigid plane': (Body('HalfSpace', (), 0.0), SMALL, (3.0, 4.0, -0.3)),
    'a ball in a stiff slab': (Body('HalfSpace', (), 1e6, 0.1), SMALL, (3.0, 4.0, -0.3)),
    'a ball over its middle in a rigid box': (
        Body('Box', (2.0, 2.0, 2.0), 0.0),
        SMALL,
        (0.85, 0.0, 0.0),
    ),
    'like balls in one place': (SMALL, SMALL, (0.0, 0.0, 0.0)),
}


@pytest.mark.parametrize('order', [(0, 1), (1, 0)])
@pytest.mark.parametrize('name', SWALLOWED)
def test_a_body_deep_within_another_is_not_free(name, order):
    first, second, offset = SWALLOWED[name]
    R, p = random_rotation(np.random.default_rng(3)), np.array([7.0, -3.0, 5.0])
    poses = [(R, p), (R, R @ np.array(offset) + p)]
    query, ids, (scene, context) = query_of([first, second], poses, order=order)
    for ask in (query.ComputeContactSurfaces, query.contact_surfaces):
        with pytest.raises(GeometryError, match='deep within') as refused:
            ask()
        assert all(repr(id) in str(refused.value) for id in ids)
    surfaces, (point,) = query.ComputeContactSurfacesWithFallback()
    assert len(surfaces) == 0
    assert {point.id_A, point.id_B} == set(ids)
    assert point.depth > 0.1
    scene.collision_filter_manager(context).Apply(
        CollisionFilterDeclaration().ExcludeBetween(GeometrySet(ids[0]), GeometrySet(ids[1]))
    )
    assert len(query.ComputeContactSurfaces()) == 0
    # Bounds that meet are no contact.
    bound = 1.0 if first.kind != 'HalfSpace' else 0.0
    away = np.array([bound + 0.19, bound + 0.19, bound + 0.19])
    apart = query_of([first, second], [(UPRIGHT, np.zeros(3)), (UPRIGHT, away)], order=order)[0]
    if bound == 1.0:
        assert len(apart.ComputeContactSurfaces()) == 0


@pytest.mark.parametrize('order', [(0, 1), (1, 0)])
@pytest.mark.parametrize('scale', [1e-3, 1.0, 1e3])
def test_bodies_all_of_whose_faces_are_left_out_are_not_free(scale, order):
    # Two needles tip to tip. Where their pressures are equal both grow in much the same direction,
    # inward from the same side, and neither one's innermost point is in the other.
    sizes = (0.05 * scale, 0.05 * scale, scale)
    needles = [Body('Ellipsoid', sizes, modulus, 10.0 * scale) for modulus in (1e3, 1e7)]
    for way in (UPRIGHT, random_rotation(np.random.default_rng(6))):
        poses = [(way, np.zeros(3)), (way, way @ np.array([0.0, 0.0, 1.8 * scale]))]
        query, ids, _ = query_of(needles, poses, order=order)
        surfaces, points = query.ComputeContactSurfacesWithFallback()
        assert (len(surfaces), len(points)) == (0, 1)
        assert {points[0].id_A, points[0].id_B} == set(ids)
        with pytest.raises(GeometryError, match='left out'):
            query.ComputeContactSurfaces()
        with pytest.raises(GeometryError, match='left out'):
            query.contact_surfaces()
    apart = [(UPRIGHT, np.zeros(3)), (UPRIGHT, np.array([0.0, 0.0, 2.0001 * scale]))]
    assert len(query_of(needles, apart)[0].ComputeContactSurfaces()) == 0


@pytest.mark.parametrize('inside_out', [False, True])
def test_a_rigid_mesh_may_be_inside_out(inside_out):
    # Its faces are turned outward: those that look into the ball count.
    mesh = Body('Mesh', box_mesh(0.5, inside_out=inside_out), 0.0)
    box, ball = Body('Box', (1.0, 1.0, 1.0), 0.0), Body('Sphere', (0.5,), 1e5, 0.1)
    poses = [(UPRIGHT, np.zeros(3)), (random_rotation(np.random.default_rng(2)), [0.0, 0.1, 0.9])]
    a, b = one([box, ball], poses), one([mesh, ball], poses)
    assert a.total_area() == pytest.approx(b.total_area(), rel=1e-12)
    np.testing.assert_allclose(a.force_on_M_W(), b.force_on_M_W(), rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize('inside_out', [False, True])
def test_each_piece_of_a_rigid_mesh_is_turned_outward(inside_out):
    corners, triangles = box_mesh(2.0)
    other, more = box_mesh(1.0, inside_out=inside_out)
    both = (
        np.vstack((corners, other + np.array([6, 0, 0]))),
        triangles + [tuple(v + 8 for v in t) for t in more],
    )
    ball, mesh = Body('Sphere', (0.3,), 1e5, 0.1), Body('Mesh', both, 0.0)
    for height, area in ((1.1, 0.246), (1.25, 0.083)):
        surface = one([mesh, ball], [(UPRIGHT, np.zeros(3)), (UPRIGHT, [6, 0, height])])
        assert surface.total_area() == pytest.approx(area, abs=1e-3)
    query, *_ = query_of([mesh, ball], [(UPRIGHT, np.zeros(3)), (UPRIGHT, [6, 0, 0])])
    with pytest.raises(GeometryError, match='deep within'):
        query.ComputeContactSurfaces()


def test_a_rigid_mesh_with_a_flipped_triangle_is_refused_where_it_is_registered():
    corners, triangles = box_mesh(0.5)
    flipped = Body('Mesh', (corners, [*triangles[:-1], triangles[-1][::-1]]), 0.0)
    why = 'hydroelastic properties, and its mesh has no outside: of its edges 3'
    with pytest.raises(GeometryError, match=why):
        query_of([flipped], [(UPRIGHT, np.zeros(3))])
    # An open one has sides all the same.
    sheet = Body('Mesh', (corners, triangles[-2:]), 0.0)
    ball, poses = Body('Sphere', (0.3,), 1e5, 0.1), [(UPRIGHT, np.zeros(3))]
    with pytest.warns(UserWarning, match='bounds no solid'):
        assert one([sheet, ball], [*poses, (UPRIGHT, [0, 0, 0.7])]).total_area() > 0.1


def test_a_corner_on_a_plane_is_no_contact():
    ball = Body('Sphere', (1.0,), 1e5, 0.5)
    for height in (1.0, 1.0 + 1e-15):
        bodies = [Body('HalfSpace', (), 0.0), ball]
        poses = [(UPRIGHT, np.zeros(3)), (UPRIGHT, np.array([0, 0, height]))]
        assert len(query_of(bodies, poses)[0].ComputeContactSurfaces()) == 0
    box = Body('Box', (1.0, 1.0, 1.0), 1e5)
    on_it = [(UPRIGHT, np.zeros(3)), (UPRIGHT, np.array([0, 0, 0.5]))]
    assert len(query_of([Body('HalfSpace', (), 0.0), box], on_it)[0].ComputeContactSurfaces()) == 0


# What is asked, and refused.


@pytest.mark.parametrize(
    ('first', 'second', 'why'),
    [
        (Body('Sphere', (0.5,), 0.0), Body('Box', (1.0, 1.0, 1.0), 0.0), 'both are rigid'),
        (Body('Sphere', (0.5,), 1e5), Body('Box', (1.0, 1.0, 1.0), None), 'no hydroelastic'),
        (Body('Sphere', (0.5,), None), Body('Box', (1.0, 1.0, 1.0), None), 'no hydroelastic'),
    ],
)
def test_pairs_without_a_surface(first, second, why):
    third = Body('Sphere', (0.5,), 1e5)
    near = [(UPRIGHT, np.zeros(3)), (UPRIGHT, np.array([0.8, 0, 0]))]
    query, ids, (scene, context) = query_of([first, second], near)
    with pytest.raises(GeometryError, match=why):
        query.ComputeContactSurfaces()
    surfaces, (point,) = query.ComputeContactSurfacesWithFallback()
    assert len(surfaces) == 0
    assert (point.id_A, point.id_B) == tuple(ids)
    assert len(query.contact_surfaces()) == 0
    scene.collision_filter_manager(context).Apply(
        CollisionFilterDeclaration().ExcludeBetween(GeometrySet(ids[0]), GeometrySet(ids[1]))
    )
    assert len(query.ComputeContactSurfaces()) == 0
    assert query.ComputeContactSurfacesWithFallback()[1] == []
    # Bounds that meet are no contact.
    apart = [(UPRIGHT, np.zeros(3)), (random_rotation(np.random.default_rng(1)), [0.9, 0.9, 0.9])]
    assert len(query_of([first, second], apart)[0].ComputeContactSurfaces()) == 0
    assert third.modulus


def test_what_a_surface_refuses():
    pair = [Body('Sphere', (0.5,), 1e5)] * 2
    poses = [(UPRIGHT, np.zeros(3)), (UPRIGHT, np.array([0.8, 0, 0]))]
    polygons, triangles = (
        one(pair, poses, representation) for representation in (POLYGONS, TRIANGLES)
    )
    for ask in (
        polygons.tri_mesh_W,
        polygons.tri_e_MN,
        triangles.poly_mesh_W,
        triangles.poly_e_MN,
        lambda: polygons.area(polygons.num_faces()),
        lambda: triangles.face_normal(-1),
    ):
        with pytest.raises(RuntimeError):
            ask()
    with pytest.raises(RuntimeError):
        query_of(pair, poses)[0].ComputeContactSurfaces('kPolygon')
    with pytest.raises(IndexError):
        query_of(pair, poses)[0].ComputeContactSurfaces()[1]
    assert polygons.Equal(polygons)
    assert not polygons.Equal(triangles)


def test_an_answer_depends_on_the_moment_alone():
    bodies = [
        Body('Sphere', (0.5,), 1e5),
        Body('Box', (1.0, 1.0, 1.0), 1e5),
        Body('HalfSpace', (), 0.0),
    ]
    near = [(UPRIGHT, [0, 0, 0.4]), (UPRIGHT, [0.7, 0, 0.45]), (UPRIGHT, [0, 0, 0])]
    query, _, (scene, context) = query_of(bodies, near)
    first = query.ComputeContactSurfaces()
    assert len(first) == 3
    baked = context.what_if().copy()
    for _ in range(2):
        again = query.ComputeContactSurfaces()
        assert all(a.Equal(b) for a, b in zip(first, again, strict=True))
    fresh = query_of(bodies, near)[0].ComputeContactSurfaces()
    np.testing.assert_array_equal(first.areas, fresh.areas)
    other = scene.get_query_output_port().Eval(baked).ComputeContactSurfaces()
    np.testing.assert_array_equal(first.forces_on_M_W, other.forces_on_M_W)
    np.testing.assert_array_equal(
        first.face_offsets, np.cumsum([0, *(s.num_faces() for s in first)])
    )


def test_padding_is_no_part_of_a_surface_but_of_a_penetration():
    near = [(UPRIGHT, np.zeros(3)), (UPRIGHT, np.array([1.05, 0, 0]))]
    for modulus, raises in ((1e5, False), (0.0, True)):
        query, ids, (scene, context) = query_of([Body('Sphere', (0.5,), modulus)] * 2, near)
        assert len(query.ComputeContactSurfaces()) == 0
        source = scene.model_inspector().GetAllSourceIds()[-1]
        for id in ids:
            properties = ProximityProperties(query.inspector().GetProximityProperties(id))
            properties.AddProperty('proximity', 'padding', 0.05)
            scene.AssignRole(context, source, id, properties, RoleAssign.kReplace)
        if raises:
            with pytest.raises(GeometryError, match='both are rigid'):
                query.ComputeContactSurfaces()
        else:
            assert len(query.ComputeContactSurfaces()) == 0


def test_a_tree_covers_its_elements():
    random = np.random.default_rng(42)
    for count in (0, 1, 2, 3, 7, 8, 100, 1000):
        corners = random.normal(size=(count, 4, 3))
        order, nodes = packing._tree(corners)
        leaves = (len(nodes) + 1) // 2
        assert sorted(order.tolist()) == list(range(count))
        low, high = nodes[:, :3] - nodes[:, 3:], nodes[:, :3] + nodes[:, 3:]
        for k in range(leaves - 1):
            for child in (2 * k + 1, 2 * k + 2):
                assert (low[k] <= low[child] + 1e-12).all()
                assert (high[k] >= high[child] - 1e-12).all()
        for leaf in range(leaves if count else 0):
            own = corners[order[leaf * count // leaves : (leaf + 1) * count // leaves]]
            assert 1 <= len(own) <= 2
            assert (own >= low[leaves - 1 + leaf] - 1e-12).all()
            assert (own <= high[leaves - 1 + leaf] + 1e-12).all()


def test_contexts_share_packed_bodies():
    scene, context = query_of([Body('Sphere', (0.5,), 1e5)], [(UPRIGHT, np.zeros(3))])[2]
    count = len(contact_bodies._PACKED)
    for one_of in (context, scene.CreateDefaultContext()):
        one_of._state.contact_bodies()
        assert len(contact_bodies._PACKED) == count + 1
    del scene, context, one_of
    gc.collect()
    assert len(contact_bodies._PACKED) <= count


def test_what_there_is_room_for_changes_nothing(monkeypatch):
    random = np.random.default_rng(8)
    bodies = [Body('Sphere', (0.5,), 1e5, 0.2), Body('Box', (0.5, 0.6, 0.7), 1e5)] * 3
    poses = [(random_rotation(random), 0.4 * random.normal(size=3)) for _ in bodies]
    query = query_of(bodies, poses)[0]
    whole = query.ComputeContactSurfacesWithFallback()[0]
    assert len(whole) > 5
    for room in (1, 7, 100):
        monkeypatch.setattr(asking, 'FIRST_POLYGONS', room)
        monkeypatch.setattr(asking, 'ROOMS', [])
        again = query.ComputeContactSurfacesWithFallback()[0]
        assert all(a.Equal(b) for a, b in zip(whole, again, strict=True))
        np.testing.assert_array_equal(whole._sums, again._sums)
