"""Solids between two copies of an outline, for formats that have such a shape."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.meshes._polygons import triangulate
from drake_geom_ros.geometry.meshes.source import MeshData


def extruded(outline: ArrayLike, height: float) -> MeshData:
    """Return the closed surface of an outline (n, 2) [m], extruded from z = 0 to ``height`` [m].

    The outline may run either way round, and repeat its first point at its end. Raises
    RuntimeError for fewer than three points, no area, or a height that is not above 0. Whether the
    outline crosses itself is judged when the mesh becomes a solid.

    >>> len(extruded([[0, 0], [1, 0], [0, 1]], 2.0).triangles)
    8
    """
    points = np.array(outline, dtype=np.float64).reshape(-1, 2)
    if len(points) > 1 and (points[0] == points[-1]).all():
        points = points[:-1]
    if len(points) < 3 or not np.isfinite(points).all() or not 0.0 < height < math.inf:
        raise ArgumentError(
            f'an outline of {len(points)} points with the height {height}: three finite points '
            'or more are needed, and a height > 0'
        )
    x, y = points.T
    doubled_area = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    if doubled_area == 0.0:
        raise ArgumentError('the outline has no area')
    if doubled_area < 0.0:
        points = points[::-1]
    count = len(points)
    low = np.column_stack((points, np.zeros(count)))
    cap = triangulate(list(range(count)), [tuple(point) for point in low.tolist()])
    top = np.array(cap, dtype=np.int64)
    here = np.arange(count)
    ahead = np.roll(here, -1)
    walls = (
        np.column_stack((here, ahead, ahead + count)),
        np.column_stack((here, ahead + count, here + count)),
    )
    return MeshData(
        np.vstack((low, np.add(low, [0.0, 0.0, height]))),
        np.vstack((top[:, ::-1], top + count, *walls)),
    )
