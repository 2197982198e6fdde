"""Packing of a hull's kernel parameters: vertices, an inner ball, edges, a coarse hull."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import (
    COARSE_HULL,
    DEFECT,
    LISTS,
)
from drake_geom_ros.geometry._proximity.kinds import VERTEX_COUNT
from drake_geom_ros.geometry._proximity.tolerances import BLUNT, EPS, PLAIN_DEPTH

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Vertices from which on hill climbing is used; below, a scan is faster (bench/costs).
CLIMBED = 500


class CoarseHull(NamedTuple):
    """The hull of some vertices of a hull, and a bound of how far the hull reaches beyond it."""

    vertices: Floats  # (n, 3) [m]
    triangles: Indices  # (m, 3), counter-clockwise from outside
    reach: float  # [m]


def hull_parameters(
    vertices: Floats, triangles: Indices, coarse: CoarseHull | None = None
) -> Floats:
    """Return the parameters of a hull in the layout of ``kernels.shapes.hulls``.

    ``vertices`` (n, 3) [m] are the corners of the hull, ``triangles`` (m, 3) its surface,
    counter-clockwise from outside.
    """
    return _with_coarse_hull(_exact_parameters(vertices, triangles), coarse)


def _exact_parameters(vertices: Floats, triangles: Indices) -> Floats:
    """Return the parameters of a hull without a coarse hull, with lists if it is large."""
    count, unlisted = len(vertices), _unlisted(vertices, triangles)
    if count < CLIMBED:
        return unlisted
    sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = np.unique(np.concatenate((sides, sides[:, ::-1])), axis=0)
    sharpness = _sharpness(vertices, triangles, edges)
    blunt = sharpness < BLUNT
    if np.count_nonzero(blunt) > count // 8:  # most climbs would end in a scan
        return unlisted
    # Computed gains are off by 3 EPS of the edge. A vertex whose edges all seem to descend is
    # extreme for a direction off by only 3 EPS over its sharpness, in radians.
    defect = 4.0 * EPS / sharpness[~blunt].min() * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    summits = [side(vertices[:, k]) for k in range(3) for side in (np.argmin, np.argmax)]
    starts, ends = edges.T
    lists = 3 * count + LISTS + count + 1 + np.searchsorted(starts, np.arange(count + 1))
    lists[:-1][blunt] *= -1
    places = 1 + np.concatenate((summits, ends))
    unlisted[3 * count + DEFECT] = defect
    return np.concatenate((unlisted, places[:6], lists, places[6:]))


def unlisted_parameters(
    vertices: Floats, triangles: Indices, coarse: CoarseHull | None = None
) -> Floats:
    """Return the parameters of a hull of any size whose vertices are always scanned.

    Bounds from such a hull are certified by all its vertices.
    """
    return _with_coarse_hull(_unlisted(vertices, triangles), coarse)


def _with_coarse_hull(parameters: Floats, coarse: CoarseHull | None) -> Floats:
    """Return the parameters of a hull, with its coarse hull, if any, at their end."""
    if coarse is None:
        return parameters
    parameters[3 * int(parameters[VERTEX_COUNT]) + COARSE_HULL] = len(parameters)
    inside = _unlisted(coarse.vertices, coarse.triangles)
    return np.concatenate((parameters, [coarse.reach], inside))


def _unlisted(vertices: Floats, triangles: Indices) -> Floats:
    radius = np.hypot.reduce(vertices, axis=1).max()
    ball = _ball(vertices, triangles)
    return np.concatenate(([len(vertices)], vertices.T.ravel(), [0.0], ball, [radius, 0.0]))


def _ball(vertices: Floats, triangles: Indices) -> Floats:
    """Return the centre and radius (4,) [m] of the largest ball about the centroid of a hull.

    The radius is 0 if the hull is so flat that the ball is negligible.
    """
    size = float(np.abs(vertices).max())
    corners = vertices / size  # about 1, so that nothing overflows
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    normals, middle = np.cross(b - a, c - a), corners.mean(axis=0)
    areas, volumes = np.linalg.norm(normals, axis=1), ((a - middle) * normals).sum(axis=1)
    if not volumes.sum() > 0.0 or not areas.all():
        return np.zeros(4)
    centre = np.average((middle + a + b + c) / 4.0, axis=0, weights=volumes)
    rooms = ((a - centre) * normals).sum(axis=1) / areas
    # The normal of a triangle is off by some EPS over its area.
    radius = float((rooms - 16.0 * EPS / areas).min())
    seen = radius > PLAIN_DEPTH * float(np.ptp(corners, axis=0).max())
    return size * np.append(centre, radius if seen else 0.0)


def _sharpness(vertices: Floats, triangles: Indices, edges: Indices) -> Floats:
    """Return the sine (n,) of the least angle by which edges fall away from each vertex.

    It is relative to the plane normal to the mean of the adjacent normals; 0 without edges.
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
    means = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(means, triangles[:, k], normals)
    means /= np.maximum(np.linalg.norm(means, axis=1), np.finfo(float).tiny)[:, None]
    starts, ends = edges.T
    along = vertices[ends] - vertices[starts]
    falls = -np.einsum('ij,ij->i', along, means[starts]) / np.linalg.norm(along, axis=1)
    sharpness = np.full(len(vertices), np.inf)
    np.minimum.at(sharpness, starts, falls)
    return np.where(np.isfinite(sharpness), np.maximum(sharpness, 0.0), 0.0)
