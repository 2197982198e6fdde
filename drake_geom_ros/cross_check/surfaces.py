"""Support values of bodies, and signed distances of points to their surfaces.

These plain formulas judge answers of this package and of others, without code of the engine.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from drake_geom_ros.cross_check.bodies import Body, Form, Pair
from drake_geom_ros.cross_check.tolerances import ALIGNED
from drake_geom_ros.geometry import ShapeKind
from drake_geom_ros.math.array_types import Floats

SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID, HALF_SPACE, CONVEX, *_ = ShapeKind
_EPS = float(np.finfo(np.float64).eps)


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
    """Return the gap [m] between the supporting planes along a normal, a lower bound of distance.

    The planes of a Solid are those of its hull.
    """
    return (
        float((a.p - b.p) @ nhat_BA_W) - support_value(a, -nhat_BA_W) - support_value(b, nhat_BA_W)
    )


def height_of(form: Form, q: Floats) -> float:
    """Return the signed distance [m] of a point q near a shape's surface, negative inside."""
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
    """Return the signed distance [m] of a point near a body's surface, negative inside."""
    q, s = p_W - body.p, body.radius
    if body.kind == 'HalfSpace':
        return float(q @ body.R[:, 2])
    if s <= _EPS * np.abs(body.p).max():  # a point, within the rounding of its position
        return math.hypot(*q)
    q = body.R.T @ (q / s)  # scaled to 1 m, where nothing overflows
    if body.kind == 'Solid':
        return s * _surface_distance(body.corners / s, q)
    kind, size = body.form
    if kind == CONVEX:
        return s * height_of((kind, np.append(size[0], size[1:] / s)), q)
    return s * height_of((kind, size / s), q)


def off_surfaces(pair: Pair, p_WCa: Floats, p_WCb: Floats) -> float:
    """Return the greater distance [m] of two witness points to their surfaces."""
    return max(abs(height(pair.a, p_WCa)), abs(height(pair.b, p_WCb)))


def nearest_points(corners: Floats, q: Floats) -> Floats:
    """Return the nearest point (n, 3) to q on each triangle, in its face or on a side."""
    a, b, c = corners.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    above = ((q - a) * normals).sum(axis=1) / (normals * normals).sum(axis=1)
    foot = q - above[:, None] * normals
    nearest: Floats = foot
    best = np.full(len(corners), np.inf)
    beyond = np.zeros(len(corners), dtype=np.bool_)
    on_sides = foot.copy()
    for start, end in ((a, b), (b, c), (c, a)):
        along = end - start
        beyond |= (np.cross(along, foot - start) * normals).sum(axis=1) < 0.0
        at = ((q - start) * along).sum(axis=1) / (along * along).sum(axis=1)
        on_side = start + np.clip(at, 0.0, 1.0)[:, None] * along
        distance = np.linalg.norm(on_side - q, axis=1)
        nearer = distance < best
        best[nearer], on_sides[nearer] = distance[nearer], on_side[nearer]
    nearest[beyond] = on_sides[beyond]
    return nearest


def winding(corners: Floats, q: Floats) -> float:
    """Return the winding number of a surface around q: 1 inside, 0 outside."""
    v = corners - q
    lengths = np.linalg.norm(v, axis=2)
    a, b, c = v.transpose(1, 0, 2)
    la, lb, lc = lengths.T
    volume = (a * np.cross(b, c)).sum(axis=1)
    dots = [(x * y).sum(axis=1) for x, y in ((a, b), (b, c), (c, a))]
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return float(np.arctan2(volume, below).sum()) / (2.0 * np.pi)


def _surface_distance(corners: Floats, q: Floats) -> float:
    """Return the signed distance [m] of a point from a closed surface of triangles (n, 3, 3)."""
    distance = float(np.linalg.norm(nearest_points(corners, q) - q, axis=1).min())
    return -distance if winding(corners, q) > 0.5 else distance


def _corner(beyond: Floats) -> float:
    """Return the distance to a corner, from the excess beyond each of its sides."""
    outside = math.hypot(*np.maximum(beyond, 0.0))
    return outside if outside > 0.0 else float(beyond.max())


@functools.lru_cache(maxsize=64)
def _planes(vertices: bytes) -> Floats:
    """Return the planes (k, 4) of a hull: outward normals and offsets."""
    equations: Floats = ConvexHull(np.frombuffer(vertices).reshape(3, -1).T).equations
    return equations
