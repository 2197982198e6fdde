"""What bodies are: how far they reach along a direction, and how far a point is from a surface.

Plain formulas to judge answers by, ours too; nothing of the engine takes part.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from drake_geom_ros.evidence.bodies.bodies import Body, Floats, Form
from drake_geom_ros.evidence.tolerances import ALIGNED, EPS
from drake_geom_ros.evidence.truth.meshes import point_distance
from drake_geom_ros.evidence.truth.supports import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    SPHERE,
)


def support_value_of(form: Form, d: Floats) -> Any:
    """Return the support values (...) [m] of a shape along unit d (..., 3) in its frame."""
    kind, s = form
    x, y, z = np.moveaxis(d, -1, 0)
    if kind == SPHERE:
        return s[0] + 0.0 * z
    if kind == BOX:
        return np.abs(d) @ s
    if kind == CAPSULE:
        return s[0] + s[1] * np.abs(z)
    if kind == CYLINDER:
        return s[0] * np.hypot(x, y) + s[1] * np.abs(z)
    if kind == ELLIPSOID:
        return np.hypot.reduce(s * d, axis=-1)
    if kind == CONVEX:
        return (d @ s[1:].reshape(3, -1)).max(axis=-1)
    return np.where(np.hypot.reduce(d - [0.0, 0.0, 1.0], axis=-1) <= ALIGNED, 0.0, math.inf)


def support_value(body: Body, n: Floats) -> float:
    """Return the support value [m] of a body along a unit vector, from its origin."""
    return float(support_value_of(body.form, body.R.T @ n))


def width(a: Body, b: Body, nhat_BA_W: Floats) -> float:
    """Return the gap [m] between the supporting planes along a normal: at most the distance.

    Of a Solid they are those of its hull.
    """
    return (
        float((a.p - b.p) @ nhat_BA_W) - support_value(a, -nhat_BA_W) - support_value(b, nhat_BA_W)
    )


def height_of(form: Form, q: Floats) -> float:
    """Return how far [m] a point q near a shape's surface is outside, negative inside."""
    kind, s = form
    if kind == SPHERE:
        return math.hypot(*q) - float(s[0])
    if kind == BOX:
        return _corner(np.abs(q) - s)
    if kind == CAPSULE:
        return math.hypot(q[0], q[1], max(abs(q[2]) - s[1], 0.0)) - float(s[0])
    if kind == CYLINDER:
        return _corner(np.array([math.hypot(q[0], q[1]) - s[0], abs(q[2]) - s[1]]))
    if kind == ELLIPSOID:
        if not q.any():
            return -float(s.min())
        level = math.hypot(*(q / s))
        return float(level * (level - 1.0) / math.hypot(*(q / s / s)))
    if kind == CONVEX:
        planes = _planes(s[1:].tobytes())
        return float((planes[:, :3] @ q + planes[:, 3]).max())
    return float(q[2])


def height(body: Body, p_W: Floats) -> float:
    """Return how far [m] a point near a body's surface is outside, negative inside."""
    q, s = p_W - body.p, body.radius
    if body.kind == 'HalfSpace':
        return float(q @ body.R[:, 2])
    if s <= EPS * np.abs(body.p).max():  # a point, as far as the digits of its position go
        return math.hypot(*q)
    q = body.R.T @ (q / s)  # at 1 m nothing overflows
    if body.kind == 'Solid':
        return s * float(point_distance(body.corners / s, q)[0])
    kind, size = body.form
    if kind == CONVEX:
        return s * height_of((kind, np.append(size[0], size[1:] / s)), q)
    return s * height_of((kind, size / s), q)


def _corner(beyond: Floats) -> float:
    """Return the distance to a corner, given by how much each of its sides is exceeded."""
    outside = math.hypot(*np.maximum(beyond, 0.0))
    return outside if outside > 0.0 else float(beyond.max())


@functools.lru_cache(maxsize=64)
def _planes(vertices: bytes) -> Floats:
    """Return the planes (k, 4) of a hull: outward normals and offsets."""
    equations: Floats = ConvexHull(np.frombuffer(vertices).reshape(3, -1).T).equations
    return equations
