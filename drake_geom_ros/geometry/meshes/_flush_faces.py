"""Cuts out the common area of faces that lie on each other face to face.

Where a block stands on a plate, and both are bodies of one mesh, the area in which they meet is
inside the solid. It is no part of the boundary, so it is cut out of both faces.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING
from drake_geom_ros.geometry.tolerances import ALMOST_OPPOSITE
from drake_geom_ros.math.array_types import Floats, Indices

# Any direction of planes (n, d) that no two planes of a construction have in common.
_DIRECTION = np.array([0.7385489, 0.3141593, 0.5772157, 0.1618034])


class CutCorners(NamedTuple):
    """Corners (m, 3, 3) [m] of triangles, and the index (m,) of the triangle that each was."""

    corners: Floats
    origins: Indices


def without_flush_areas(corners: Floats) -> CutCorners | None:
    """Return triangles (n, 3, 3) [m] without the areas in which two lie face to face.

    Both are in one plane, to the rounding of the coordinates, with opposite normals. None if no
    two do.
    """
    near = ROUNDING * EPS * float(np.abs(corners).max())
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = crosses / np.linalg.norm(crosses, axis=1, keepdims=True)
    partners: dict[int, list[int]] = {}
    for i, j in _face_to_face(corners, normals, near):
        partners.setdefault(i, []).append(j)
        partners.setdefault(j, []).append(i)
    pieces = [corners[[k for k in range(len(corners)) if k not in partners]]]
    origins = [[k for k in range(len(corners)) if k not in partners]]
    is_cut = False
    for i, others in partners.items():
        polygons = [corners[i]]
        for j in others:
            polygons = [
                part
                for each in polygons
                for part in _difference(each, corners[j], normals[j], near)
            ]
        is_cut = is_cut or len(polygons) != 1 or polygons[0] is not corners[i]
        fans = [polygon[[0, k, k + 1]] for polygon in polygons for k in range(1, len(polygon) - 1)]
        pieces += [fan[None] for fan in fans]
        origins.append([i] * len(fans))
    if not is_cut:
        return None
    return CutCorners(np.concatenate(pieces), np.concatenate(origins).astype(np.int64))


def _face_to_face(corners: Floats, normals: Floats, near: float) -> Iterator[tuple[int, int]]:
    """Yield the pairs of triangles with opposite normals in one plane, whose boxes meet."""
    offsets = (normals * corners[:, 0]).sum(axis=1) / (float(np.abs(corners).max()) or 1.0)
    marks = np.column_stack((normals, offsets)) @ _DIRECTION
    order = np.argsort(marks, kind='stable')
    first = np.searchsorted(marks[order], -marks - 2.0 * ALMOST_OPPOSITE)
    last = np.searchsorted(marks[order], -marks + 2.0 * ALMOST_OPPOSITE)
    lows, highs = corners.min(axis=1) - near, corners.max(axis=1) + near
    for i in np.flatnonzero(last > first).tolist():
        others = order[first[i] : last[i]]
        others = others[(others > i) & (normals[others] @ normals[i] < ALMOST_OPPOSITE - 1.0)]
        meet = (lows[others] <= highs[i]).all(axis=1) & (highs[others] >= lows[i]).all(axis=1)
        for j in others[meet].tolist():
            if _in_plane(corners[j], corners[i, 0], normals[i], near) and _in_plane(
                corners[i], corners[j, 0], normals[j], near
            ):
                yield i, j


def _in_plane(points: Floats, p: Floats, normal: Floats, near: float) -> bool:
    return bool((np.abs((points - p) @ normal) <= near).all())


def _difference(polygon: Floats, triangle: Floats, normal: Floats, near: float) -> list[Floats]:
    """Return the convex parts (k, 3) of a convex polygon that are outside a triangle.

    ``normal`` is that of the triangle. A polygon that has no area in common with it is returned
    as it is.
    """
    outside: list[Floats] = []
    rest = polygon
    for k in range(3):
        edge = triangle[(k + 1) % 3] - triangle[k]
        outward = np.cross(edge, normal) / np.linalg.norm(edge)
        heights = (rest - triangle[k]) @ outward
        heights[np.abs(heights) <= near] = 0.0
        if (heights >= 0.0).all():
            return [polygon]
        if (heights > 0.0).any():
            outside.append(_above(rest, heights))
            rest = _above(rest, -heights)
    return outside


def _above(polygon: Floats, heights: Floats) -> Floats:
    """Return the part of a convex polygon with heights of 0 and above; some are above."""
    corners: list[Floats] = []
    for k, height in enumerate(heights):
        m = (k + 1) % len(heights)
        if height >= 0.0:
            corners.append(polygon[k])
        if height * heights[m] < 0.0:
            share = height / (height - heights[m])
            corners.append(polygon[k] + share * (polygon[m] - polygon[k]))
    return np.array(corners)
