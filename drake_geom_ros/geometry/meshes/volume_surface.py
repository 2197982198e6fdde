"""The boundary of a mesh of tetrahedra, and the refinement of elements without inner vertices."""

from __future__ import annotations

import itertools
from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.meshes._library import connected_pieces
from drake_geom_ros.geometry.meshes.surface_mesh import TriangleSurfaceMesh
from drake_geom_ros.geometry.meshes.volume_mesh import OUTER_FACES, VolumeMesh, signed_volumes
from drake_geom_ros.geometry.tolerances import FLAT_TETRAHEDRON
from drake_geom_ros.math.array_types import Floats, Indices


def ConvertVolumeToSurfaceMesh(volume: VolumeMesh) -> TriangleSurfaceMesh:
    """Return the boundary of a mesh of tetrahedra, in the same frame, oriented outward.

    The boundary consists of the faces of a single element, so neighbours must share vertices.

        >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        >>> volume = VolumeMesh.FromArrays([[0, 1, 2, 3]], corners)
        >>> ConvertVolumeToSurfaceMesh(volume).num_triangles()
        4
    """
    checked_type(volume, VolumeMesh, 'ConvertVolumeToSurfaceMesh: volume')
    faces = outer_faces(volume.element_array()).reshape(-1, 3)
    outer = faces[neighbours_of(volume.element_array()).ravel() < 0]
    used, triangles = np.unique(outer, return_inverse=True)
    return TriangleSurfaceMesh.FromArrays(
        triangles.reshape(-1, 3), volume.vertex_array()[used].reshape(-1, 3)
    )


def on_boundary(volume: VolumeMesh) -> NDArray[np.bool_]:
    """Return the mask (n,) of the vertices of a mesh on its boundary."""
    return _on_boundary(volume.element_array(), volume.num_vertices())


def count_pieces(volume: VolumeMesh) -> int:
    """Return the number of pieces of a mesh, between which no elements share a face."""
    neighbours = neighbours_of(volume.element_array())
    each = np.repeat(np.arange(len(neighbours)), 4)
    beyond = np.where(neighbours.ravel() < 0, each, neighbours.ravel())
    # Elements take the place of vertices: triangles of elements join them.
    return len(connected_pieces(np.column_stack((each, beyond, each)), len(neighbours)))


def _on_boundary(elements: Indices, count: int) -> NDArray[np.bool_]:
    is_outer = np.zeros(count, dtype=np.bool_)
    is_outer[outer_faces(elements).reshape(-1, 3)[neighbours_of(elements).ravel() < 0]] = True
    return is_outer


def outer_faces(elements: Indices) -> Indices:
    """Return the faces (m, 4, 3) of elements (m, 4), each oriented out of its element."""
    faces: Indices = elements[:, OUTER_FACES]
    return faces


def neighbours_of(elements: Indices) -> Indices:
    """Return the element (m, 4) beyond each face of each element, -1 for none.

    Raises GeometryError if more than two elements share a face.
    """
    keys = np.sort(outer_faces(elements).reshape(-1, 3), axis=1)
    order = np.lexsort(keys.T)
    same = (np.diff(keys[order], axis=0) == 0).all(axis=1)
    if (same[1:] & same[:-1]).any():
        shared = keys[order][1:][same][0].tolist()
        raise GeometryError(f'more than two tetrahedra share the face {shared}')
    neighbours = np.full(len(keys), -1, dtype=np.int64)
    first, second = order[:-1][same], order[1:][same]
    neighbours[first], neighbours[second] = second // 4, first // 4
    return neighbours.reshape(-1, 4)


def RefineVolumeMesh(mesh: VolumeMesh) -> VolumeMesh:
    """Return the mesh, cut where an inner edge, face or element has all corners on the boundary.

    A pressure that is 0 on the boundary is 0 all along such an edge, as if there were a hole. So
    the edge is halved in all elements around it. Then such faces, and then such elements, are cut
    about their centroids. Returns the same mesh if there are none. Raises RuntimeError for an
    element that has no volume or is inside out, and if two elements are on one side of a shared
    face.
    """
    checked_type(mesh, VolumeMesh, 'RefineVolumeMesh: mesh')
    check_elements(mesh, 'RefineVolumeMesh')
    elements, p_MVs = mesh.element_array(), mesh.vertex_array()
    for corners in (2, 3, 4):
        elements, p_MVs = _refined(elements, p_MVs, corners)
    if len(p_MVs) == mesh.num_vertices():
        return mesh
    return VolumeMesh.FromArrays(elements, p_MVs)


