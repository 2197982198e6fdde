"""Volumes and oriented boxes of shapes."""

import itertools
import math

import numpy as np
import pytest

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import (
    Box,
    CalcObb,
    CalcVolume,
    Capsule,
    ComputeAabbForTriangleMesh,
    ComputeAabbForVolumeMesh,
    ComputeObbForTriangleMesh,
    ComputeObbForVolumeMesh,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    InMemoryMesh,
    Mesh,
    MeshcatCone,
    MeshData,
    Sphere,
    TriangleSurfaceMesh,
    VolumeMesh,
)
from drake_geom_ros.geometry.shapes.primitives import for_queries
from drake_geom_ros.math import RollPitchYaw

R = RollPitchYaw(0.4, 0.5, 0.6).ToRotationMatrix()
CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
CORNERS = [[2, 0, 0], [0, 1, 0], [0, 0, 3]]
# An L of two boxes: its hull is larger than what it encloses.
L = (
    'v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n'
    'v 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 2 1\nv 0 2 1\n'
    'f 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\n'
    'f 5 6 12 11\nf 6 1 7 12\n'
)


@pytest.mark.parametrize(
    ('shape', 'volume', 'half'),
    [
        (Sphere(2), 32 / 3 * math.pi, [2, 2, 2]),
        (Box(1, 2, 3), 6, [0.5, 1, 1.5]),
        (Cylinder(2, 3), 12 * math.pi, [2, 2, 1.5]),
        (Capsule(2, 3), (12 + 32 / 3) * math.pi, [2, 2, 3.5]),
        (Ellipsoid(1, 2, 3), 8 * math.pi, [1, 2, 3]),
        (MeshcatCone(3, 1, 2), 2 * math.pi, [1, 2, 1.5]),
    ],
)
def test_primitives(shape, volume, half):
    assert CalcVolume(shape) == pytest.approx(volume, rel=1e-15)
    box = CalcObb(shape)
    assert box.half_width().tolist() == half
    assert box.center().tolist() == [0, 0, 1.5 if isinstance(shape, MeshcatCone) else 0]


def test_a_half_space_has_no_end():
    assert CalcVolume(HalfSpace()) == math.inf
    assert CalcObb(HalfSpace()) is None
    with pytest.raises(RuntimeError, match='must be of type Shape'):
        CalcVolume('box')


def test_a_mesh_has_the_volume_that_it_encloses():
    mesh = InMemoryMesh(mesh_file=MemoryFile(L, '.obj', 'L'))
    assert CalcVolume(Mesh(mesh)) == pytest.approx(3)
    assert CalcVolume(Mesh(mesh, scale3=[-1, 2, 1])) == pytest.approx(6)
    assert CalcVolume(Convex(mesh)) == pytest.approx(3.5)


def test_the_box_of_a_turned_cube_is_the_cube():
    given = MeshData(CUBE * [1, 2, 3] @ R.matrix().T + [5, 6, 7])
    box = CalcObb(Convex.FromMeshData(given))
    assert sorted(box.half_width()) == pytest.approx([1, 2, 3], rel=1e-12)
    np.testing.assert_allclose(box.center(), [5, 6, 7], rtol=0, atol=1e-12)


@pytest.mark.parametrize('seed', range(10))
def test_a_box_holds_every_point(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(30, 3)) * rng.uniform(0.01, 3, 3) + rng.uniform(-9, 9, 3)
    box = CalcObb(Convex.FromMeshData(MeshData(points)))
    p_BVs = box.pose().inverse() @ points.T
    assert (box.half_width() >= np.abs(p_BVs).T).all()
    along_axes = np.ptp(points, axis=0).prod()
    assert box.CalcVolume() <= along_axes * (1 + 1e-9)


def test_a_flat_mesh_has_a_box():
    flat = InMemoryMesh(mesh_file=MemoryFile('v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n', '.obj', ''))
    half = np.sort(CalcObb(Mesh(flat)).half_width())
    assert half[0] == pytest.approx(0, abs=1e-14)
    assert half[1] * half[2] == pytest.approx(0.5)  # a right angle: twice the triangle's area


OF_TRIANGLES = (
    TriangleSurfaceMesh.FromArrays([[0, 1, 2], [1, 2, 3]], [[0, 0, 0], *CORNERS]),
    ComputeAabbForTriangleMesh,
    ComputeObbForTriangleMesh,
)
OF_TETRAHEDRA = (
    VolumeMesh.FromArrays([[0, 1, 2, 3]], [[0, 0, 0], *CORNERS]),
    ComputeAabbForVolumeMesh,
    ComputeObbForVolumeMesh,
)


@pytest.mark.parametrize(('mesh', 'along_axes', 'turned'), [OF_TRIANGLES, OF_TETRAHEDRA])
def test_boxes_around_some_vertices_of_a_mesh(mesh, along_axes, turned):
    flat = along_axes(mesh_M=mesh, vertices={1, 2, 3})
    assert (flat.lower().tolist(), flat.upper().tolist()) == ([0, 0, 0], [2, 1, 3])
    tight = turned(mesh_M=mesh, vertices={1, 2, 3})
    inside = np.abs(tight.pose().inverse() @ np.array(CORNERS, dtype=float).T).T
    assert (tight.half_width() >= inside).all()
    assert tight.half_width().min() == pytest.approx(0, abs=1e-13)
    for vertices, words in (({7}, 'vertex 7 was asked for'), ((), 'no vertex was given')):
        with pytest.raises(RuntimeError, match=words):
            along_axes(mesh, vertices)


def test_a_cone_is_for_pictures():
    cone = MeshcatCone(measures=[3, 1, 2])
    assert (cone.height(), cone.a(), cone.b()) == (3, 1, 2)
    assert (MeshcatCone(3).a(), MeshcatCone(height=3).b()) == (1, 1)
    assert eval(repr(cone)) == cone == MeshcatCone([3, 1, 2])
    with pytest.raises(RuntimeError, match='cannot have the proximity role'):
        for_queries(cone)
