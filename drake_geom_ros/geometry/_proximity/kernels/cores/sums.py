"""Minkowski difference of two cores, or of edges of hulls, as a sum with derivatives.

Such a core is a sum of segments (three for a box, the axis of a capsule or cylinder) and at most
one ellipsoid (a cylinder's disk is a flat one), minus a ball (see ``supports``). So is the
difference D = A - B: its support function is

    h(n) = sum |s . n| + |E_A n| + |E_B n| - r - p . n

It is smooth, with known curvature, except where n is normal to a segment or along the axis of a
disk. The rows of E are the semi-axes. The least h is minus the signed distance of the cores.

A hull is not such a sum, but one of its edges is, with an offset from the hull's origin. The
difference with the edge lies in that with the hull, so its h is nowhere more. Where both are
equal, a minimum for the edge is a minimum for the hull.

``terms`` has a row for p, four for segments, three for the semi-axes of A and of B, one for the
point of A's and of B's disk if n is along its axis, and one for the midpoint of A's edge, from Ao;
p is then from there to B, or to the midpoint of B's edge. Column LENGTH is that of the row. Column
SHARE of a segment is the position of its support point: -1 or 1 at an end, or in between where n
is normal to the segment and h has a kink; the segment is then *held*.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import clamp
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Difference
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import farthest_edge
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import core_radius
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
    unrotate,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_LENGTH,
    SHAPE_RADIUS,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import LEAST_LENGTH, RIGHT_ANGLE

SEGMENT = 1
MOST_SEGMENTS = 4
AXES_A = 5
AXES_B = 8
LEAN_A = 11
LEAN_B = 12
ORIGIN = 13
ROWS = 14
SHARE = 3
LENGTH = 4


class Curvature(NamedTuple):
    """Derivatives of a support function at n: value, slopes along e, f, curvature ee, ef, ff."""

    y: float
    along_e: float
    along_f: float
    ee: float
    ef: float
    ff: float


@inlined
def _put(terms: Floats, k: int, s: float, R: Floats, axis: int) -> None:
    """Store s times an axis of R in row k, with its length, at least LEAST_LENGTH."""
    s = max(s, LEAST_LENGTH)
    for i in range(3):
        terms[k, i] = s * R[i, axis]
    terms[k, LENGTH] = s


@compiled
def _put_shape(terms: Floats, kind: int, shape: Floats, R: Floats, segment: int, axes: int) -> int:
    """Store the terms of one core; return the row of the next segment."""
    if kind == BOX:
        for k in range(3):
            _put(terms, segment + k, shape[k], R, k)
        return segment + 3
    if kind == ELLIPSOID:
        for k in range(3):
            _put(terms, axes + k, shape[k], R, k)
        return segment
    if kind == CYLINDER:
        _put(terms, axes, shape[SHAPE_RADIUS], R, 0)
        _put(terms, axes + 1, shape[SHAPE_RADIUS], R, 1)
    if kind == CAPSULE or kind == CYLINDER:
        _put(terms, segment, shape[HALF_LENGTH], R, 2)
        return segment + 1
    return segment


@allocating
def difference_of(pair: CorePair) -> Difference:
    """Return the Minkowski difference of the two cores of a pair."""
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
    if kind_A == CONVEX or kind_B == CONVEX:
        # Terms are not read here, and an array would take a tenth of the time of two hulls.
        return Difference(R_WA, 0, 0, 0.0, 0.0)
    terms = np.zeros((ROWS, 5))
    for i in range(3):
        terms[0, i] = p[i]
    first = _put_shape(terms, kind_A, shape_A, R_WA, SEGMENT, AXES_A)
    last = _put_shape(terms, kind_B, shape_B, R_WB, first, AXES_B)
    return Difference(
        terms,
        first,
        last,
        _subtracted_radius(kind_A, shape_A),
        _subtracted_radius(kind_B, shape_B),
    )


@inlined
def _subtracted_radius(kind: int, shape: Floats) -> float:
    """Return the radius [m] of the ball that the core of a shape subtracts from its terms."""
    return core_radius(kind, shape) if kind == ELLIPSOID else 0.0


@compiled
def _put_edge(terms: Floats, shape: Floats, R: Floats, n: Vector, segment: int) -> Vector:
    """Store the edge of a hull next to the unit n; return its midpoint, from Go in World axes."""
    x, y, z = unrotate(R, n)
    u, v = farthest_edge(shape, x, y, z)
    half = rotate(R, scale(0.5, sub(v, u)))
    for i in range(3):
        terms[segment, i] = half[i]
    terms[segment, LENGTH] = max(norm(half), LEAST_LENGTH)
    return rotate(R, scale(0.5, add(u, v)))


@allocating
def difference_of_edges(pair: CorePair, n: Vector) -> Difference:
    """Return ``difference_of`` a pair in which hulls are replaced by their edges next to n."""
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
    terms = np.zeros((ROWS, 5))
    first = _put_shape(terms, kind_A, shape_A, R_WA, SEGMENT, AXES_A)
    if kind_A == CONVEX:
        middle = _put_edge(terms, shape_A, R_WA, n, SEGMENT)
        first, p = SEGMENT + 1, sub(p, middle)
        for i in range(3):
            terms[ORIGIN, i] = middle[i]
    last = _put_shape(terms, kind_B, shape_B, R_WB, first, AXES_B)
    if kind_B == CONVEX:
        p = add(p, _put_edge(terms, shape_B, R_WB, scale(-1.0, n), first))
        last = first + 1
    for i in range(3):
        terms[0, i] = p[i]
    return Difference(
        terms,
        first,
        last,
        _subtracted_radius(kind_A, shape_A),
        _subtracted_radius(kind_B, shape_B),
    )


@inlined
def _stretch(terms: Floats, axes: int, n: Vector) -> float:
    """Return |E n| of the ellipsoid with semi-axes from row ``axes``."""
    if terms[axes, LENGTH] == 0.0:  # no ellipsoid, as in most cores
        return 0.0
    x, y, z = (
        dot(vector_in(terms, axes), n),
        dot(vector_in(terms, axes + 1), n),
        dot(vector_in(terms, axes + 2), n),
    )
    return math.sqrt(x * x + y * y + z * z)


@inlined
def width(terms: Floats, last: int, radius: float, n: Vector) -> float:
    """Return h(n) [m] for the unit n."""
    h = -radius - dot(vector_in(terms, 0), n)
    for k in range(SEGMENT, last):
        h += abs(dot(vector_in(terms, k), n))
    return h + _stretch(terms, AXES_A, n) + _stretch(terms, AXES_B, n)


@compiled
def likely_normal(difference: Difference, n: Vector) -> Vector:
    """Return n, or the best separating face normal, crossed edges or axis of the two cores."""
    terms, _, last, r_A, r_B = difference
    radius = r_A + r_B
    least = width(terms, last, radius, n)
    for i in range(SEGMENT, last):
        for j in range(i + 1, last):
            m = unit(cross(vector_in(terms, i), vector_in(terms, j)))
            n, least = _better(terms, last, radius, m, n, least)
    for axes in (AXES_A, AXES_B):
        m = unit(cross(vector_in(terms, axes), vector_in(terms, axes + 1)))
        n, least = _better(terms, last, radius, m, n, least)
        if terms[axes + 2, LENGTH] > 0.0:
            for k in range(2):
                m = scale(1.0 / terms[axes + k, LENGTH], vector_in(terms, axes + k))
                n, least = _better(terms, last, radius, m, n, least)
    return n


@inlined
def _better(
    terms: Floats, last: int, radius: float, m: Vector, n: Vector, least: float
) -> tuple[Vector, float]:
    """Return (m, h(m)), or (-m, h(-m)), if that is less than (n, least), else (n, least)."""
    if dot(m, m) == 0.0:
        return n, least
    if dot(m, vector_in(terms, 0)) < 0.0:
        m = scale(-1.0, m)
    h = width(terms, last, radius, m)
    return (m, h) if h < least else (n, least)


@compiled
def curvature(terms: Floats, axes: int, n: Vector, e: Vector, f: Vector) -> Curvature:
    """Return the slopes and the curvature at n of the support function ``y = |E n|``.

    n, e and f are orthonormal. The radii of curvature are
    ``(|E e x E n|^2, (E e x E n) . (E f x E n), |E f x E n|^2) / y^3`` [m]. At the axis of a disk,
    where y has no derivative, all are 0.
    """
    if terms[axes, LENGTH] == 0.0:
        return Curvature(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    a, b, c = vector_in(terms, axes), vector_in(terms, axes + 1), vector_in(terms, axes + 2)
    u = (dot(a, n), dot(b, n), dot(c, n))
    y = math.sqrt(dot(u, u))
    if y <= RIGHT_ANGLE * terms[axes, LENGTH]:
        return Curvature(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    v = (dot(a, e), dot(b, e), dot(c, e))
    w = (dot(a, f), dot(b, f), dot(c, f))
    v_, w_ = cross(v, u), cross(w, u)
    s = 1.0 / (y * y * y)
    return Curvature(
        y,
        dot(u, v) / y,
        dot(u, w) / y,
        s * dot(v_, v_),
        s * dot(v_, w_),
        s * dot(w_, w_),
    )


@inlined
def ellipsoid_support(terms: Floats, axes: int, n: Vector) -> Vector:
    """Return the point of the ellipsoid extreme along n; the centre of a disk along its axis."""
    if terms[axes, LENGTH] == 0.0:
        return 0.0, 0.0, 0.0
    a, b, c = vector_in(terms, axes), vector_in(terms, axes + 1), vector_in(terms, axes + 2)
    u = (dot(a, n), dot(b, n), dot(c, n))
    y = math.sqrt(dot(u, u))
    if y <= RIGHT_ANGLE * terms[axes, LENGTH]:
        return 0.0, 0.0, 0.0
    return add_scaled(add_scaled(scale(u[0] / y, a), u[1] / y, b), u[2] / y, c)


@inlined
def ends_at(terms: Floats, last: int, n: Vector) -> Vector:
    """Return the sum of -p and the segments' ends extreme along n."""
    base = scale(-1.0, vector_in(terms, 0))
    for k in range(SEGMENT, last):
        s = vector_in(terms, k)
        base = add_scaled(base, 1.0 if dot(s, n) >= 0.0 else -1.0, s)
    return base


