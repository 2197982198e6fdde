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
from drake_geom_ros.geometry.meshes._oriented_hull import blocks_of, oriented_hull
from drake_geom_ros.math.array_types import Floats, Indices

HULL_EXPONENT = 24  # points are scaled to about 2^24 for hulls
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
    for some in blocks_of(len(points)):
        block = points[some] - centre
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
    """Return vertices and triangles of the hull that Qhull finds."""
    # trimesh merges vertices within 1e-8 and drops triangles below 1e-14, which is rounding at
    # this size. Scaling by a power of two is exact.
    exponent = HULL_EXPONENT - math.frexp(float(np.abs(points).max()))[1]
    scaled = np.ldexp(points, exponent)
    vertices, triangles = oriented_hull(scaled) or _repaired_hull(scaled)
    return np.ldexp(vertices, -exponent), triangles


def _repaired_hull(points: Floats) -> tuple[Floats, Indices]:
    import trimesh

    hull = trimesh.Trimesh(points, process=False).convex_hull
    return np.array(hull.vertices, dtype=np.float64), np.array(hull.faces, dtype=np.int64)


def _corners(vertices: Floats, triangles: Indices) -> NDArray[np.bool_]:
    """Return the mask of vertices of a hull that are proper corners.

    A vertex is not one if it lies, within rounding, in the planes of all faces around it, or on
    the segment between two vertices that it shares edges with.
    """
    noise = COPLANAR * EPS * float(np.ptp(vertices, axis=0).max())
    normals, areas = np.empty((len(triangles), 3)), np.empty(len(triangles))
    for some in blocks_of(len(triangles)):
        a, b, c = (vertices[triangles[some, k]] for k in range(3))
        crosses = np.cross(b - a, c - a)
        areas[some] = np.linalg.norm(crosses, axis=1)
        # It is zero for triangles without area, which hulls have where corners are collinear.
        sizes = areas[some, None]
        normals[some] = np.divide(crosses, sizes, out=np.zeros_like(crosses), where=sizes > 0.0)
    keep = np.ones(len(vertices), dtype=np.bool_)
    doubtful = _beside_flat_edges(vertices, triangles, normals, noise)
    if not len(doubtful):
        return keep
    owners = triangles.ravel()
    order = np.argsort(owners, kind='stable')
    ends = np.searchsorted(owners[order], np.arange(len(vertices) + 1))
    for vertex in doubtful.tolist():
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
    # An edge is one number, and they are looked at in blocks: all at once they would be the peak
    # of memory of a large hull.
    count, keys = len(vertices), np.empty(3 * len(triangles), dtype=np.int64)
    for k in range(3):
        one, other = triangles[:, k], triangles[:, (k + 1) % 3]
        keys[k::3] = np.minimum(one, other) * count + np.maximum(one, other)
    order = np.argsort(keys, kind='stable')[: len(keys) // 2 * 2]
    first, second = order[::2], order[1::2]
    flat = [np.zeros(0, dtype=np.int64)]
    for some in blocks_of(len(first)):
        one, other = first[some], second[some]
        edges = keys[one]
        apex = vertices[triangles[other // 3, (other % 3 + 2) % 3]]
        rises = np.abs(((apex - vertices[edges // count]) * normals[one // 3]).sum(axis=1))
        flat.append(edges[rises <= noise])
    flat_edges = np.concatenate(flat)
    return np.unique(np.concatenate((flat_edges // count, flat_edges % count)))


def _is_between(arms: Floats, noise: float) -> bool:
    """Return whether the origin is on a segment between two points (n, 3), to within ``noise``."""
    lengths = np.linalg.norm(arms, axis=1)
    units = arms / lengths[:, None]
    i, j = np.unravel_index(np.argmin(units @ units.T), (len(arms), len(arms)))
    if units[i] @ units[j] > 0.0:
        return False
    gap = arms[j] - arms[i]
    return float(np.linalg.norm(np.cross(arms[i], gap))) <= noise * float(np.linalg.norm(gap))
