"""The parameters of a hull for the kernels: its vertices, a ball in it, edges of a large one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import DEFECT, LISTS
from drake_geom_ros.geometry._proximity.tolerances import BLUNT, EPS, PLAIN_DEPTH

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Vertices from which on a hull is climbed; to look at all of fewer is faster (bench/costs).
CLIMBED = 500


def hull_parameters(vertices: Floats, triangles: Indices) -> Floats:
    """Return the parameters of a hull as ``kernels.shapes.hulls`` lays them out.

    ``vertices`` (n, 3) [m] are the corners of the hull, ``triangles`` (m, 3) its surface,
    counter-clockwise from outside.
    """
    count, unlisted = len(vertices), unlisted_parameters(vertices, triangles)
    if count < CLIMBED:
        return unlisted
    sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = np.unique(np.concatenate((sides, sides[:, ::-1])), axis=0)
    sharpness = _sharpness(vertices, triangles, edges)
    blunt = sharpness < BLUNT
    if np.count_nonzero(blunt) > count // 8:  # most climbs would end in looking at all
        return unlisted
    # Computed gains are off by 3 EPS of the edge. A vertex whose edges all seem to lead down is
    # the summit for a direction this little off, in radians: 3 EPS over its sharpness.
    defect = 4.0 * EPS / sharpness[~blunt].min() * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    summits = [side(vertices[:, k]) for k in range(3) for side in (np.argmin, np.argmax)]
    starts, ends = edges.T
    lists = 3 * count + LISTS + count + 1 + np.searchsorted(starts, np.arange(count + 1))
    lists[:-1][blunt] *= -1
    places = 1 + np.concatenate((summits, ends))
    unlisted[3 * count + DEFECT] = defect
    return np.concatenate((unlisted, places[:6], lists, places[6:]))


def unlisted_parameters(vertices: Floats, triangles: Indices) -> Floats:
    """Return the parameters of a hull of which every vertex is looked at, however many there are.

    What is certified by such a hull is certified by each of its vertices.
    """
    radius = np.hypot.reduce(vertices, axis=1).max()
    ball = _ball(vertices, triangles)
    return np.concatenate(([len(vertices)], vertices.T.ravel(), [0.0], ball, [radius]))


def _ball(vertices: Floats, triangles: Indices) -> Floats:
    """Return centre and radius (4,) [m] of a ball in a hull: the largest about its centroid.

    The radius is 0 where the hull is so flat that nobody would see the ball.
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
    """Return the sine (n,) of the angle by which the edges of each vertex at least fall away.

    From the plane at right angles to the mean of the normals around it; 0 where there are none.
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
