"""The faces of a convex hull as polygons: its triangles, merged where they lie in one plane."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry._proximity.tolerances import COPLANAR, EPS, SAME_VOLUME
from drake_geom_ros.math.array_types import Floats, Indices


def united(vertices: Floats, triangles: Indices) -> list[list[int]]:
    """Return the polygons of a hull's triangles (m, 3), counter-clockwise from outside.

    A face consists of a triangle and the neighbours in its plane, within rounding. If they form no
    convex polygon, because rounding hides the plane, they stay triangles.
    """
    noise = COPLANAR * EPS * float(np.abs(vertices).max())
    edges = {
        (int(row[i]), int(row[i - 2])): k for k, row in enumerate(triangles) for i in range(3)
    }
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    normals /= 2.0 * areas[:, None]
    free = np.ones(len(triangles), dtype=np.bool_)
    polygons = []
    # Start at the largest triangle, whose plane is the most precise.
    for seed in np.argsort(-areas, kind='stable').tolist():
        if not free[seed]:
            continue
        offset = a[seed] @ normals[seed]
        face, free[seed] = [seed], False
        for k in face:
            for beyond in _neighbours(triangles[k].tolist(), edges):
                rises = vertices[triangles[beyond]] @ normals[seed] - offset
                if free[beyond] and np.abs(rises).max() <= noise:
                    free[beyond] = False
                    face.append(beyond)
        polygons += _joined(vertices, triangles[face], normals[seed], float(areas[face].sum()))
    return polygons


def _neighbours(corners: list[int], edges: dict[tuple[int, int], int]) -> list[int]:
    """Return the triangles beyond the edges of one: three, except where slivers were left out."""
    twins = [(corners[i - 2], corners[i]) for i in range(3)]
    return [edges[twin] for twin in twins if twin in edges]


def _joined(vertices: Floats, face: Indices, normal: Floats, area: float) -> list[list[int]]:
    """Return triangles (k, 3) as the convex polygon of their area [m^2], or unchanged.

    The polygon has their vertices in the order of their angles around a unit normal (3,).
    """
    triangles: list[list[int]] = face.tolist()
    if len(face) == 1:
        return triangles
    names = np.unique(face)
    arms = vertices[names] - vertices[names].mean(axis=0)
    side = np.cross(normal, arms[0])
    order = np.argsort(np.arctan2(arms @ side, arms @ np.cross(side, normal)))
    around = arms[order]
    polygon_area = 0.5 * float(np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0) @ normal)
    return [names[order].tolist()] if abs(polygon_area - area) <= SAME_VOLUME * area else triangles
