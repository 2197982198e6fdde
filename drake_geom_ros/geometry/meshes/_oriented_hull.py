"""The triangles of Qhull, turned outwards in blocks: ``trimesh`` takes twice Qhull's memory."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drake_geom_ros.math.array_types import Floats, Indices

_BLOCK = 1 << 16  # points, or triangles, that are looked at together
_OPTIONS = 'Qt QbB Pp'  # triangles, of points scaled to a cube, without a report: as trimesh's
_SMALLEST = 2.0**-33  # twice the area of a triangle; trimesh drops those a thousand times smaller
_MERGED = 1e8  # trimesh merges vertices that are equal after so many parts of a unit
_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def blocks_of(count: int) -> Iterator[slice]:
    """Yield slices of at most some ten thousand rows, one after the other."""
    for first in range(0, count, _BLOCK):
        yield slice(first, min(first + _BLOCK, count))


def oriented_hull(points: Floats) -> tuple[Floats, Indices] | None:
    """Return vertices and triangles, counter-clockwise from outside, of the hull of points.

    They are those that trimesh returns, in the same order. None where it would repair something:
    where Qhull fails, or its triangles are tiny, share no corners, or close no surface.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points, qhull_options=_OPTIONS)
    except QhullError:
        return None
    corners = np.sort(hull.vertices)
    numbers = np.zeros(len(points), dtype=np.int64)
    numbers[corners] = np.arange(len(corners))
    vertices, triangles = hull.points[corners], numbers[hull.simplices]
    del hull, numbers
    if not _are_distinct(vertices) or not _turn_outwards(vertices, triangles):
        return None
    return (vertices, triangles) if _is_closed(triangles, len(vertices)) else None


def _are_distinct(vertices: Floats) -> bool:
    """Return whether trimesh would merge none of the vertices; False also where nobody knows."""
    keys = np.zeros(len(vertices), dtype=np.uint64)
    for k in range(3):
        column = (vertices[:, k] * _MERGED).round().astype(np.int64).view(np.uint64)
        keys ^= (column + np.uint64(k)) * _FACTORS[k]
    keys.sort()
    return not (keys[1:] == keys[:-1]).any()


def _turn_outwards(vertices: Floats, triangles: Indices) -> bool:
    """Turn triangles so that their normals point away from their centroid.

    Return False where one is too small for that.
    """
    total, weighted = 0.0, np.zeros(3)
    for some in blocks_of(len(triangles)):
        corners = vertices[triangles[some]]
        areas = np.linalg.norm(_crosses(corners), axis=1)
        if not (areas > _SMALLEST).all():
            return False
        total += float(areas.sum())
        weighted += areas @ corners.mean(axis=1)
    for some in blocks_of(len(triangles)):
        corners = vertices[triangles[some]]
        outwards = corners.mean(axis=1) - weighted / total
        backwards = np.flatnonzero((_crosses(corners) * outwards).sum(axis=1) < 0.0) + some.start
        triangles[backwards] = triangles[backwards][:, ::-1]
    return True


def _crosses(corners: Floats) -> Floats:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1])


def _is_closed(triangles: Indices, count: int) -> bool:
    """Return whether each edge is that of two triangles, once in each direction.

    Each of ``count`` vertices has to be a corner.
    """
    if not np.bincount(triangles.ravel(), minlength=count).all():
        return False
    there = np.concatenate([triangles[:, k] * count + triangles[:, (k + 1) % 3] for k in range(3)])
    there.sort()
    if (there[1:] == there[:-1]).any():
        return False
    back = there % count * count + there // count
    back.sort()
    return bool((there == back).all())
