"""The polygon of two tetrahedra."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FIRST_POINT,
    Between,
    Bodies,
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
    """Tell whether a pressure grows along a normal, or not far from it."""
    return length == 0.0 or dot(nhat, gradient) > (COSINE + SAME_COSINE) * length


@inlined
def differ(length: float, g_length: float, h_length: float) -> bool:
    """Tell whether the difference of two gradients, of this length, is more than rounding."""
    return length > SAME_GRADIENT * (g_length + h_length)


@inlined
def snapped(height: float, rounding: float) -> float:
    """Return a height, 0 where it is nothing but rounding."""
    return 0.0 if abs(height) <= rounding else height


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
    constant = bodies.fields[e, 3] - other[FIELD, 3]
    lengths = bodies.fields[e, 4] + other[LENGTH, 0]
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
    if not differ(length, bodies.fields[e, 4], other[LENGTH, 0]):
        return
    # Both pressures are rounded: the plane is the less sharp, the less their gradients differ.
    rounding = between.rounding * (lengths / length)
    if not is_cut_by(bodies, f, corners, (n, constant, length), rounding, work):
        return
    nhat = scale(1.0 / length, n)
    agree = agrees(nhat, g, bodies.fields[e, 4]) and agrees(scale(-1.0, nhat), h, other[LENGTH, 0])
    if not (agree or between.anyway):
        return
    count = cut(work, nhat)
    if count == 0:
        return
    put_heights(bodies, e, count, rounding, work)
    at, count, face = clipped(work, 0, count, 4, -1)
    if face >= 0:
        # As in ``is_cut_by``: of two tetrahedra that share it the one above the plane has it.
        if bodies.beyond[e, face] < 0 or not dot(n, own[face]) + constant > near:
            return
        at, count, face = clipped(work, at, count, 4, face)
    if count:
        count = without_twins(work, at, count, rounding)
    if count:
        emit(work, at, count, nhat, (g, bodies.fields[e, 3]), h, between, out)


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
    """Tell whether corners are all farther than ``near`` outside one face of a tetrahedron."""
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
def is_cut_by(
    bodies: Bodies,
    e: int,
    corners: tuple[Vector, Vector, Vector, Vector],
    plane: tuple[Vector, float, float],
    rounding: float,
    work: Floats,
) -> bool:
    """Tell whether tetrahedron e is cut by the plane n x + constant = 0.

    The plane is n, the constant, and the length of n. Then its corners and their heights above the
    plane are in ``work``. One that is above the plane, and has a face on it, is cut there, if
    something is beyond that face.
    """
    n, constant, length = plane
    near = rounding * length
    c0, c1, c2, c3 = corners
    h0, h1 = snapped(dot(n, c0) + constant, near), snapped(dot(n, c1) + constant, near)
    h2, h3 = snapped(dot(n, c2) + constant, near), snapped(dot(n, c3) + constant, near)
    above = (h0 > 0.0) + (h1 > 0.0) + (h2 > 0.0) + (h3 > 0.0)
    if above == 0 or above == 4:
        return False
    heights = h0, h1, h2, h3
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
