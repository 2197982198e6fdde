"""Conditions for meshes to be solids, and the kernel parameters of solids.

A surface is the boundary of a solid if every edge of a triangle is matched by one in the opposite
direction, no two triangles cross, and its pieces bound one body: a piece inside another is a
cavity with the opposite orientation.

- Vertices in the same place are merged (see ``_welding``).
- Triangles with two corners in one place are left out, and so are two that lie back to back.
- A mesh that is inside out as a whole is reversed.
- Triangles without area match edges at T-junctions; after this they are left out.
- Where two bodies lie on each other, the common area of their faces is cut out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import (
    hull_parameters,
    unlisted_parameters,
)
from drake_geom_ros.geometry._proximity.kernels.solids.crossings import first_crossing
from drake_geom_ros.geometry._proximity.kernels.solids.packing import (
    solid_parameters,
    with_boxes,
)
from drake_geom_ros.geometry._proximity.kernels.solids.pieces import slices_of
from drake_geom_ros.geometry._proximity.kernels.solids.solid import CORNERS, tree_of
from drake_geom_ros.geometry._proximity.kernels.solids.winding import find_astray
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SOLID
from drake_geom_ros.geometry._proximity.tolerances import (
    COPLANAR,
    EPS,
    LARGE_SIZE,
    NO_VOLUME,
    SAME_VOLUME,
    SMALL_SIZE,
)
from drake_geom_ros.geometry.errors import MeshFileError
from drake_geom_ros.geometry.meshes._flush_faces import without_flush_areas
from drake_geom_ros.geometry.meshes._library import connected_pieces
from drake_geom_ros.geometry.meshes._welding import ADVICE, ClosedSurface, closed_surface
from drake_geom_ros.geometry.meshes.source import (
    MeshGiven,
    MeshKey,
    coarse_hull_of,
    hull_of,
    mesh_source,
    name_of,
    triangles_of,
    turned,
)
from drake_geom_ros.math.array_types import Floats, Indices

# Faces of the hull that are tried as separating directions: each visits all vertices of the hull.
MOST_PLANES = 64
# Descriptions of welds by mesh and scale, which are queried after packing; the closed surfaces
# themselves would be a second copy of each mesh.
_weldings: dict[tuple[MeshKey, tuple[float, ...]], tuple[str, ...]] = {}
_MOST_WELDINGS = 32


def solid_of(mesh: MeshGiven, scale: tuple[float, ...]) -> tuple[int, Floats]:
    """Return the type number and the kernel parameters of a mesh as a solid.

    A convex mesh is replaced by its hull. Raises MeshFileError for a mesh that bounds no solid.
    """
    source = mesh_source(mesh)
    name = name_of(source)
    factors = np.array(scale)
    check_size(triangles_of(source).vertices, factors, name)
    hull_vertices, hull_triangles = hull_of(source)
    hull_vertices, hull_triangles = hull_vertices * factors, turned(hull_triangles, factors)
    vertices, triangles, *_ = _closed(source, scale)
    corners = vertices[triangles]
    if volume(corners) < 0.0:
        triangles = triangles[:, ::-1]
        corners = vertices[triangles]
    size = float(np.ptp(vertices, axis=0).max())
    if volume(corners) <= NO_VOLUME * size**3:
        raise MeshFileError(f'{name}: its surface encloses no volume; {ADVICE}')
    live = have_area(corners)
    pieces = [
        piece[live[piece]]
        for piece in connected_pieces(triangles, len(vertices))
        if live[piece].any()
    ]
    full, coarse = volume(hull_vertices[hull_triangles]), coarse_hull_of(mesh, factors)
    same = len(pieces) == 1 and abs(volume(corners) - full) <= SAME_VOLUME * full
    if same and is_convex(vertices, triangles, live, size):
        return CONVEX, hull_parameters(hull_vertices, hull_triangles, coarse)
    hull = unlisted_parameters(hull_vertices, hull_triangles, coarse)
    planes = planes_of(hull_vertices, hull_triangles)
    live_number = np.cumsum(live) - 1  # index of each triangle among those with an area
    crowded = at_crowded_edges(triangles)
    crowded = live_number[crowded[live[crowded]]]
    pieces = [live_number[piece] for piece in pieces]
    if not live.all():
        triangles = triangles[live]
    del corners  # a fifth of what parameters take
    try:
        parameters = _packed(hull, vertices, triangles, pieces, crowded, planes, name)
    except MeshFileError:
        cut = without_flush_areas(vertices[triangles])
        if cut is None:
            raise
        pieces = [np.flatnonzero(np.isin(cut.origins, piece)) for piece in pieces]
        crowded = np.flatnonzero(np.isin(cut.origins, crowded))
        vertices, triangles = cut.corners.reshape(-1, 3), np.arange(3 * len(cut.corners))
        triangles = triangles.reshape(-1, 3)
        parameters = _packed(hull, vertices, triangles, pieces, crowded, planes, name)
    parameters = with_boxes(parameters)
    parameters.flags.writeable = False
    return SOLID, parameters


def _packed(
    hull: Floats,
    vertices: Floats,
    triangles: Indices,
    pieces: list[Indices],
    crowded: Indices,
    planes: Floats,
    name: str,
) -> Floats:
    """Return the parameters of triangles (n, 3) with areas; raises as ``check_simple``.

    ``pieces`` and ``crowded`` are indices of triangles.
    """
    areas = areas_of(vertices, triangles)
    largest = np.array([p[np.argmax(areas[p])] for p in pieces if len(p)], dtype=np.int64)
    parameters, numbers = solid_parameters(hull, vertices, triangles, largest, planes)
    check_simple(parameters, numbers[largest], numbers[crowded], name)
    return parameters


def _closed(source: MeshKey, scale: tuple[float, ...]) -> ClosedSurface:
    vertices, triangles = triangles_of(source)
    factors = np.array(scale)
    surface = closed_surface(vertices * factors, turned(triangles, factors), name_of(source))
    if len(_weldings) >= _MOST_WELDINGS:
        _weldings.clear()
    _weldings[source, scale] = surface.remarks()
    return surface


def weldings_of(mesh: MeshGiven, scale: tuple[float, ...]) -> tuple[str, ...]:
    """Return descriptions of the welds that make a mesh a solid; raises as ``solid_of``."""
    source = mesh_source(mesh)
    remarks = _weldings.get((source, scale))
    return _closed(source, scale).remarks() if remarks is None else remarks


def check_size(vertices: Floats, factors: Floats, name: str) -> None:
    """Raise MeshFileError if products of three lengths of a scaled mesh exceed float64."""
    with np.errstate(over='ignore', under='ignore'):
        farthest = float(np.abs(vertices * factors).max(initial=0.0))
        size = float((np.ptp(vertices, axis=0) * np.abs(factors)).max()) if len(vertices) else 1.0
    if farthest > LARGE_SIZE or size < SMALL_SIZE:
        raise MeshFileError(
            f'{name}: scaled by {factors.tolist()}, it reaches to {farthest:g} m and is '
            f'{size:g} m large; a solid is at least {SMALL_SIZE:.3g} m large, and no coordinate '
            f'of it is beyond {LARGE_SIZE:.3g} m. {ADVICE}'
        )


def volume(corners: Floats) -> float:
    """Return the volume [m^3] inside a closed surface of triangles (n, 3, 3)."""
    a, b, c = (corners - corners[0, 0]).transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum()) / 6.0


def have_area(corners: Floats) -> NDArray[np.bool_]:
    """Return the mask of triangles (n, 3, 3) with an area: not collinear within rounding.

    The rounding is that of the corners' coordinates.
    """
    sides = corners - np.roll(corners, 1, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    enough: NDArray[np.bool_] = areas > EPS * np.abs(corners).max(axis=(1, 2)) * longest
    return enough


def is_convex(vertices: Floats, triangles: Indices, live: NDArray[np.bool_], size: float) -> bool:
    """Return whether a closed surface of one piece is convex: at every edge, to rounding.

    A closed surface that is convex everywhere about its points bounds a convex body (van
    Heijenoort, Communications on Pure and Applied Mathematics 5 (3), 1952). ``live`` (n,) is the
    mask of triangles with an area. Edges of the others hide the triangles that meet there, so
    triangles beside them must have all vertices beneath them.
    """
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    codes = np.sort(edges, axis=1) @ np.array([len(vertices), 1])
    order = np.argsort(codes, kind='stable')
    if (np.unique(codes, return_counts=True)[1] != 2).any():
        return False
    first, second = order[::2], order[1::2]
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    apex = vertices[triangles[second // 3, (second % 3 + 2) % 3]]
    rises = ((apex - vertices[edges[first, 0]]) * normals[first // 3]).sum(axis=1)
    # Two flat sides back to back pass the test at their edges, but their normals differ.
    folded = (normals[first // 3] * normals[second // 3]).sum(axis=1) <= -0.5
    level = np.abs(rises) <= COPLANAR * EPS * size
    if (rises > COPLANAR * EPS * size).any() or (folded & level).any():
        return False
    first, second = first // 3, second // 3
    beside = np.unique(np.concatenate((first[~live[second]], second[~live[first]])))
    for k in beside[live[beside]].tolist():
        heights = (vertices - corners[k, 0]) @ normals[k]
        if heights.max() > COPLANAR * EPS * size:
            return False
    return True


def planes_of(vertices: Floats, triangles: Indices) -> Floats:
    """Return outward unit normal and offset [m] of the largest faces of a hull, (f, 4)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1, keepdims=True)
    largest = np.argsort(-areas[:, 0], kind='stable')[:MOST_PLANES]
    largest = largest[areas[largest, 0] > 0.0]
    normals, a = normals[largest] / areas[largest], a[largest]
    return np.hstack((normals, (normals * a).sum(axis=1, keepdims=True)))


