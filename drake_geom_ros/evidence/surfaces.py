"""What bodies are: how far they reach along a direction, and how far a point is from a surface.

Plain formulas to judge answers by, ours too; nothing of the engine takes part.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from drake_geom_ros.evidence.hard_cases.cases import FROM_VERTICES, Body, Floats
from drake_geom_ros.evidence.tolerances import ALIGNED
from drake_geom_ros.evidence.truth.meshes import point_distance


def reach(body: Body, n: Floats) -> float:
    """Return the support value [m] of a body along a unit vector, from its origin."""
    d = body.R.T @ n
    s = np.asarray(body.size, dtype=float)
    if body.kind == 'Sphere':
        return float(s[0])
    if body.kind == 'Box':
        return float(0.5 * s @ np.abs(d))
    if body.kind == 'Capsule':
        return float(s[0] + 0.5 * s[1] * abs(d[2]))
    if body.kind == 'Cylinder':
        return float(s[0] * math.hypot(d[0], d[1]) + 0.5 * s[1] * abs(d[2]))
    if body.kind == 'Ellipsoid':
        return math.hypot(*(s * d))
    if body.kind in FROM_VERTICES:
        return float((s @ d).max())
    return 0.0 if np.linalg.norm(d - [0.0, 0.0, 1.0]) <= ALIGNED else math.inf


def width(a: Body, b: Body, nhat_BA_W: Floats) -> float:
    """Return the gap [m] between the supporting planes along a normal: at most the distance.

    Of a Solid they are those of its hull.
    """
    return float((a.p - b.p) @ nhat_BA_W) - reach(a, -nhat_BA_W) - reach(b, nhat_BA_W)


def height(body: Body, p_W: Floats) -> float:
    """Return how far [m] a point near a body's surface is outside, negative inside."""
    q = body.R.T @ (p_W - body.p)
    s = np.asarray(body.size, dtype=float)
    if body.kind == 'HalfSpace':
        return float(q[2])
    if body.kind == 'Solid':
        return body.radius * float(point_distance(body.corners / body.radius, q / body.radius)[0])
    if body.kind == 'Convex':
        planes = _planes(body.size)
        return body.radius * float((planes[:, :3] @ (q / body.radius) + planes[:, 3]).max())
    if body.kind == 'Box':
        return _corner(np.abs(q) - 0.5 * s)
    if body.kind == 'Capsule':
        return math.hypot(q[0], q[1], max(abs(q[2]) - 0.5 * s[1], 0.0)) - float(s[0])
    if body.kind == 'Cylinder':
        return _corner(np.array([math.hypot(q[0], q[1]) - s[0], abs(q[2]) - 0.5 * s[1]]))
    if body.kind == 'Ellipsoid' and q.any():
        level = math.hypot(*(q / s))
        return float(level * (level - 1.0) / math.hypot(*(q / s / s)))
    return math.hypot(*q) - float(s.min())


def _corner(beyond: Floats) -> float:
    """Return the distance to a corner, given by how much each of its sides is exceeded."""
    outside = math.hypot(*np.maximum(beyond, 0.0))
    return outside if outside > 0.0 else float(beyond.max())


@functools.cache
def _planes(vertices: tuple[Any, ...]) -> Floats:
    """Return the planes (k, 4) of a hull brought to radius 1: outward normals and offsets."""
    points = np.array(vertices)
    equations: Floats = ConvexHull(points / np.linalg.norm(points, axis=1).max()).equations
    return equations
