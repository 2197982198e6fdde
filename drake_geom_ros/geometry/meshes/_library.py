"""Functions that use trimesh: convex hulls, smallest boxes, clusters, connected pieces.

They import it when called, since the import takes 0.5 s and most scenes have no mesh. Only this
file and ``_by_trimesh`` import it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.tolerances import (
    COPLANAR,
    EPS,
    FLAT_HULL,
)
from drake_geom_ros.geometry.errors import MeshFileError
from drake_geom_ros.math.array_types import Floats, Indices

HULL_EXPONENT = 24  # points are scaled to about 2^24 for hulls
_BLOCK = 1 << 16  # points, or triangles, that are looked at together
_CLEAR = 2.0**-20  # ratio of squared extents that no rounding of their sums can make


def tight_box(points: Floats) -> Floats:
    """Return the axes, columns of a rotation (3, 3), of a smallest box around points (n, 3).

    One side of the box lies in a face of the points' hull.
    """
    import trimesh

    axes: Floats = trimesh.bounds.oriented_bounds(points)[0][:3, :3].T  # type: ignore[no-untyped-call]
    # Of points in a plane trimesh 4.2 returns a reflection on some CPUs; of a box either will do.
    return axes if np.linalg.det(axes) > 0.0 else -axes


def extent_axes(points: Floats) -> tuple[Floats, Floats]:
    """Return axes (3, 3) of points, widest first, and the extents (k,) [m] beyond rounding.

    Rows of the axes are unit vectors. k is 3, or less for points in a plane, a line or a point.
    """
    padded = np.vstack((points - points.mean(axis=0), np.zeros((3, 3))))
    _, extents, axes = np.linalg.svd(padded, full_matrices=False)
    rank = int(np.count_nonzero(extents > FLAT_HULL * extents[0]))
    return axes, extents[:rank]


def convex_hull(points: Floats, name: str) -> tuple[Floats, Indices]:
    """Return vertices and triangles, counter-clockwise from outside, of the convex hull of points.

    Points inside a face or an edge of the hull, within rounding, are not among its vertices.
    ``name`` is for the error. Raises MeshFileError if the hull has no volume.
    """
    if _is_flat(points):
        raise MeshFileError(
            f'{name}: its {len(points)} vertices lie in a plane, and a convex hull without '
            'a volume has no inside; give the mesh a thickness, or a robot of a scene file the '
            'key `flat_meshes`'
        )
    vertices, triangles = _hull(points)
    while (corners := _corners(vertices, triangles)).sum() < len(vertices):
        vertices, triangles = _hull(vertices[corners])
    vertices.flags.writeable = triangles.flags.writeable = False
    return vertices, triangles


def _is_flat(points: Floats) -> bool:
    """Return whether points (n, 3) lie in a plane, a line or a point, as ``extent_axes`` judges.

    Squares of the extents, summed up in blocks, decide unless rounding could matter, because a
    decomposition makes three copies of the points.
    """
    centre, squares = points.mean(axis=0), np.zeros((3, 3))
    for first in range(0, len(points), _BLOCK):
        block = points[first : first + _BLOCK] - centre
        with np.errstate(over='ignore', invalid='ignore'):
            squares += block.T @ block
    least, _, largest = np.linalg.eigvalsh(squares) if np.isfinite(squares).all() else (0, 0, 0)
    return not least > _CLEAR * largest and len(extent_axes(points)[1]) < 3


def near_one_another(points: Floats, apart: float) -> list[Indices]:
    """Return clusters of points (n, 3), by index: each has another within ``apart`` [m].

    Isolated points are in no cluster.
    """
    import trimesh

    groups: list[Indices] = list(
        trimesh.grouping.clusters(points, apart)  # type: ignore[no-untyped-call]
    )
    return groups


def connected_pieces(triangles: Indices, count: int) -> list[Indices]:
    """Return the triangles of each piece, joined by any of its ``count`` vertices."""
    from trimesh.graph import connected_component_labels as labelled

    edges = triangles[:, [[0, 1], [1, 2]]].reshape(-1, 2)
    labels = labelled(edges, node_count=count)  # type: ignore[no-untyped-call]
    _, of = np.unique(labels[triangles[:, 0]], return_inverse=True)
    order = np.argsort(of, kind='stable')
    return np.split(order, np.searchsorted(of[order], np.arange(1, int(of.max()) + 1)))


def _hull(points: Floats) -> tuple[Floats, Indices]:
    import trimesh

    # trimesh merges vertices within 1e-8 and drops triangles below 1e-14, which is rounding at
    # this size. Scaling by a power of two is exact.
    exponent = HULL_EXPONENT - math.frexp(float(np.abs(points).max()))[1]
    hull = trimesh.Trimesh(np.ldexp(points, exponent), process=False).convex_hull
    vertices = np.ldexp(np.array(hull.vertices, dtype=np.float64), -exponent)
    return vertices, np.array(hull.faces, dtype=np.int64)


def _corners(vertices: Floats, triangles: Indices) -> NDArray[np.bool_]:
    """Return the mask of vertices of a hull that are proper corners.

    A vertex is not one if it lies, within rounding, in the planes of all faces around it, or on
    the segment between two vertices that it shares edges with.
    """
    noise = COPLANAR * EPS * float(np.ptp(vertices, axis=0).max())
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    # It is zero for triangles without area, which hulls have where corners are collinear.
    normals = np.divide(
        normals, areas[:, None], out=np.zeros_like(normals), where=areas[:, None] > 0.0
    )
    owners = triangles.ravel()
    order = np.argsort(owners, kind='stable')
    ends = np.searchsorted(owners[order], np.arange(len(vertices) + 1))
    keep = np.ones(len(vertices), dtype=np.bool_)
    for vertex in _beside_flat_edges(vertices, triangles, normals, noise).tolist():
        around = order[ends[vertex] : ends[vertex + 1]] // 3
        ring = np.setdiff1d(triangles[around], [vertex])
        if not keep[ring].all():
            continue  # if two depend on each other, one stays until the next hull
        arms = vertices[ring] - vertices[vertex]
        largest = around[np.argmax(areas[around])]
        flat = np.abs(arms @ normals[largest]).max() <= noise
        keep[vertex] = not (flat or _is_between(arms, noise))
    return keep


def _beside_flat_edges(
    vertices: Floats, triangles: Indices, normals: Floats, noise: float
) -> Indices:
    """Return the vertices on an edge between two coplanar triangles: only these may be dropped."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    order = np.lexsort((edges[:, 1], edges[:, 0]))[: len(edges) // 2 * 2]
    first, second = order[::2], order[1::2]
    apex = vertices[triangles[second // 3, (second % 3 + 2) % 3]]
    rises = np.abs(((apex - vertices[edges[first, 0]]) * normals[first // 3]).sum(axis=1))
    return np.unique(edges[first[rises <= noise]])


def _is_between(arms: Floats, noise: float) -> bool:
    """Return whether the origin is on a segment between two points (n, 3), to within ``noise``."""
    lengths = np.linalg.norm(arms, axis=1)
    units = arms / lengths[:, None]
    i, j = np.unravel_index(np.argmin(units @ units.T), (len(arms), len(arms)))
    if units[i] @ units[j] > 0.0:
        return False
    gap = arms[j] - arms[i]
    return float(np.linalg.norm(np.cross(arms[i], gap))) <= noise * float(np.linalg.norm(gap))