def check_elements(mesh: VolumeMesh, what: str) -> None:
    """Raise GeometryError for an element that has no volume or is inside out, and for an overlap.

    A volume below a billionth of the longest side cubed counts as none. Two elements on one side
    of a shared face overlap; other overlaps are not checked.
    """
    elements, p_MVs = mesh.element_array(), mesh.vertex_array()
    if not len(elements):
        raise GeometryError(f'{what}: the mesh has no tetrahedra')
    corners = p_MVs[elements]
    longest = np.ptp(corners, axis=1).max(axis=1)
    volumes = signed_volumes(elements, p_MVs)
    bad = volumes <= FLAT_TETRAHEDRON * longest**3 / 6.0
    if bad.any():
        e = int(np.argmax(bad))
        kind = 'is inside out' if volumes[e] < 0.0 else 'has no volume'
        raise GeometryError(
            f'{what}: element {e} {kind}: {volumes[e]:.3g} m^3, corners {corners[e].tolist()}; '
            'its first three corners must be counter-clockwise, seen from the fourth'
        )
    _check_sides(elements, what)


def _check_sides(elements: Indices, what: str) -> None:
    """Raise GeometryError if two elements are on one side of a shared face."""
    faces = outer_faces(elements).reshape(-1, 3)
    # Each face starts at its lowest vertex, so that faces of equal orientation are equal.
    turned = np.take_along_axis(faces, (faces.argmin(axis=1)[:, None] + [0, 1, 2]) % 3, axis=1)
    order = np.lexsort(turned.T)
    same = (np.diff(turned[order], axis=0) == 0).all(axis=1)
    if not same.any():
        return
    at = int(np.argmax(same))
    first, second = sorted((order[at : at + 2] // 4).tolist())
    face = turned[order[at]].tolist()
    if set(elements[first].tolist()) == set(elements[second].tolist()):
        why = f'are the same: vertices {sorted(elements[first].tolist())}'
    else:
        why = f'overlap: both are on one side of their face {face}'
    raise GeometryError(f'{what}: elements {first} and {second} {why}')


def _refined(elements: Indices, p_MVs: Floats, corners: int) -> tuple[Indices, Floats]:
    """Return the mesh after cutting the inner simplices whose ``corners`` are all on the boundary.

    Neither these simplices nor their centroids are on the boundary. So the boundary stays the
    same, and no other simplex becomes one to cut.
    """
    to_cut = _inner_on_boundary(elements, len(p_MVs), corners)
    if not len(to_cut):
        return elements, p_MVs
    rows = dict(enumerate(elements.tolist()))
    rows_at: defaultdict[int, set[int]] = defaultdict(set)
    for number, row in rows.items():
        for v in row:
            rows_at[v].add(number)
    fresh = itertools.count(len(rows))
    for middle, simplex in enumerate(to_cut.tolist(), len(p_MVs)):
        for number in sorted(set.intersection(*(rows_at[v] for v in simplex))):
            row = rows.pop(number)
            for v in row:
                rows_at[v].remove(number)
            for out, new in zip(simplex, fresh, strict=False):
                rows[new] = [middle if v == out else v for v in row]
                for v in rows[new]:
                    rows_at[v].add(new)
    return np.array(list(rows.values())), np.vstack((p_MVs, p_MVs[to_cut].mean(axis=1)))


def _inner_on_boundary(elements: Indices, count: int, corners: int) -> Indices:
    """Return the simplices (k, corners) that are inside and have all corners on the boundary."""
    outer = outer_faces(elements).reshape(-1, 3)[neighbours_of(elements).ravel() < 0]
    parts = _parts(elements, corners)
    inner = set(map(tuple, parts[_on_boundary(elements, count)[parts].all(axis=1)].tolist()))
    inner -= set(map(tuple, _parts(outer, corners).tolist()))
    return np.array(sorted(inner), dtype=np.int64).reshape(-1, corners)


def _parts(simplices: Indices, corners: int) -> Indices:
    """Return the edges, faces or elements (k, corners) of simplices, each ascending."""
    places = list(itertools.combinations(range(simplices.shape[1]), corners))
    parts = simplices[:, np.array(places, dtype=np.int64).reshape(-1, corners)]
    ascending: Indices = np.sort(parts.reshape(-1, corners), axis=1)
    return ascending
