"""Meshes of tetrahedra: what is asked of them, their boundary, and refining them."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import (
    ConvertVolumeToSurfaceMesh,
    GeometryError,
    RefineVolumeMesh,
    VolumeElement,
    VolumeMesh,
)
from drake_geom_ros.geometry.meshes.volume_surface import neighbours_of

CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]


def unit():
    return VolumeMesh([VolumeElement(0, 1, 2, 3)], CORNERS)


def test_what_a_mesh_says_of_an_element():
    mesh = unit()
    assert (mesh.num_elements(), mesh.num_vertices()) == (1, 4)
    assert [mesh.element(0).vertex(i) for i in range(4)] == [0, 1, 2, 3]
    assert mesh.tetrahedra()[0].num_vertices() == 4
    assert mesh.CalcTetrahedronVolume(0) == pytest.approx(1 / 6)
    assert mesh.edge_vector(0, 1, 3).tolist() == [-1, 0, 1]
    np.testing.assert_allclose(mesh.inward_normal(0, 0), -np.ones(3) / np.sqrt(3))
    for f in range(3):
        np.testing.assert_allclose(mesh.inward_normal(0, f + 1), np.eye(3)[f])
    np.testing.assert_allclose(mesh.CalcBarycentric([0.1, 0.2, 0.3], 0), [0.4, 0.1, 0.2, 0.3])
    assert mesh.Equal(unit())
    assert not mesh.Equal(VolumeMesh.FromArrays([[0, 1, 2, 3]], np.array(CORNERS) + 0.1))
    assert mesh.Equal(VolumeMesh.FromArrays([[0, 1, 2, 3]], np.array(CORNERS) + 0.1), 0.2)


@pytest.mark.parametrize(
    'ask',
    [
        lambda mesh: mesh.vertex(4),
        lambda mesh: mesh.element(1),
        lambda mesh: mesh.inward_normal(0, 4),
        lambda mesh: mesh.CalcTetrahedronVolume(-1),
        lambda mesh: VolumeMesh([VolumeElement(0, 1, 2, 4)], CORNERS),
        lambda mesh: VolumeElement(0, 1, 2, -3),
        lambda mesh: VolumeMesh.FromArrays([[0, 1, 2]], CORNERS),
        lambda mesh: VolumeMesh.FromArrays([[0, 1, 2, 3]], np.full((4, 3), np.nan)),
        lambda mesh: VolumeMesh.FromArrays([[0, 1, 2, 3]], np.zeros((4, 3))).CalcBarycentric(
            [0, 0, 0], 0
        ),
        lambda mesh: RefineVolumeMesh(VolumeMesh.FromArrays([[1, 0, 2, 3]], CORNERS)),
        lambda mesh: RefineVolumeMesh(VolumeMesh.FromArrays([[0, 1, 2, 2]], CORNERS)),
        lambda mesh: RefineVolumeMesh(VolumeMesh.FromArrays(np.zeros((0, 4), int), CORNERS)),
    ],
)
def test_what_is_not_there_is_refused(ask):
    with pytest.raises(RuntimeError):
        ask(unit())


def test_a_face_of_three_elements_is_refused():
    with pytest.raises(GeometryError, match='more than two'):
        neighbours_of(np.array([[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]]))


def kuhn(counts):
    """Return a brick of cubes, each cut into six tetrahedra along its diagonal."""
    nx, ny, nz = counts
    points = list(itertools.product(range(nx + 1), range(ny + 1), range(nz + 1)))
    number = {point: k for k, point in enumerate(points)}
    rows = []
    for cell in itertools.product(range(nx), range(ny), range(nz)):
        for order in itertools.permutations(range(3)):
            corner, row = list(cell), [number[cell]]
            for axis in order:
                corner[axis] += 1
                row.append(number[tuple(corner)])
            rows.append(row)
    elements, p_MVs = np.array(rows), np.array(points, dtype=float)
    a, b, c, d = (p_MVs[elements[:, k]] for k in range(4))
    turned = (np.cross(b - a, c - a) * (d - a)).sum(axis=1) < 0
    elements[turned] = elements[turned][:, [1, 0, 2, 3]]
    return VolumeMesh.FromArrays(elements, p_MVs)


@given(st.tuples(*[st.integers(1, 3)] * 3))
@settings(max_examples=12, deadline=None)
def test_refining_leaves_nothing_inside_with_all_corners_outside(counts):
    mesh = kuhn(counts)
    refined = RefineVolumeMesh(mesh)
    assert refined.CalcVolume() == pytest.approx(np.prod(counts), rel=1e-12)
    assert min(map(refined.CalcTetrahedronVolume, range(refined.num_elements()))) > 0.0
    surface = ConvertVolumeToSurfaceMesh(refined)
    assert surface.total_area() == pytest.approx(
        2 * (counts[0] * counts[1] + counts[1] * counts[2] + counts[0] * counts[2])
    )
    outside = {tuple(row) for row in np.round(surface.vertex_array(), 9).tolist()}
    is_outside = [tuple(row) in outside for row in np.round(refined.vertex_array(), 9).tolist()]
    boundary = {
        tuple(sorted(tuple(np.round(surface.vertex(v), 9)) for v in part))
        for row in surface.triangle_array().tolist()
        for size in (2, 3)
        for part in itertools.combinations(row, size)
    }
    for row in refined.element_array().tolist():
        assert not all(is_outside[v] for v in row)
        for size in (2, 3):
            for part in itertools.combinations(row, size):
                if all(is_outside[v] for v in part):
                    key = tuple(sorted(tuple(np.round(refined.vertex(v), 9)) for v in part))
                    assert key in boundary
    assert RefineVolumeMesh(refined) is refined


def test_the_boundary_is_turned_outward():
    surface = ConvertVolumeToSurfaceMesh(kuhn((2, 1, 1)))
    middle = np.array([1.0, 0.5, 0.5])
    for k in range(surface.num_triangles()):
        assert surface.face_normal(k) @ (surface.element_centroid(k) - middle) > 0.0
