"""The polygon of two tetrahedra."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FIRST_POINT,
    Between,
    Bodies,
    Field,
    Floats,
    Scratch,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.clipping import (
    CORNERS,
    HEIGHT,
    clipped,
    cut,
    without_twins,
)
from drake_geom_ros.geometry._contact_surfaces.compiled import inlined
from drake_geom_ros.geometry._contact_surfaces.emitting import emit
from drake_geom_ros.geometry._contact_surfaces.posed import (
    FIELD,
    LENGTH,
    corner_of,
    is_beyond,
    lowest,
)
from drake_geom_ros.geometry._contact_surfaces.tolerances import SAME_COSINE, SAME_GRADIENT
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    dot,
    norm,
    scale,
    sub,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector

# A face whose normal is farther than this from where the pressure grows is left out, as in Drake.
COSINE = math.cos(5.0 * math.pi / 8.0)


@inlined
def agrees(nhat: Vector, gradient: Vector, length: float) -> bool:
    """Return whether a pressure grows along a normal, or not far from it."""
    return length == 0.0 or dot(nhat, gradient) > (COSINE + SAME_COSINE) * length


@inlined
def differ(length: float, g_length: float, h_length: float) -> bool:
    """Return whether the difference of two gradients, of this length, is more than rounding."""
    return length > SAME_GRADIENT * (g_length + h_length)


@inlined
def snapped(height: float, rounding: float) -> float:
    """Return a height, 0 where it is nothing but rounding."""
    return 0.0 if abs(height) <= rounding else height


@inlined
def difference(one: float, other: float, near: float, near_other: float) -> float:
    """Return the difference of two pressures [Pa], 0 where that is nothing but rounding.

    A pressure that is nothing but rounding is none, as where a body ends, and then the other one
    decides: where a body ends that is 1e12 times as hard as the other they are equal so little
    within it that no position separates it from its face.
    """
    one, other = snapped(one, near), snapped(other, near_other)
    if one == 0.0 or other == 0.0:
        return one - other
    return snapped(one - other, near + near_other)


@inlined
def differences(
    corners: tuple[Vector, Vector, Vector, Vector], field: Field, other: Field, rounding: float
) -> tuple[float, float, float, float]:
    """Return ``difference`` at the corners of a tetrahedron; ``rounding`` [m] of positions."""
    c0, c1, c2, c3 = corners
    near, near_other = rounding * field.length, rounding * other.length
    return (
        difference(pressure_at(field, c0), pressure_at(other, c0), near, near_other),
        difference(pressure_at(field, c1), pressure_at(other, c1), near, near_other),
        difference(pressure_at(field, c2), pressure_at(other, c2), near, near_other),
        difference(pressure_at(field, c3), pressure_at(other, c3), near, near_other),
    )


@inlined
def pressure_at(field: Field, point: Vector) -> float:
    """Return a pressure [Pa], as if it went on where the body ends."""
    pressure: float = dot(field.gradient, point) + field.level
    return pressure


@inlined
def is_pressed(work: Floats, first: int, count: int, field: Field, rounding: float) -> bool:
    """Return whether there is a pressure, more than rounding, anywhere at a polygon's corners."""
    pressed = False
    for i in range(first, first + count):
        pressed |= pressure_at(field, vector_in(work, i)) > rounding * field.length
    return pressed