def areas_of(vertices: Floats, triangles: Indices) -> Floats:
    """Return twice the areas (n,) [m^2] of triangles (n, 3)."""
    areas = np.empty(len(triangles))
    for some in slices_of(len(triangles)):
        a, b, c = vertices[triangles[some]].transpose(1, 0, 2)
        areas[some] = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return areas


def at_crowded_edges(triangles: Indices) -> Indices:
    """Return the indices of the triangles at edges that more than two share."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    codes = edges[:, 0] * (int(triangles.max()) + 1) + edges[:, 1]
    _, at, counts = np.unique(codes, return_inverse=True, return_counts=True)
    return np.flatnonzero((counts[at.ravel()] > 2).reshape(-1, 3).any(axis=1))


def check_simple(parameters: Floats, pieces: Indices, crowded: Indices, name: str) -> None:
    """Raise MeshFileError if triangles cross or pieces do not bound one body.

    ``pieces`` (c,) has a triangle of each piece. Two surfaces may cross along edges, where no
    triangle goes through another. Then some of the triangles that touch others there, or of the
    ``crowded`` ones (k,), lie inside a body. All are indices in the parameters.
    """
    crossing = np.empty((2, 3, 3))
    touching = np.zeros(tree_of(SOLID, parameters).triangles, dtype=np.bool_)
    if first_crossing(parameters, crossing, touching):
        raise _crosses_itself(name, crossing)
    astray = _astray(parameters, pieces)
    if len(astray):
        raise MeshFileError(
            f'{name} bounds no solid: {len(astray)} of its {len(pieces)} closed surfaces '
            'lie in another and are turned like a body, or in none and are turned like a cavity; '
            f'leave out bodies within bodies, and turn cavities inside out. {ADVICE}'
        )
    touching[crowded] = True
    astray = _astray(parameters, np.flatnonzero(touching))
    if len(astray):
        at = tree_of(SOLID, parameters).corners + CORNERS * int(astray[0])
        raise _crosses_itself(name, parameters[at : at + CORNERS].reshape(1, 3, 3))


def _astray(parameters: Floats, triangles: Indices) -> Indices:
    """Return the mask of triangles with another body beneath or above them."""
    flags = np.empty(len(triangles), dtype=np.bool_)
    find_astray(parameters, triangles, flags)
    return triangles[flags]


def _crosses_itself(name: str, crossing: Floats) -> MeshFileError:
    where = crossing.mean(axis=(0, 1)).tolist()
    return MeshFileError(
        f'{name} bounds no solid: its surface crosses itself, at about {where}; unite the bodies '
        f'or mend the surface (a boolean union does both). {ADVICE}'
    )
