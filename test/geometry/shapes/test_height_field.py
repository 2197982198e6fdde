"""Height fields: the solid beneath a terrain, by brute force in 40 digits and by convex prisms."""

import array
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.forms import row_of

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import (
    ArgumentError,
    ArgumentTypeError,
    Box,
    CalcVolume,
    ClippingRange,
    DepthRange,
    DepthRenderCamera,
    GeometryError,
    GeometryInstance,
    HeightField,
    MakeRenderEngineExact,
    MeshData,
    PerceptionProperties,
    ProximityProperties,
    RenderCameraCore,
    RenderEngineExactParams,
    RoleAssign,
    SceneGraph,
)
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SOLID
from drake_geom_ros.geometry.shapes.primitives import for_queries
from drake_geom_ros.live.conversions.shapes import fill_shape
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.scene_files import read_scene, register, save_scene
from drake_geom_ros.sensors import CameraInfo

XS, YS, BASE = np.array([-1.0, -0.25, 0.0, 1.5]), np.array([0.0, 0.5, 0.75]), -0.5


def terrain(seed=1):
    heights = np.random.default_rng(seed).uniform(-0.3, 0.6, (len(XS), len(YS)))
    return HeightField(XS, YS, heights, BASE)


def top_triangles(field):
    """The triangles of the terrain, cell by cell, written out apart from the shape's own."""
    xs, ys, heights = field.xs(), field.ys(), field.heights()
    triangles = []
    for i in range(len(xs) - 1):
        for j in range(len(ys) - 1):
            a, b, c, d = (
                (xs[k], ys[m], heights[k, m])
                for k, m in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            )
            triangles += [(a, b, c), (a, c, d)]
    return triangles


def distance_to_triangle(p, triangle):
    """The distance of a point from a triangle, in the digits of mpmath."""
    a, b, c = (mpmath.matrix([mpmath.mpf(float(x)) for x in corner]) for corner in triangle)

    def dot(u, v):
        return mpmath.fsum(u[k] * v[k] for k in range(3))

    def to_segment(u, v):
        share = dot(p - u, v - u) / dot(v - u, v - u)
        share = min(max(share, mpmath.mpf(0)), mpmath.mpf(1))
        return mpmath.norm(u + share * (v - u) - p)

    e, f = b - a, c - a
    ee, ef, ff = dot(e, e), dot(e, f), dot(f, f)
    pe, pf = dot(p - a, e), dot(p - a, f)
    scale = ee * ff - ef * ef
    s, t = (ff * pe - ef * pf) / scale, (ee * pf - ef * pe) / scale
    if s >= 0 and t >= 0 and s + t <= 1:
        return mpmath.norm(a + s * e + t * f - p)
    return min(to_segment(a, b), to_segment(b, c), to_segment(c, a))


def query_of(field, p_WG=(0.0, 0.0, 0.0)):
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    instance = GeometryInstance(RigidTransform(p_WG), field, 'terrain')
    instance.set_proximity_properties(ProximityProperties())
    instance.set_perception_properties(PerceptionProperties())
    scene_graph.RegisterAnchoredGeometry(source, instance)
    scene_graph.AddRenderer('eye', MakeRenderEngineExact(RenderEngineExactParams()))
    return scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())


@pytest.mark.parametrize('seed', range(4))
def test_points_above_are_as_far_as_from_the_nearest_triangle(seed):
    """Whatever is above the highest point is nearest to the terrain itself, edges included."""
    field = terrain(seed)
    rng = np.random.default_rng(seed)
    points = rng.uniform([-2, -1, 0.6], [2.5, 2, 1.5], (25, 3))
    distances = query_of(field).ComputeSignedDistanceToPoint(points).distance
    with mpmath.workdps(40):
        for point, distance in zip(points, distances, strict=True):
            p = mpmath.matrix([mpmath.mpf(float(x)) for x in point])
            truth = min(distance_to_triangle(p, each) for each in top_triangles(field))
            assert abs(mpmath.mpf(float(distance)) - truth) < 1e-14


def prisms(field, p):
    """The convex prisms of all triangles down to the base: the solid is their union."""
    bodies = []
    for triangle in top_triangles(field):
        corners = np.array(triangle)
        bottom = corners * [1, 1, 0] + [0, 0, field.base()]
        bodies.append(Body('Convex', np.vstack((corners, bottom)), p=p))
    return bodies


