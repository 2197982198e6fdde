"""Mesh files: hulls, scales, and files that are none; queries of what came from a file."""

import numpy as np
import pytest
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import (
    Box,
    Convex,
    GeometryError,
    GeometryInstance,
    HalfSpace,
    Mesh,
    MeshData,
    MeshFileError,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.geometry.meshes import source as mesh_source
from drake_geom_ros.geometry.meshes._formats import parse_mesh
from drake_geom_ros.geometry.meshes.source import hull_vertices
from drake_geom_ros.math import RigidTransform, RollPitchYaw

MANY = 300
CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
# Two triangles a side of the cube of edge 2, and a point inside that no hull has.
SIDES = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]


@pytest.fixture
def cube(tmp_path):
    """Return the path of a cube of edge 2 with a dent: its hull is the cube."""
    path = tmp_path / 'cube.obj'
    vertices = [*CORNERS, (0, 0, 0)]
    faces = [f for a, b, c, d in SIDES[1:] for f in ((a, b, c), (a, c, d))]
    a, b, c, d = SIDES[0]
    faces += [(a, b, 9), (b, c, 9), (c, d, 9), (d, a, 9)]
    lines = [f'v {x} {y} {z}' for x, y, z in vertices] + [f'f {a} {b} {c}' for a, b, c in faces]
    path.write_text('\n'.join(lines))
    return str(path)


def test_a_hull_has_the_extreme_vertices_scaled(cube):
    found = hull_vertices(cube, np.array([1.0, 2.0, -3.0]))
    expected = sorted((x, 2.0 * y, -3.0 * z) for x, y, z in CORNERS)
    assert sorted(map(tuple, found.tolist())) == expected


def test_a_file_that_changed_is_read_again(cube, tmp_path):
    before = hull_vertices(cube, np.ones(3))
    text = (tmp_path / 'cube.obj').read_text()
    (tmp_path / 'cube.obj').write_text(text.replace('v 1 1 1', 'v 1 1 1.5'))
    after = hull_vertices(cube, np.ones(3))
    assert before.max() == 1.0
    assert after.max() == 1.5


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        (None, 'cannot be read'),
        ('', 'it is empty'),
        ('nonsense', 'no faces'),
        ('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n', 'lie in a plane'),
        ('v 0 0 0\nv 1 0 0\nv 0 1 nan\nv 0 0 1\nf 1 2 3\nf 1 2 4\n', 'finite'),
    ],
)
def test_a_file_that_is_no_body_is_refused_and_changes_nothing(tmp_path, text, words):
    path = tmp_path / 'mesh.obj'
    if text is not None:
        path.write_text(text)
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    instance = GeometryInstance(RigidTransform(), Convex(str(path)), 'c')
    geometry = scene_graph.RegisterAnchoredGeometry(source, instance)
    with pytest.raises(MeshFileError, match=words):
        scene_graph.AssignRole(source, geometry, ProximityProperties())
    inspector = scene_graph.model_inspector()
    assert inspector.GetProximityProperties(geometry) is None
    assert scene_graph.CreateDefaultContext() is not None


def test_many_meshes_are_read_once_each(tmp_path, monkeypatch):
    """More than any cache of meshes holds; then the scene changes again and again."""
    read = []
    monkeypatch.setattr(
        mesh_source, 'parse_mesh', lambda *arguments: read.append(1) or parse_mesh(*arguments)
    )
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('s')
    geometries = []
    for k in range(MANY):
        path = tmp_path / f'{k}.obj'
        path.write_text(f'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 {1 + k}\nf 1 2 3\nf 1 2 4\n')
        instance = GeometryInstance(RigidTransform(), Convex(str(path)), f'g{k}')
        geometries.append(scene_graph.RegisterAnchoredGeometry(source, instance))
        scene_graph.AssignRole(source, geometries[-1], ProximityProperties())
    context = scene_graph.CreateDefaultContext()
    for k in range(3):
        scene_graph.RenameGeometry(geometries[k], f'other {k}')
        scene_graph.RemoveGeometry(source, geometries[-1 - k])
        points = scene_graph.CreateDefaultContext()
        query = scene_graph.get_query_output_port().Eval(points)
        assert len(query.ComputeSignedDistanceToPoint([5.0, 5.0, 5.0])) == MANY - 1 - k
    query = scene_graph.get_query_output_port().Eval(context)
    assert len(query.ComputeSignedDistanceToPoint([5.0, 5.0, 5.0])) == MANY
    assert len(read) == MANY


@pytest.mark.parametrize('kind', [Convex, Mesh])
@pytest.mark.parametrize('other', [Sphere(0.3), Box(1, 2, 3), HalfSpace()])
@pytest.mark.parametrize('height', [3.5, 1.2, 0.4])
def test_a_cube_from_a_file_answers_as_a_box(cube, kind, other, height):
    tilted = RigidTransform(RollPitchYaw(0.3, 0.5, 0.7), [0.1, -0.2, height])
    poses = [RigidTransform(), tilted]
    mesh = ShapeScene(other, kind(cube)).pair(*poses)
    box = ShapeScene(other, Box(2, 2, 2)).pair(*poses)
    assert mesh.distance == pytest.approx(box.distance, abs=1e-13)
    np.testing.assert_allclose(mesh.nhat_BA_W, box.nhat_BA_W, rtol=0, atol=1e-9)


def test_a_sphere_in_the_middle_of_a_cube_mesh_is_inside(cube):
    pair = ShapeScene(Mesh(cube, 0.5), Sphere(0.1)).posed([0, 0, 0], [0, 0, 0]).query
    (contact,) = pair.ComputePointPairPenetration()
    assert contact.depth == pytest.approx(0.6, abs=1e-13)
    points = pair.ComputeSignedDistanceToPoint([0.0, 0.0, 0.45])
    assert points.distance[0] == pytest.approx(-0.05, abs=1e-13)


@pytest.mark.parametrize('kind', [Convex, Mesh])
def test_a_mesh_of_numbers_answers_as_its_file(cube, kind):
    triangles = [(a - 1, b - 1, c - 1) for a, b, c, _ in SIDES]
    numbers = kind.FromMeshData(MeshData(CORNERS, triangles), 0.5)
    assert numbers == kind.FromMeshData(MeshData(CORNERS, triangles), 0.5)
    assert numbers != kind.FromMeshData(MeshData(CORNERS, triangles[:-1]), 0.5)
    assert 'FromMeshData' in repr(numbers)
    with pytest.raises(GeometryError, match='mesh_data'):
        numbers.filename()
    distances = [
        ShapeScene(shape, Sphere(0.3)).pair([0, 0, 0], [0.3, 0.1, 2.0]).distance
        for shape in (numbers, kind(cube, 0.5))
    ]
    assert distances[0] == pytest.approx(distances[1], abs=1e-14)


@pytest.mark.parametrize(
    ('vertices', 'triangles', 'words'),
    [
        ([[0, 0]], (), 'vertices'),
        ([[0, 0, np.inf]], (), 'finite'),
        (CORNERS, [[0, 1, 8]], '8 vertices'),
        (CORNERS, [[0, 1, -1]], 'counted from 0'),
        (CORNERS, [[0, 1]], 'triangles'),
    ],
)
def test_numbers_that_are_no_mesh_are_refused(vertices, triangles, words):
    with pytest.raises(RuntimeError, match=words):
        MeshData(vertices, triangles)
