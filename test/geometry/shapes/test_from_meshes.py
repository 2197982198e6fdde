"""Convex and Mesh of files, of files in memory, of points; and their hulls as polygons."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from oracles.small_scene import TETRAHEDRON

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import (
    Convex,
    InMemoryMesh,
    Mesh,
    MeshData,
    MeshFileError,
    MeshSource,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import tree_of
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SOLID
from drake_geom_ros.geometry.shapes.primitives import for_queries
from truth.bodies.grids import L, solid
from truth.bodies.random_bodies import random_directions, random_rotation

CUBE = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
CORNER = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
IN_MEMORY = InMemoryMesh(mesh_file=MemoryFile(TETRAHEDRON, '.obj', 'corner'))


@pytest.mark.parametrize('kind', [Convex, Mesh])
def test_a_mesh_in_memory_is_the_mesh_in_a_file(kind, tmp_path):
    path = tmp_path / 'corner.obj'
    path.write_text(TETRAHEDRON)
    on_disk = kind(path, scale=2)
    for shape in (
        kind(mesh_data=IN_MEMORY, scale=2),
        kind(source=MeshSource(IN_MEMORY), scale=2),
        kind(source=MeshSource(path), scale3=[2, 2, 2]),
        kind(IN_MEMORY, 2),
        kind.FromMeshData(kind(IN_MEMORY).mesh_data(), 2),
    ):
        for mine, its in zip(shape.hull_surface(), on_disk.hull_surface(), strict=True):
            np.testing.assert_array_equal(mine, its)
        assert shape.extension() == '.obj'
        assert shape.scale() == 2
        packed, other = (for_queries(each).in_pairs for each in (shape, on_disk))
        np.testing.assert_array_equal(packed.parameters, other.parameters)


def test_one_method_says_what_a_mesh_is_to_queries():
    """Its number belongs to its parameters: those of its hull, or of the body that it bounds."""
    shape = solid(L).shape
    hull, body = for_queries(shape), for_queries(shape, is_solid=True)
    assert (hull.in_pairs.kind, body.in_pairs.kind, body.to_points.kind) == (CONVEX, SOLID, SOLID)
    same = for_queries(Convex(shape.source()), is_solid=True).in_pairs
    assert same.kind == CONVEX
    np.testing.assert_array_equal(same.parameters, hull.in_pairs.parameters)
    assert tree_of(*body.in_pairs).triangles == len(shape.surface()[1])
    # A body that is convex is its hull, lists of neighbours and all.
    assert for_queries(Mesh(IN_MEMORY), is_solid=True).in_pairs.kind == CONVEX


@pytest.mark.parametrize('kind', [Convex, Mesh])
def test_what_a_shape_says_of_its_source(kind, tmp_path):
    shape = kind(mesh_data=IN_MEMORY, scale3=[1, 2, 3])
    assert shape.source() == MeshSource(mesh=IN_MEMORY)
    assert shape.mesh_data() == MeshData(CORNER, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    with pytest.raises(RuntimeError, match='not made of a file'):
        shape.filename()
    assert eval(repr(shape)) == shape == pickle.loads(pickle.dumps(shape)) == copy.deepcopy(shape)
    assert kind('/a/b.obj').source().path() == Path('/a/b.obj')
    assert kind('/a/b.obj').mesh_data() is None
    with pytest.raises(RuntimeError, match='give one of filename, mesh_data, source'):
        kind('/a/b.obj', mesh_data=IN_MEMORY)


def test_numbers_have_a_source_that_makes_them_again():
    given = MeshData(
        np.array([[0.1, 0, 0], [1 / 3, 0, 0], [0, 1e-20, 0], [0, 0, 1e30]]), [[0, 1, 2]]
    )
    text = Mesh.FromMeshData(given).source()
    assert text.extension() == '.obj'
    assert Mesh(text).mesh_data() == given


def test_a_convex_of_points():
    shape = Convex(points=CORNER.T, label='corner', scale=2)
    file = shape.source().in_memory().mesh_file
    assert file.contents() == b'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n'
    assert file.filename_hint() == 'corner'
    assert sorted(shape.hull_surface()[0].tolist()) == sorted((2 * CORNER).tolist())
    for points, label, words in (
        (CORNER.T, None, 'label = None'),
        (CORNER.T, 'a\nb', 'one line'),
        (CORNER, 'a', r'\(4, 3\) must be finite'),
        (np.full((3, 4), np.nan), 'a', 'must be finite'),
    ):
        with pytest.raises(RuntimeError, match=words):
            Convex(points=points, label=label)
    with pytest.raises(RuntimeError, match='one of points, mesh_data'):
        Convex(points=CORNER.T, label='a', mesh_data=IN_MEMORY)


@pytest.mark.parametrize('scale3', [[1, 1, 1], [1, 2, 3], [-1, 2, 3]])
def test_the_hull_of_a_cube_has_six_squares(scale3):
    hull = Convex.FromMeshData(MeshData(CUBE), scale3).GetConvexHull()
    size = np.abs(scale3)
    assert (hull.num_faces(), hull.num_vertices()) == (6, 8)
    assert [hull.element(e).num_vertices() for e in range(6)] == [4] * 6
    areas = sorted(2 * [size[0] * size[1], size[1] * size[2], size[2] * size[0]])
    assert sorted(hull.area(f) for f in range(6)) == pytest.approx(areas)
    centre = 0.5 * np.array(scale3)
    np.testing.assert_allclose(hull.centroid(), centre, rtol=0, atol=1e-15)
    for f in range(6):  # outwards
        assert hull.face_normal(f) @ (hull.element_centroid(f) - centre) > 0


def test_the_hull_of_a_ball_of_points():
    points = random_directions(np.random.default_rng(4), 60)
    shape = Convex.FromMeshData(MeshData(points))
    hull, (vertices, triangles) = shape.GetConvexHull(), shape.hull_surface()
    assert hull.num_faces() == len(triangles)
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert hull.total_area() == pytest.approx(0.5 * np.linalg.norm(cross, axis=1).sum())


@pytest.mark.parametrize('seed', range(12))
@pytest.mark.parametrize('offset', [0.0, 1.0])
def test_the_hull_of_a_turned_grid(seed, offset):
    """Rounding bends the faces of a small body far from its origin: nothing of them is lost."""
    rng = np.random.default_rng(seed)
    turn = random_rotation(rng)
    grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, 5)] * 3), axis=-1).reshape(-1, 3)
    size = 10.0 ** rng.uniform(-6, 1)
    points = grid * [1, 2, 3] @ turn.T * size + offset * rng.normal(size=3)
    hull = Convex.FromMeshData(MeshData(points)).GetConvexHull()
    rounding = 1e-13 * (1.0 + offset / size)
    assert hull.total_area() == pytest.approx(88 * size**2, rel=rounding)
    if not offset:
        assert hull.num_faces() == 6


def test_hulls_that_there_are_none():
    with pytest.raises(MeshFileError, match=r"MakeConvexHull only applies to .*'\.ext'"):
        Mesh('/a/b.ext').GetConvexHull()
    with pytest.raises(MeshFileError, match=r"mesh in memory 'flat'.*lie in a plane"):
        Convex(points=CORNER[:3].T, label='flat').GetConvexHull()
    with pytest.raises(MeshFileError, match='no faces and no vertices'):
        Mesh(InMemoryMesh(mesh_file=MemoryFile('# ', '.obj', 'junk'))).hull_surface()


def test_a_mesh_in_memory():
    other = InMemoryMesh(mesh_file=MemoryFile(TETRAHEDRON, '.obj', 'corner'), supporting_files={})
    assert other == IN_MEMORY
    assert hash(other) == hash(IN_MEMORY)
    assert InMemoryMesh().mesh_file == MemoryFile()
    full = InMemoryMesh(mesh_file=MemoryFile(), supporting_files={'a': MemoryFile('x', '.a', 'a')})
    for mesh in (IN_MEMORY, full):
        assert eval(repr(mesh)) == mesh == pickle.loads(pickle.dumps(mesh)) == copy.copy(mesh)
    with pytest.raises(RuntimeError, match='must be of type MemoryFile'):
        InMemoryMesh(mesh_file='v 0 0 0')


def test_a_mesh_source():
    source = MeshSource(path='/a/b.OBJ')
    assert source.is_path()
    assert not source.is_in_memory()
    assert (source.path(), source.extension()) == (Path('/a/b.OBJ'), '.obj')
    assert source.description() == '/a/b.OBJ'
    memory = MeshSource(mesh=IN_MEMORY)
    assert memory.is_in_memory()
    assert (memory.description(), memory.in_memory()) == ('corner', IN_MEMORY)
    for each in (source, memory, MeshSource()):
        assert MeshSource(other=each) == eval(repr(each)) == each
        assert len({each, MeshSource(each)}) == 1
    for call, words in (
        (source.in_memory, 'is a file'),
        (memory.path, 'is in memory'),
        (lambda: MeshSource(3), 'neither a path nor a mesh'),
        (lambda: MeshSource('/a', mesh=IN_MEMORY), 'give one of'),
    ):
        with pytest.raises(RuntimeError, match=words):
            call()
