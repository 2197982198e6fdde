"""Polygons that are extruded along z, as zones of mobile robots are given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drake_geom_ros.geometry import Convex, Mesh, MeshData
from drake_geom_ros.geometry.shapes.extrusion import extruded
from drake_geom_ros.math.array_types import Floats


def prism_of(points: Sequence[Sequence[float]], height: float | Sequence[float]) -> Convex | Mesh:
    """Return a polygon (n, 2) [m] extruded from 0 to a height [m], or between two heights.

    The polygon runs either way round. It need not be convex: then the shape is a closed mesh,
    which has to count as a solid. Raises RuntimeError for an outline without area, and for heights
    that do not ascend.

    >>> type(prism_of([[0, 0], [2, 0], [1, 1]], [0.1, 1.0])).__name__
    'Convex'
    """
    low, high = height if isinstance(height, Sequence) else (0.0, height)
    data = extruded(points, high - low)
    vertices = data.vertices + np.array([0.0, 0.0, low])
    outline = vertices[: len(vertices) // 2, :2]
    if _is_convex(outline):
        return Convex.FromMeshData(MeshData(vertices, data.triangles))
    return Mesh.FromMeshData(MeshData(vertices, data.triangles))


def _is_convex(outline: Floats) -> bool:
    """Return whether no corner (n, 2) lies to the right of a side; the sides run left round."""
    dx, dy = (np.roll(outline, -1, axis=0) - outline).T[:, :, np.newaxis]
    to_x, to_y = np.moveaxis(outline[np.newaxis] - outline[:, np.newaxis], -1, 0)
    return bool((dx * to_y - dy * to_x >= 0.0).all())
