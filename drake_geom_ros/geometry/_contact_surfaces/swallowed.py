"""Bodies that overlap though their pressures are equal nowhere: one is deep within the other."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    ELEMENTS,
    FIRST_ELEMENT,
    FIRST_POINT,
    HALF_SPACE,
    KIND,
    LEAVES,
    SURFACE,
    Between,
    Bodies,
    Indices,
    Scratch,
    first_in_leaf,
)
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled
from drake_geom_ros.geometry._contact_surfaces.elements import height_above_face
from drake_geom_ros.geometry._contact_surfaces.tolerances import WITHIN
from drake_geom_ros.geometry._contact_surfaces.walks import box_of
from drake_geom_ros.geometry._proximity.kernels.solids.solid import solid_angle
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    rotate,
    sub,
    unrotate,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector


@compiled
def one_is_swallowed(bodies: Bodies, between: Between, scratch: Scratch) -> bool:
    """Return whether a point inside one of two bodies without a surface is in the other.

    The points are the innermost of compliant bodies, and a corner of rigid ones. For the reason
    see ``pairs``.
    """
    a, b = between.a, between.b
    near = WITHIN * between.rounding
    of_a = unrotate(between.R, sub(vector_in(bodies.inner, a), between.p))
    if _is_in(bodies, b, of_a, near, scratch.stack):
        return True
    if bodies.table[b, KIND] == HALF_SPACE:
        return False
    of_b = add(rotate(between.R, vector_in(bodies.inner, b)), between.p)
    return _is_in(bodies, a, of_b, near, scratch.stack)


@compiled
def _is_in(bodies: Bodies, body: int, point: Vector, near: float, stack: Indices) -> bool:
    """Return whether a point in a body's frame is in it, and deeper than ``near``."""
    if bodies.table[body, KIND] == HALF_SPACE:
        return point[2] < -near
    if bodies.table[body, KIND] == SURFACE:
        return _is_wound_around(bodies, body, point)
    last = bodies.table[body, LEAVES] - 1
    stack[0], top = 0, 1
    while top > 0:
        top -= 1
        k = stack[top]
        middle, half = box_of(bodies, body, k)
        d = sub(point, middle)
        if abs(d[0]) > half[0] or abs(d[1]) > half[1] or abs(d[2]) > half[2]:
            continue
        if k < last:
            stack[top], stack[top + 1] = 2 * k + 1, 2 * k + 2
            top += 2
            continue
        for e in range(
            first_in_leaf(bodies, body, k - last), first_in_leaf(bodies, body, k - last + 1)
        ):
            # Between elements that share a face it is in both, or in one.
            outside = False
            for face in range(4):
                outside |= height_above_face(bodies, e, face, point) > near
            pressure = dot(vector_in(bodies.fields, e), point) + bodies.fields[e, 3]
            if not outside and pressure > 2.0 * near * bodies.fields[e, 4]:
                return True
    return False


@compiled
def _is_wound_around(bodies: Bodies, body: int, point: Vector) -> bool:
    """Return whether a rigid surface goes around a point; one that is open does not."""
    first, corner = bodies.table[body, FIRST_ELEMENT], bodies.table[body, FIRST_POINT]
    halves = 0.0
    for e in range(first, first + bodies.table[body, ELEMENTS]):
        a = sub(vector_in(bodies.points, corner + bodies.elements[e, 0]), point)
        b = sub(vector_in(bodies.points, corner + bodies.elements[e, 1]), point)
        c = sub(vector_in(bodies.points, corner + bodies.elements[e, 2]), point)
        halves += solid_angle(a, b, c)
    return halves > math.pi
