"""Shapes of MoveIt's objects: sizes, places, and what is refused, by closed forms."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live.moveit_messages import BOX, CONE, CYLINDER, PRISM, SPHERE, mesh, plane, primitive

from drake_geom_ros.geometry import (
    Box,
    Cylinder,
    GeometryInstance,
    ProximityProperties,
    QueryObject,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.live.conversions.moveit_shapes import (
    placed_mesh,
    placed_plane,
    placed_primitive,
)
from drake_geom_ros.math import RigidTransform

AT_HOME = RigidTransform()
TETRAHEDRON = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
number = st.floats(-3.0, 3.0)


def distances(placed, points):
    """Return the signed distances of points (n, 3) to a shape in the world."""
    graph = SceneGraph()
    properties = ProximityProperties()
    if placed.is_solid:
        properties.AddProperty('mesh', 'solid', True)
    instance = GeometryInstance(placed.X_OS, placed.shape, 'g')
    instance.set_proximity_properties(properties)
    graph.RegisterAnchoredGeometry(graph.RegisterSource('s'), instance)
    query = QueryObject(graph.CreateDefaultContext())
    rows = query.ComputeSignedDistanceToPoint(np.asarray(points, dtype=float))
    return np.array([each.distance for each in rows])


def test_dimensions_are_in_the_order_of_solid_primitive():
    assert placed_primitive(primitive(BOX, 1.0, 2.0, 3.0), AT_HOME).shape == Box(1.0, 2.0, 3.0)
    assert placed_primitive(primitive(SPHERE, 0.5), AT_HOME).shape == Sphere(0.5)
    cylinder = placed_primitive(primitive(CYLINDER, 3.0, 0.5), AT_HOME).shape
    assert cylinder == Cylinder(0.5, 3.0)


def test_a_cone_lies_inside_its_pyramid_which_is_little_larger():
    height, radius = 2.0, 0.5
    placed = placed_primitive(primitive(CONE, height, radius), AT_HOME)
    assert 'pyramid of 64 sides' in placed.note
    z, angle = np.random.default_rng(3).uniform([-1.0, 0.0], [1.0, 2 * math.pi], (500, 2)).T
    r = radius * (0.5 * height - z) / height  # of the cone's side at height z
    surface = np.column_stack([r * np.cos(angle), r * np.sin(angle), z])
    depths = -distances(placed, surface)
    assert (depths >= -1e-12).all()
    assert depths.max() <= radius * (1.0 / math.cos(math.pi / 64) - 1.0) + 1e-12


@pytest.mark.parametrize(
    ('message', 'reason'),
    [
        (primitive(0), 'its type is 0; it must be one of 1 (box), 2 (sphere)'),
        (primitive(PRISM, 1.0), 'a prism, which MoveIt does not take either'),
        (primitive(BOX, 1.0, 2.0), 'dimensions holds 2 numbers; a box takes: x, y, z'),
        (primitive(CYLINDER, 1.0), 'a cylinder takes: height, radius'),
        (primitive(SPHERE, -1.0), '-1'),
        (primitive(CONE, 0.0, 1.0), 'both must be > 0'),
        (primitive(CONE, 1.0, math.nan), 'both must be > 0'),
    ],
)
def test_what_is_no_primitive_is_refused(message, reason):
    with pytest.raises(RuntimeError, match=re.escape(reason)):
        placed_primitive(message, AT_HOME)


def test_dimensions_that_do_not_count_are_reported():
    placed = placed_primitive(primitive(SPHERE, 0.5, 0.0, 0.0), AT_HOME)
    assert placed.shape == Sphere(0.5)
    assert placed.note == 'has 3 dimensions, of which 1 count'


@given(
    st.tuples(number, number, number).filter(lambda n: np.linalg.norm(n) > 1e-2),
    number,
    st.tuples(number, number, number),
)
def test_a_plane_is_the_half_space_of_its_equation(normal, offset, point):
    placed = placed_plane(plane(*normal, offset), AT_HOME)
    expected = (np.dot(normal, point) + offset) / np.linalg.norm(normal)
    assert distances(placed, [point]) == pytest.approx([expected], abs=1e-9)


@pytest.mark.parametrize('coefficients', [(0, 0, 0, 1), (math.inf, 0, 0, 1), (1, 0, 0)])
def test_what_is_no_plane_is_refused(coefficients):
    with pytest.raises(RuntimeError, match='coef is'):
        placed_plane(plane(*coefficients), AT_HOME)


def test_a_mesh_counts_by_its_triangles():
    ell = mesh(*_prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]))
    placed = placed_mesh(ell, AT_HOME)
    assert placed.is_solid
    assert not placed.note
    # In the corner of the L, inside of its hull; and inside of the L.
    assert distances(placed, [[1.2, 1.2, 0.5], [0.5, 0.5, 0.5]]) == pytest.approx([0.2, -0.5])


def _prism(outline):
    """Return vertices and triangles of an upright prism of height 1 over an L."""
    n = len(outline)
    vertices = [(*p, 0) for p in outline] + [(*p, 1) for p in outline]
    flat = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    sides = [(k, (k + 1) % n, n + (k + 1) % n) for k in range(n)]
    sides += [(k, n + (k + 1) % n, n + k) for k in range(n)]
    return vertices, [
        *((a, c, b) for a, b, c in flat),
        *((n + a, n + b, n + c) for a, b, c in flat),
        *sides,
    ]


def test_an_open_mesh_counts_as_its_hull_and_says_so():
    placed = placed_mesh(mesh(TETRAHEDRON, FACES[:3]), AT_HOME)
    assert not placed.is_solid
    assert 'counts as its convex hull' in placed.note
    assert distances(placed, [[0.1, 0.1, 0.1]]) == pytest.approx([-0.1])


@pytest.mark.parametrize(
    ('vertices', 'triangles', 'reason'),
    [
        (TETRAHEDRON, [], '4 vertices and 0 triangles'),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [(0, 1, 2)], 'volume'),
        (TETRAHEDRON, [(0, 1, 9)], '9'),
        ([*TETRAHEDRON[:3], [0, 0, math.nan]], FACES, 'not finite'),
    ],
)
def test_triangles_without_a_body_are_refused(vertices, triangles, reason):
    with pytest.raises(RuntimeError, match=reason):
        placed_mesh(mesh(vertices, triangles), AT_HOME)
