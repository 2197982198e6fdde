"""Coarse hulls: some vertices of a convex hull, and a bound of how far the hull is beyond them.

The hull of some vertices is contained in the hull of all. The distance from it is a convex
function, so it is largest at a vertex: the largest distance of a vertex from the coarse hull, its
*reach*, bounds that of every point. Signed distances from the hull are then less than those from
the coarse hull by no more than the reach.

Vertices are chosen as in Quickhull (Barber, Dobkin, Huhdanpaa, 1996): the extreme ones of some
directions first, then, several at a time, those farthest above faces of the hull so far.
"""

from __future__ import annotations

import itertools

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import CoarseHull
from drake_geom_ros.geometry._proximity.tolerances import COARSEST_GAP, EPS
from drake_geom_ros.geometry.meshes._library import extent_axes
from drake_geom_ros.geometry.meshes._surface_distances import distances_to_triangles
from drake_geom_ros.math.array_types import Floats, Indices

MANY, FEW = 128, 64  # vertices from which on a hull has a coarse one, and how many that has
_AT_ONCE = 12  # vertices that are added before the next hull is made
_CHECKED, _ROUNDS = 32, 32  # vertices that are compared with every triangle, so many times
_BLOCK = 4096  # vertices that are looked at together
_DIRECTIONS = np.array([d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)])


def chosen_vertices(vertices: Floats) -> tuple[Indices, Indices] | None:
    """Return FEW of the vertices (n, 3) of a hull by number, and the triangles (m, 3) of these.

    None for a hull of less than MANY. Any scaling along the axes may follow: the surface remains
    that of the hull of these vertices.
    """
    if len(vertices) < MANY:
        return None
    axes, extents = extent_axes(vertices)
    if len(extents) < 3:
        return None
    axes[2] *= np.sign(np.linalg.det(axes))  # no reflection, which would reverse triangles
    # At about the same size along all axes, Qhull meets no sliver.
    shares = (vertices - vertices.mean(axis=0)) @ (axes.T / extents)
    chosen = np.unique([(shares @ direction).argmax() for direction in _DIRECTIONS])
    while True:
        triangles = _hull_of(shares[chosen])
        if triangles is None:
            return None
        if len(chosen) >= FEW:
            used, corners = np.unique(triangles, return_inverse=True)
            return chosen[used], corners.reshape(-1, 3)
        above, faces = _above_faces(vertices, vertices[chosen][triangles])
        order = np.lexsort((-above, faces))
        firsts = order[np.unique(faces[order], return_index=True)[1]]  # the highest above each
        firsts = firsts[np.argsort(-above[firsts], kind='stable')]
        added = np.setdiff1d(firsts[: min(_AT_ONCE, FEW - len(chosen))], chosen)
        if not len(added):
            used, corners = np.unique(triangles, return_inverse=True)
            return chosen[used], corners.reshape(-1, 3)
        chosen = np.concatenate((chosen, added))


def coarse_hull(vertices: Floats, chosen: Indices, triangles: Indices) -> CoarseHull:
    """Return the hull of the ``chosen`` of vertices (n, 3) [m], with its reach.

    The reach is rounded up, to more than any answer of ``exact`` may be off.
    """
    few = vertices[chosen]
    # At about 1, so that nothing overflows.
    _, exponent = np.frexp(np.abs(vertices).max())
    points, corners = np.ldexp(vertices, -exponent), np.ldexp(few, -exponent)[triangles]
    distances = _upper_distances(points, corners)
    distances[chosen] = 0.0
    is_nearest = np.zeros(len(points), dtype=np.bool_)
    is_nearest[chosen] = True
    for _ in range(_ROUNDS):
        if is_nearest[distances.argmax()]:
            break
        far = np.argsort(np.where(is_nearest, 0.0, -distances), kind='stable')[:_CHECKED]
        every = np.broadcast_to(corners, (len(far), *corners.shape)).reshape(-1, 3, 3)
        to_each = distances_to_triangles(np.repeat(points[far], len(corners), axis=0), every)
        distances[far], is_nearest[far] = to_each.reshape(len(far), -1).min(axis=1), True
    size = float(np.ldexp(1.0, exponent))
    rounding = 256.0 * EPS * size + 4.0 * COARSEST_GAP * min(1.0, size)
    reach = float(np.ldexp(distances.max(), exponent)) + rounding
    return CoarseHull(few, triangles, reach)


def _hull_of(points: Floats) -> Indices | None:
    """Return the triangles (m, 3) of the convex hull of points (n, 3), counter-clockwise.

    Not all points need be its vertices. None where Qhull finds no hull with a volume.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except QhullError:
        return None
    triangles: Indices = hull.simplices.astype(np.int64)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inwards = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return triangles


def _above_faces(points: Floats, corners: Floats) -> tuple[Floats, Indices]:
    """Return the largest height (n,) of points above the planes of faces (m, 3, 3), and the face.

    A face without an area has no plane.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    offsets = (normals * a[lengths > 0.0]).sum(axis=1)
    numbers = np.flatnonzero(lengths > 0.0)
    heights, faces = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    for first in range(0, len(points), _BLOCK):
        some = slice(first, first + _BLOCK)
        above = points[some] @ normals.T - offsets
        highest = above.argmax(axis=1)
        heights[some], faces[some] = above[np.arange(len(above)), highest], numbers[highest]
    return heights, faces


def _upper_distances(points: Floats, corners: Floats) -> Floats:
    """Return upper bounds (n,) of the distances of points from the hull of triangles (m, 3, 3).

    They are the distances from the triangle that a point is farthest above.
    """
    _, faces = _above_faces(points, corners)
    distances = np.empty(len(points))
    for first in range(0, len(points), _BLOCK):
        some = slice(first, first + _BLOCK)
        distances[some] = distances_to_triangles(points[some], corners[faces[some]])
    return distances
