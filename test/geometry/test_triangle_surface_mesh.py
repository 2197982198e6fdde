"""Meshes of triangles and of polygons: areas, normals, centroids."""

import copy

import numpy as np
import pytest

from drake_geom_ros.geometry import (
    PolygonSurfaceMesh,
    ReadObjToTriangleSurfaceMesh,
    SurfaceTriangle,
    TriangleSurfaceMesh,
)

# A rectangle of 2 by 1 in z = 0, turned up.
VERTICES = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]
TRIANGLES = [[0, 1, 2], [0, 2, 3]]


def rectangles():
    triangles = [SurfaceTriangle(v0=a, v1=b, v2=c) for a, b, c in TRIANGLES]
    return (
        TriangleSurfaceMesh(triangles=triangles, vertices=VERTICES),
        PolygonSurfaceMesh(face_data=[4, 0, 1, 2, 3], vertices=VERTICES),
    )


@pytest.mark.parametrize('mesh', rectangles())
def test_a_rectangle(mesh):
    assert mesh.num_vertices() == 4
    assert mesh.total_area() == 2
    assert mesh.centroid().tolist() == [1, 0.5, 0]
    centre, size = mesh.CalcBoundingBox()
    assert (centre.tolist(), size.tolist()) == ([1, 0.5, 0], [2, 1, 0])
    assert mesh.vertex(v=2).tolist() == [2, 1, 0]
    assert mesh.face_normal(0).tolist() == [0, 0, 1]
    assert mesh.Equal(mesh=copy.copy(mesh))
    assert mesh.element(e=0).vertex(i=1) == 1
    for k, words in ((-1, 'face -1'), (2, 'face 2 was asked for')):
        with pytest.raises(RuntimeError, match=words):
            mesh.area(k)
    with pytest.raises(RuntimeError, match='vertex 4 was asked for; there are 4'):
        mesh.vertex(4)


def test_triangles():
    mesh, _ = rectangles()
    assert (mesh.num_elements(), mesh.num_triangles(), len(mesh.triangles())) == (2, 2, 2)
    assert [vertex.tolist() for vertex in mesh.vertices()] == VERTICES
    assert (mesh.area(t=0), mesh.area(t=1)) == (1, 1)
    np.testing.assert_allclose(mesh.element_centroid(t=0), [4 / 3, 1 / 3, 0])
    other = TriangleSurfaceMesh.FromArrays(TRIANGLES[::-1], VERTICES)
    assert not mesh.Equal(other)
    assert mesh.Equal(TriangleSurfaceMesh.FromArrays(TRIANGLES, VERTICES))


def test_barycentric_coordinates():
    mesh, _ = rectangles()
    np.testing.assert_allclose(mesh.CalcBarycentric([0.5, 0.5, 3], t=0), [0.75, -0.25, 0.5])
    b_Q = [0.2, 0.3, 0.5]
    p_MQ = mesh.CalcCartesianFromBarycentric(element_index=1, b_Q=b_Q)
    np.testing.assert_allclose(mesh.CalcBarycentric(p_MQ=p_MQ, t=1), b_Q, rtol=0, atol=1e-15)


def test_polygons():
    # An L, not convex: of area 3 and centroid 5/6 along both arms.
    outline = [[0, 0, 7], [2, 0, 7], [2, 1, 7], [1, 1, 7], [1, 2, 7], [0, 2, 7]]
    mesh = PolygonSurfaceMesh([6, 0, 1, 2, 3, 4, 5, 3, 0, 1, 2], outline)
    assert (mesh.num_faces(), mesh.element(0).num_vertices()) == (2, 6)
    assert (mesh.area(f=0), mesh.area(f=1)) == (3, 1)
    np.testing.assert_allclose(mesh.element_centroid(e=0), [5 / 6, 5 / 6, 7])
    assert mesh.face_normal(f=0).tolist() == [0, 0, 1]
    assert mesh.face_data() == [6, 0, 1, 2, 3, 4, 5, 3, 0, 1, 2]
    empty = PolygonSurfaceMesh()
    assert (empty.num_faces(), empty.total_area()) == (0, 0)
    assert empty.centroid().tolist() == [0, 0, 0]
    assert not empty.Equal(mesh)
    assert not mesh.Equal(PolygonSurfaceMesh([6, 0, 1, 2, 3, 4, 5, 3, 0, 1, 3], outline))


def test_a_triangle_without_area():
    mesh = TriangleSurfaceMesh([SurfaceTriangle(0, 0, 1)], VERTICES)
    assert mesh.face_normal(0).tolist() == [0, 0, 0]
    assert mesh.centroid().tolist() == [0, 0, 0]
    assert mesh.element_centroid(0).tolist() == pytest.approx([2 / 3, 0, 0])


@pytest.mark.parametrize(
    ('make', 'words'),
    [
        (lambda: PolygonSurfaceMesh([3, 0, 1], VERTICES), 'face 0 is said to have 3 vertices'),
        (lambda: PolygonSurfaceMesh([2, 0, 1], VERTICES), 'must have 3 or more'),
        (lambda: PolygonSurfaceMesh([3, 0, 1, 4], VERTICES), r'face 0 has vertices \[0, 1, 4\]'),
        (lambda: TriangleSurfaceMesh([(0, 1, 2)], VERTICES), 'SurfaceTriangle'),
        (lambda: TriangleSurfaceMesh([], [[0, 0]]), r'vertices \(1, 2\) must be finite'),
    ],
)
def test_bad_meshes(make, words):
    with pytest.raises(RuntimeError, match=words):
        make()


def test_reading_with_a_scale_an_axis(tmp_path):
    path = tmp_path / 'corner.obj'
    path.write_text('v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n')
    mesh = ReadObjToTriangleSurfaceMesh(filename=path, scale3=[1, 2, -3])
    assert mesh.vertex_array().tolist() == np.diag([1, 2, -3]).tolist()
    assert ReadObjToTriangleSurfaceMesh(path, 2).vertex(0).tolist() == [2, 0, 0]
    with pytest.raises(RuntimeError, match='must be finite and not 0'):
        ReadObjToTriangleSurfaceMesh(path, scale3=[1, 0, 1])