@compiled
def witness_points(difference: Difference, n: Vector) -> tuple[Vector, Vector]:
    """Return the points (a, b) of the cores, from Ao, extreme along n and -n, from the shares."""
    terms, first, last, r_A, r_B = difference
    a = add_scaled(add(ellipsoid_support(terms, AXES_A, n), vector_in(terms, LEAN_A)), -r_A, n)
    a = add(a, vector_in(terms, ORIGIN))
    b = add_scaled(add(ellipsoid_support(terms, AXES_B, n), vector_in(terms, LEAN_B)), -r_B, n)
    for k in range(SEGMENT, first):
        a = add_scaled(a, terms[k, SHARE], vector_in(terms, k))
    for k in range(first, last):
        b = add_scaled(b, terms[k, SHARE], vector_in(terms, k))
    return a, sub(add(vector_in(terms, ORIGIN), vector_in(terms, 0)), b)


@compiled
def is_point_of(kind: int, shape: Floats, q: Vector) -> bool:
    """Return whether q, in the shape's frame, is a point of the core of a box or cylinder."""
    if kind == BOX:
        return abs(q[0]) <= shape[0] and abs(q[1]) <= shape[1] and abs(q[2]) <= shape[2]
    if kind == CYLINDER:
        radius, half_length = shape[SHAPE_RADIUS], shape[HALF_LENGTH]
        return q[0] * q[0] + q[1] * q[1] <= radius * radius and abs(q[2]) <= half_length
    return False


