"""Distances of points from a surface of triangles."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.math.array_types import Floats, Indices

_AT_ONCE = 2_000_000  # spheres around triangles that are processed together: some 50 MB


def distances_to_surface(points: Floats, vertices: Floats, triangles: Indices) -> Floats:
    """Return the distances (n,) [m] of points (n, 3) to the nearest of triangles (m, 3).

    A point is compared only with the triangles whose sphere, about the centroid, begins before
    the nearest end of any sphere.
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
        distances = distances_to_triangles(some[of], corners[triangle])
        nearest[first : first + step] = np.minimum.reduceat(
            distances, np.searchsorted(of, np.arange(len(some)))
        )
    return nearest


def distances_to_triangles(points: Floats, corners: Floats) -> Floats:
    """Return the distance (n,) of each point (n, 3) from a point of its triangle (n, 3, 3).

    It is the nearest one, within rounding. Any weights that are not negative and whose sum is 1
    give a point of the triangle, so no ill-conditioned triangle makes the distance too small.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = (u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)
    wu, wv = (w * u).sum(axis=1), (w * v).sum(axis=1)
    with np.errstate(divide='ignore', invalid='ignore'):
        s = np.nan_to_num((vv * wu - uv * wv) / (uu * vv - uv * uv), nan=-1.0)
        t = np.nan_to_num((uu * wv - uv * wu) / (uu * vv - uv * uv), nan=-1.0)
    inside = (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
    s, t = np.where(inside, s, 0.0), np.where(inside, t, 0.0)
    nearest: Floats = np.linalg.norm(w - s[:, None] * u - t[:, None] * v, axis=1)
    for p, q in ((a, b), (b, c), (c, a)):
        along, away = q - p, points - p
        with np.errstate(divide='ignore', invalid='ignore'):
            share = (away * along).sum(axis=1) / (along * along).sum(axis=1)
        share = np.clip(np.nan_to_num(share, nan=0.0), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(away - share[:, None] * along, axis=1))
    return nearest