@pytest.mark.parametrize('kind', ['Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid'])
def test_bodies_are_as_far_as_from_the_nearest_prism(kind):
    field = terrain()
    vertices, triangles = field.surface()
    rng = np.random.default_rng(5)
    separated = 0
    for _ in range(25):
        R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        R[:, 0] *= np.linalg.det(R)
        body = Body.of_halves(kind, (0.1, 0.15, 0.2))
        body = Body(body.kind, body.size, R, rng.uniform([-2, -1, -1], [2.5, 2, 1.5]))
        solid = Body('Solid', vertices, triangles=triangles)
        row = row_of(body, solid)
        least = min((row_of(body, prism) for prism in prisms(field, solid.p)), key=lambda r: r[0])
        if least[0] > 0.0:
            separated += 1
            assert abs(row[0] - least[0]) <= row[10] + least[10]
        else:  # out of the union is at least as far as out of each prism
            assert row[0] <= least[0] + row[10] + least[10]
    assert separated > 5


@given(
    st.lists(st.floats(-0.4, 2.0), min_size=12, max_size=12),
    st.floats(-3.0, -0.5),
)
@settings(max_examples=30, deadline=None)
def test_the_volume_is_that_of_the_prisms(numbers, base):
    field = HeightField(XS, YS, np.reshape(numbers, (4, 3)), base)
    with mpmath.workdps(40):
        truth = mpmath.fsum(
            mpmath.fsum(mpmath.mpf(float(corner[2])) - mpmath.mpf(base) for corner in triangle)
            / 6
            * mpmath.mpf(float(b[0] - a[0]) * float(c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
            for triangle in top_triangles(field)
            for a, b, c in [triangle]
        )
        assert CalcVolume(field) == pytest.approx(float(truth), rel=1e-12)


def test_it_is_a_solid_with_an_inside():
    field = terrain()
    assert for_queries(field, True).in_pairs.kind == SOLID
    query = query_of(field, [1, 2, 3])
    inside = [[1.2, 2.3, 2.6], [1.0, 2.25, 2.51]]
    distances = query.ComputeSignedDistanceToPoint(np.array(inside)).distance
    assert (distances < 0.0).all()
    assert distances[1] == pytest.approx(-0.01, abs=1e-14)  # of the bottom


def test_a_flat_one_is_a_box():
    flat = HeightField([0, 1, 3], [0, 2, 4, 5], np.full((3, 4), 0.5), -0.5)
    assert for_queries(flat, True).in_pairs.kind == CONVEX
    assert CalcVolume(flat) == pytest.approx(3 * 5 * 1, rel=1e-15)


def test_registration_makes_it_a_solid_and_refuses_that_it_is_none():
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    id = scene_graph.RegisterAnchoredGeometry(
        source, GeometryInstance(RigidTransform(), terrain(), 'terrain')
    )
    scene_graph.AssignRole(source, id, ProximityProperties())
    inspector = scene_graph.model_inspector()
    assert inspector.GetProximityProperties(id).GetProperty('mesh', 'solid') is True
    hollow = ProximityProperties()
    hollow.AddProperty('mesh', 'solid', False)
    with pytest.raises(GeometryError, match='it is always a solid'):
        scene_graph.AssignRole(source, id, hollow, RoleAssign.kReplace)
    assert inspector.GetProximityProperties(id).GetProperty('mesh', 'solid') is True
    box = GeometryInstance(RigidTransform(), Box(1, 1, 1), 'box')
    box.set_proximity_properties(ProximityProperties())
    changed = scene_graph.RegisterAnchoredGeometry(source, box)
    scene_graph.ChangeShape(source, changed, terrain(2))
    assert inspector.GetProximityProperties(changed).GetProperty('mesh', 'solid') is True


@pytest.mark.parametrize('count', [2, 60])
def test_a_saved_one_is_the_same(count):
    """Long heights are packed."""
    rng = np.random.default_rng(3)
    field = HeightField(np.arange(count), np.arange(count + 1), rng.random((count, count + 1)), -1)
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    instance = GeometryInstance(RigidTransform(), field, 'terrain')
    instance.set_proximity_properties(ProximityProperties())
    scene_graph.RegisterAnchoredGeometry(source, instance)
    again = SceneGraph()
    loaded = register(again, read_scene(save_scene(scene_graph)))
    shape = again.model_inspector().GetShape(loaded.geometry_ids[0])
    assert type(shape) is HeightField
    assert shape == field
    np.testing.assert_array_equal(shape.heights(), field.heights())


def test_a_message_has_its_triangles():
    field = terrain()
    message = SimpleNamespace(vertices=array.array('d'))
    fill_shape(message, field)
    np.testing.assert_array_equal(np.reshape(message.vertices, (-1, 3)), field.surface()[0])
    np.testing.assert_array_equal(np.reshape(message.triangles, (-1, 3)), field.surface()[1])


def test_images_show_the_terrain():
    """What a camera above sees lies on the surface."""
    field = terrain()
    query = query_of(field)
    core = RenderCameraCore('eye', CameraInfo(40, 30, 40, 40, 20, 15), ClippingRange(0.1, 20.0))
    camera = DepthRenderCamera(core, DepthRange(0.1, 20.0))
    R_WC = np.diag([1.0, -1.0, -1.0])  # it looks down
    X_WC = RigidTransform(RotationMatrix(R_WC), [0.2, 0.4, 3.0])
    world = query.inspector().world_frame_id()
    depths = query.RenderDepthImage(camera, world, X_WC).data[..., 0].astype(float)
    v, u = np.nonzero(np.isfinite(depths))
    rays = np.column_stack(((u + 0.5 - 20) / 40, (v + 0.5 - 15) / 40, np.ones(len(u))))
    points = (rays * depths[v, u][:, None]) @ R_WC.T + X_WC.translation()
    distances = query.ComputeSignedDistanceToPoint(points).distance
    assert len(points) > 300
    np.testing.assert_allclose(distances, 0.0, rtol=0.0, atol=2e-6)  # depths are of float32


GOOD = ([0, 1], [0, 1, 2], np.zeros((2, 3)), -1.0)


@pytest.mark.parametrize(
    ('place', 'value', 'fault'),
    [
        (0, [0], r'xs \(1,\) must be two numbers or more'),
        (0, [0, 0], 'each above the last'),
        (1, [0, np.nan, 1], 'ys has nan; all must be finite'),
        (1, [[0, 1, 2]], r'ys \(1, 3\) must be two numbers'),
        (2, np.zeros((3, 2)), r'heights \(3, 2\) must be \(len\(xs\), len\(ys\)\) = \(2, 3\)'),
        (2, np.full((2, 3), np.inf), 'heights has inf'),
        (3, 0.0, r'base = 0\.0 must be below all heights, and the lowest is 0\.0'),
        (3, np.nan, 'base has nan'),
    ],
)
def test_faulty_numbers_are_refused(place, value, fault):
    arguments = [*GOOD]
    arguments[place] = value
    with pytest.raises(ArgumentError, match=fault):
        HeightField(*arguments)


def test_too_many_heights_and_words_are_refused():
    count = 1000
    with pytest.raises(ArgumentError, match='1000000 heights; at most 524288'):
        HeightField(np.arange(count), np.arange(count), np.zeros((count, count)), -1.0)
    with pytest.raises(ArgumentTypeError, match='heights are no numbers'):
        HeightField([0, 1], [0, 1], [['a', 'b'], ['c', 'd']], -1.0)
    with pytest.raises(ArgumentTypeError, match='use HeightField'):
        HeightField.FromMeshData(MeshData([[0, 0, 0]]))


@pytest.mark.parametrize(
    ('keys', 'fault'),
    [
        ('xs: [0, 1], ys: [0, 1], heights: [[0, 1], [2]], base: -1', 'rows of several lengths'),
        ('xs: [0, 1], ys: [0, 1], heights: "AAA=", base: -1', 'packed as base64'),
        ('xs: [0, 1], ys: [0, 1], heights: [[0, 1], [2, 3]]', 'missing `base`'),
        ('xs: [0, 1], ys: [0, 1], heights: [[0, 1], [2, 3]], base: 0', 'below all heights'),
    ],
)
def test_a_faulty_scene_file_is_refused_with_its_line(keys, fault):
    text = f'geometries:\n- {{name: t, shape: {{type: height_field, {keys}}}}}\n'
    with pytest.raises(RuntimeError, match=f':2: .*{fault}'):
        read_scene(text)
