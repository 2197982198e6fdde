"""SurfaceMesh and its parts."""

import math

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    MeshFileError,
    ReadObjToSurfaceMesh,
    SurfaceFace,
    SurfaceMesh,
    SurfaceVertex,
)

CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def tetrahedron():
    return SurfaceMesh([SurfaceFace(*f) for f in FACES], [SurfaceVertex(c) for c in CORNERS])


def test_parts():
    vertex, face = SurfaceVertex(r_MV=[1, 2, 3]), SurfaceFace(4, 5, 6)
    assert vertex.r_MV().tolist() == [1, 2, 3]
    assert [face.vertex(i) for i in range(face.num_vertices())] == [4, 5, 6]
    assert repr(vertex) == 'SurfaceVertex([1.0, 2.0, 3.0])'
    assert repr(face) == 'SurfaceFace(4, 5, 6)'


@pytest.mark.parametrize('mesh', [tetrahedron(), SurfaceMesh.FromArrays(FACES, CORNERS)])
def test_mesh(mesh):
    assert (mesh.num_faces(), mesh.num_vertices()) == (4, 4)
    assert [[f.vertex(i) for i in range(3)] for f in mesh.faces()] == FACES
    assert [v.r_MV().tolist() for v in mesh.vertices()] == CORNERS
    assert mesh.triangle_array().tolist() == FACES
    assert mesh.vertex_array().tolist() == CORNERS
    for array in (mesh.triangle_array(), mesh.vertex_array()):
        with pytest.raises(ValueError, match='read-only'):
            array[0] = 9


def test_keywords_and_an_empty_mesh():
    assert SurfaceMesh(faces=[], vertices=[]).num_faces() == 0


def test_arrays_are_copied():
    triangles, vertices = np.array(FACES), np.array(CORNERS, dtype=float)
    mesh = SurfaceMesh.FromArrays(triangles, vertices)
    triangles[0] = vertices[0] = 9
    assert mesh.triangle_array().tolist() == FACES
    assert mesh.vertex_array().tolist() == CORNERS


@pytest.mark.parametrize(
    ('make', 'words'),
    [
        (lambda: SurfaceVertex([1, 2]), 'r_MV'),
        (lambda: SurfaceVertex([1, 2, math.nan]), 'finite'),
        (lambda: SurfaceFace(0, 1, -1), r'\(0, 1, -1\) must be >= 0'),
        (lambda: SurfaceFace(0, 1, 2).vertex(3), 'i = 3 must be from 0 to 2'),
        (lambda: SurfaceMesh([SurfaceFace(0, 1, 4)], []), r'face 0 has vertices \[0, 1, 4\]'),
        (lambda: SurfaceMesh([(0, 1, 2)], []), 'SurfaceFace'),
        (lambda: SurfaceMesh([], [[0, 0, 0]]), 'SurfaceVertex'),
        (lambda: SurfaceMesh.FromArrays([[0, 1, 4]], CORNERS), 'allowed are 0 to 3'),
        (lambda: SurfaceMesh.FromArrays([[0, 1, -1]], CORNERS), r'\[0, 1, -1\]'),
        (lambda: SurfaceMesh.FromArrays([[0, 1]], CORNERS), r'\(1, 2\) must be integers'),
        (lambda: SurfaceMesh.FromArrays([[0.0, 1, 2]], CORNERS), 'must be integers'),
        (lambda: SurfaceMesh.FromArrays(FACES, [[0, 0]]), r'p_MVs \(1, 2\)'),
        (lambda: SurfaceMesh.FromArrays(FACES, [[0, 0, math.inf]]), 'finite'),
    ],
)
def test_bad_parts(make, words):
    with pytest.raises(RuntimeError, match=words):
        make()


def test_reading_with_a_scale(tmp_path):
    path = tmp_path / 'cube.obj'
    path.write_text('v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n')
    assert ReadObjToSurfaceMesh(str(path)).vertex_array().tolist() == np.eye(3).tolist()
    mesh = ReadObjToSurfaceMesh(filename=path, scale=-0.5)
    assert mesh.vertex_array().tolist() == (-0.5 * np.eye(3)).tolist()
    assert mesh.num_faces() == 1
    for scale in (0.0, math.nan):
        with pytest.raises(RuntimeError, match='scale'):
            ReadObjToSurfaceMesh(path, scale)
    with pytest.raises(MeshFileError, match='cannot be read'):
        ReadObjToSurfaceMesh(tmp_path / 'none.obj')