@compiled
def nearest_to(kind: int, shape: Floats, q: Vector) -> Vector:
    """Return the point of a box, or of the axis of a cylinder or capsule, nearest to q, in G."""
    if kind == BOX:
        return clamp(q[0], shape[0]), clamp(q[1], shape[1]), clamp(q[2], shape[2])
    return 0.0, 0.0, clamp(q[2], shape[HALF_LENGTH])


@compiled
def share_a_point(pair: CorePair, a: Vector, b: Vector) -> bool:
    """Return whether a box or capsule A and a cylinder B are found to have a common point.

    ``a`` is a point of A and ``b`` one of B, from Ao. The test tries these, the point of each core
    nearest to the other's origin, and the midpoints between both, because a and b may be on the
    surface, where rounding decides.
    """
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
    a, b = unrotate(R_WA, a), unrotate(R_WB, sub(b, p))
    near_A = nearest_to(kind_A, shape_A, unrotate(R_WA, p))
    near_B = nearest_to(kind_B, shape_B, unrotate(R_WB, scale(-1.0, p)))
    for share in (0.0, 0.5, 1.0):
        x = rotate(R_WA, add_scaled(a, share, sub(near_A, a)))
        y = add(p, rotate(R_WB, add_scaled(b, share, sub(near_B, b))))
        if is_point_of(kind_B, shape_B, unrotate(R_WB, sub(x, p))):
            return True
        if is_point_of(kind_A, shape_A, unrotate(R_WA, y)):
            return True
        z = scale(0.5, add(x, y))
        if is_point_of(kind_A, shape_A, unrotate(R_WA, z)) and is_point_of(
            kind_B, shape_B, unrotate(R_WB, sub(z, p))
        ):
            return True
    return False