@inlined
def meet(
    bodies: Bodies, e: int, f: int, between: Between, scratch: Scratch, out: Surfaces
) -> None:
    """Put out where element e of the first body, a tetrahedron, meets the one that is posed.

    Both pressures are linear, so these points are on a plane: the second tetrahedron is cut by it,
    and the polygon clipped by the faces of the first. Most pairs whose boxes meet are kept apart
    by a face of one, or by that plane.

    Where that plane is a face, and where pressures are equal all over an element, it is as if the
    first pressure were lower by next to nothing: so such a surface is what it is close by. (The
    perturbation of Edelsbrunner and Muecke, Simulation of simplicity, ACM TOG 9, 1990, in one
    number.)
    """
    work, other = scratch.work, scratch.other
    corners = corner_of(other, 0), corner_of(other, 1), corner_of(other, 2), corner_of(other, 3)
    if _are_beyond_a_face(bodies, e, corners, between.rounding):
        return
    g, h = vector_in(bodies.fields, e), vector_in(other, FIELD)
    field = Field(g, bodies.fields[e, 3], bodies.fields[e, 4])
    others = Field(h, other[FIELD, 3], other[LENGTH, 0])
    constant, lengths = field.level - others.level, field.length + others.length
    near = between.rounding * lengths
    n = sub(g, h)
    if lowest(n, corners) + constant > near or lowest(scale(-1.0, n), corners) - constant > near:
        return
    own = corners_of(bodies, bodies.table[between.a, FIRST_POINT], e)
    if lowest(n, own) + constant > near or lowest(scale(-1.0, n), own) - constant > near:
        return
    if is_beyond(other, own, between.rounding):
        return
    length = norm(n)
    if not differ(length, field.length, others.length):
        return
    # Both pressures are rounded: the plane is the less sharp, the less their gradients differ.
    rounding = between.rounding * (lengths / length)
    heights = differences(corners, field, others, between.rounding)
    if not is_cut(bodies, f, corners, heights, work):
        return
    nhat = scale(1.0 / length, n)
    agree = agrees(nhat, g, field.length) and agrees(scale(-1.0, nhat), h, others.length)
    if not (agree or between.anyway):
        return
    count = cut(work, nhat)
    if count == 0:
        return
    put_heights(bodies, e, count, rounding, work)
    first, count, face = clipped(work, 0, count, 4, -1)
    if face >= 0:
        if bodies.beyond[e, face] < 0:
            # As near to where the first body ends both end, or the other one presses there.
            if not is_pressed(work, first, count, others, between.rounding):
                return
        # As in ``is_cut``: of two tetrahedra that share it the one above the plane has it.
        elif not dot(n, own[face]) + constant > near:
            return
        first, count, face = clipped(work, first, count, 4, face)
    if count:
        count = without_twins(work, first, count, rounding)
    if count:
        emit(work, first, count, nhat, softer(field, others), (g, h), between, out)


@inlined
def put_heights(bodies: Bodies, e: int, count: int, rounding: float, work: Floats) -> None:
    """Put the heights of corners above the faces of a tetrahedron beside them."""
    for i in range(count):
        corner = vector_in(work, i)
        for k in range(4):
            height = height_above_face(bodies, e, k, corner)
            work[i, HEIGHT + k] = snapped(height, rounding)


@inlined
def _are_beyond_a_face(
    bodies: Bodies, e: int, corners: tuple[Vector, Vector, Vector, Vector], near: float
) -> bool:
    """Return whether corners are all farther than ``near`` outside one face of a tetrahedron."""
    for k in range(4):
        if lowest(vector_at_plane(bodies, e, k), corners) > bodies.planes[e, k, 3] + near:
            return True
    return False


@inlined
def corners_of(bodies: Bodies, first: int, e: int) -> tuple[Vector, Vector, Vector, Vector]:
    """Return the corners of a tetrahedron of a body whose points begin at ``first``."""
    return (
        vector_in(bodies.points, first + bodies.elements[e, 0]),
        vector_in(bodies.points, first + bodies.elements[e, 1]),
        vector_in(bodies.points, first + bodies.elements[e, 2]),
        vector_in(bodies.points, first + bodies.elements[e, 3]),
    )


@inlined
def vector_at_plane(bodies: Bodies, f: int, k: int) -> Vector:
    """Return the outward normal of a tetrahedron's face."""
    return bodies.planes[f, k, 0], bodies.planes[f, k, 1], bodies.planes[f, k, 2]


@inlined
def height_above_face(bodies: Bodies, f: int, k: int, point: Vector) -> float:
    """Return how high [m] a point in the body's frame is above a tetrahedron's face."""
    height: float = dot(vector_at_plane(bodies, f, k), point) - bodies.planes[f, k, 3]
    return height


@inlined
def softer(field: Field, other: Field) -> Field:
    """Return the one of two pressures that grows less: where they are equal it is less rounded."""
    return field if field.length <= other.length else other


@inlined
def is_cut(
    bodies: Bodies,
    e: int,
    corners: tuple[Vector, Vector, Vector, Vector],
    heights: tuple[float, float, float, float],
    work: Floats,
) -> bool:
    """Return whether tetrahedron e is cut by the plane that its corners are so high above.

    Then they and their heights, which may be differences of pressures, are in ``work``. One that
    is above the plane, and has a face on it, is cut there, if something is beyond that face.
    """
    h0, h1, h2, h3 = heights
    above = (h0 > 0.0) + (h1 > 0.0) + (h2 > 0.0) + (h3 > 0.0)
    if above == 0 or above == 4:
        return False
    zeros = face = 0
    for k in range(4):
        row = CORNERS + k
        work[row, 0], work[row, 1], work[row, 2] = corners[k]
        work[row, HEIGHT] = heights[k]
        work[row, HEIGHT + 1] = work[row, HEIGHT + 2] = work[row, HEIGHT + 3] = 0.0
        if heights[k] == 0.0:
            zeros += 1
        else:
            face = k
    return zeros < 3 or bodies.beyond[e, face] >= 0
