"""Distances of points from a surface of triangles."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.math.array_types import Floats, Indices

_AT_ONCE = 2_000_000  # spheres around triangles that are processed together: some 50 MB


def distances_to_surface(points: Floats, vertices: Floats, triangles: Indices) -> Floats:
    """Return the distances (n,) [m] of points (n, 3) to the nearest of triangles (m, 3).

    Each triangle must have an area. A point is compared only with the triangles whose sphere,
    about the centroid, begins before the nearest end of any sphere.
    """
    corners = vertices[triangles]
    middles = corners.mean(axis=1)
    radii = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    nearest = np.empty(len(points))
    step = max(1, _AT_ONCE // max(1, len(triangles)))
    for first in range(0, len(points), step):
        some = points[first : first + step]
        gaps = np.linalg.norm(some[:, None] - middles, axis=2)
        near = gaps - radii <= (gaps + radii).min(axis=1, keepdims=True)
        of, triangle = np.nonzero(near)
        distances = _to_triangles(some[of], corners[triangle])
        nearest[first : first + step] = np.minimum.reduceat(
            distances, np.searchsorted(of, np.arange(len(some)))
        )
    return nearest


def _to_triangles(points: Floats, corners: Floats) -> Floats:
    """Return the distance (k,) of each point (k, 3) to its triangle (k, 3, 3).

    It is that to the plane if the point projects into the triangle, else that to the nearest side.
    """
    sides = np.roll(corners, -1, axis=1) - corners
    arms = points[:, None] - corners
    shares = np.clip((arms * sides).sum(axis=2) / (sides * sides).sum(axis=2), 0.0, 1.0)
    to_sides = np.linalg.norm(arms - shares[:, :, None] * sides, axis=2).min(axis=1)
    normals = np.cross(sides[:, 0], sides[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    inward = np.cross(normals[:, None], sides)
    above = ((inward * arms).sum(axis=2) >= 0.0).all(axis=1)
    heights = np.abs((arms[:, 0] * normals).sum(axis=1))
    distances: Floats = np.where(above, heights, to_sides)
    return distances
