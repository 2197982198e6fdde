"""The polygon of two elements: tetrahedra, triangles of rigid surfaces, half spaces."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FIRST_POINT,
    KIND,
    SURFACE,
    Between,
    Bodies,
    Floats,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.clipping import (
    CORNERS,
    HEIGHT,
    clipped,
    cut,
    without_twins,
)
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled, inlined
from drake_geom_ros.geometry._contact_surfaces.emitting import emit
from drake_geom_ros.geometry._contact_surfaces.tolerances import SAME_GRADIENT
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unrotate,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector

# A face whose normal is farther than this from where the pressure grows is left out, as in Drake.
COSINE = math.cos(5.0 * math.pi / 8.0)


@inlined
def _agrees(nhat: Vector, gradient: Vector, length: float) -> bool:
    """Tell whether a pressure grows along a normal, or not far from it."""
    return length == 0.0 or dot(nhat, gradient) > COSINE * length


@inlined
def _differ(length: float, g_length: float, h_length: float) -> bool:
    """Tell whether the difference of two gradients, of this length, is more than rounding."""
    return length > SAME_GRADIENT * (g_length + h_length)


@compiled
def _both_agree(g: Vector, g_length: float, h: Vector, h_length: float) -> bool:
    """Tell whether the normal where two pressures are equal agrees with both of them."""
    n = sub(g, h)
    length = norm(n)
    if not _differ(length, g_length, h_length):
        return False
    nhat = scale(1.0 / length, n)
    return _agrees(nhat, g, g_length) and _agrees(scale(-1.0, nhat), h, h_length)


@inlined
def _snapped(height: float, rounding: float) -> float:
    """Return a height, 0 where it is nothing but rounding."""
    return 0.0 if abs(height) <= rounding else height


@inlined
def meet(bodies: Bodies, e: int, f: int, between: Between, work: Floats, out: Surfaces) -> None:
    """Put out where element e of the first body, a tetrahedron, meets element f of the second."""
    if bodies.table[between.b, KIND] == SURFACE:
        _meet_triangle(bodies, e, f, between, work, out)
    else:
        _meet_tetrahedron(bodies, e, f, between, work, out)


@inlined
def _meet_tetrahedron(
    bodies: Bodies, e: int, f: int, between: Between, work: Floats, out: Surfaces
) -> None:
    """Put out where two tetrahedra have the same pressure.

    Both pressures are linear, so these points are on a plane: the first tetrahedron is cut by it,
    and the polygon clipped by the faces of the second, in whose frame it is looked at. Most pairs
    whose boxes meet are kept apart by a face of the first, or by that plane.
    """
    first = bodies.table[between.b, FIRST_POINT]
    c0 = _corner_of_second(bodies, between, first + bodies.elements[f, 0])
    c1 = _corner_of_second(bodies, between, first + bodies.elements[f, 1])
    c2 = _corner_of_second(bodies, between, first + bodies.elements[f, 2])
    c3 = _corner_of_second(bodies, between, first + bodies.elements[f, 3])
    if _are_beyond_a_face(bodies, e, (c0, c1, c2, c3), between.rounding):
        return
    g = vector_in(bodies.fields, e)
    h = rotate(between.R, vector_in(bodies.fields, f))
    constant = bodies.fields[e, 3] - bodies.fields[f, 3] + dot(h, between.p)
    n = sub(g, h)
    length = norm(n)
    if not _differ(length, bodies.fields[e, 4], bodies.fields[f, 4]):
        return
    # Both pressures are rounded: the plane is the less sharp, the less their gradients differ.
    rounding = between.rounding * ((bodies.fields[e, 4] + bodies.fields[f, 4]) / length)
    near = rounding * length
    if _lowest(n, (c0, c1, c2, c3)) + constant > near:
        return
    if _lowest(scale(-1.0, n), (c0, c1, c2, c3)) - constant > near:
        return
    if not cut_by(bodies, between.a, e, n, constant, length, rounding, work):
        return
    nhat = scale(1.0 / length, n)
    if not _agrees(nhat, g, bodies.fields[e, 4]):
        return
    if not _agrees(scale(-1.0, nhat), h, bodies.fields[f, 4]):
        return
    count = cut(work, nhat)
    if count == 0:
        return
    for i in range(count):
        corner = unrotate(between.R, sub(vector_in(work, i), between.p))
        for k in range(4):
            height = height_above_face(bodies, f, k, corner)
            work[i, HEIGHT + k] = _snapped(height, rounding)
    at, count, face = clipped(work, 0, count, 4, -1)
    if face >= 0:
        twin = bodies.beyond[f, face]
        if twin < 0:
            return
        its = rotate(between.R, vector_in(bodies.fields, twin))
        if twin < f and _both_agree(g, bodies.fields[e, 4], its, bodies.fields[twin, 4]):
            return
        at, count, face = clipped(work, at, count, 4, face)
    if count:
        count = without_twins(work, at, count, rounding)
    if count:
        emit(work, at, count, nhat, (g, bodies.fields[e, 3]), h, between, out)


@inlined
def _corner_of_second(bodies: Bodies, between: Between, row: int) -> Vector:
    """Return a point of the second body in the first one's frame."""
    return add(rotate(between.R, vector_in(bodies.points, row)), between.p)


@inlined
def _lowest(n: Vector, corners: tuple[Vector, Vector, Vector, Vector]) -> float:
    """Return the least of the products of a vector with four corners."""
    c0, c1, c2, c3 = corners
    lowest: float = min(min(dot(n, c0), dot(n, c1)), min(dot(n, c2), dot(n, c3)))
    return lowest


@inlined
def _are_beyond_a_face(
    bodies: Bodies, e: int, corners: tuple[Vector, Vector, Vector, Vector], near: float
) -> bool:
    """Tell whether corners are all farther than ``near`` outside one face of a tetrahedron."""
    for k in range(4):
        if _lowest(vector_at_plane(bodies, e, k), corners) > bodies.planes[e, k, 3] + near:
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
def cut_by(
    bodies: Bodies,
    a: int,
    e: int,
    n: Vector,
    constant: float,
    length: float,
    rounding: float,
    work: Floats,
) -> bool:
    """Look how high a tetrahedron's corners are above the plane n x + constant = 0.

    Return whether it is cut; then corners and heights are in ``work``. One that is not cut, but
    has a face on the plane, is as one that is cut there, if something is beyond that face.
    """
    first, near = bodies.table[a, FIRST_POINT], rounding * length
    c0, c1, c2, c3 = corners_of(bodies, first, e)
    h0, h1 = _snapped(dot(n, c0) + constant, near), _snapped(dot(n, c1) + constant, near)
    h2, h3 = _snapped(dot(n, c2) + constant, near), _snapped(dot(n, c3) + constant, near)
    above = (h0 > 0.0) + (h1 > 0.0) + (h2 > 0.0) + (h3 > 0.0)
    if above == 0 or above == 4:
        return False
    corners, heights = (c0, c1, c2, c3), (h0, h1, h2, h3)
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
    return not (zeros == 3 and bodies.beyond[e, face] < 0)


@inlined
def _meet_triangle(
    bodies: Bodies, e: int, f: int, between: Between, work: Floats, out: Surfaces
) -> None:
    """Put out which part of a rigid triangle is in a tetrahedron."""
    nhat = rotate(between.R, vector_at_plane(bodies, f, 0))
    g = vector_in(bodies.fields, e)
    if not _agrees(nhat, g, bodies.fields[e, 4]):
        return
    first = bodies.table[between.b, FIRST_POINT]
    c0 = _corner_of_second(bodies, between, first + bodies.elements[f, 0])
    c1 = _corner_of_second(bodies, between, first + bodies.elements[f, 1])
    c2 = _corner_of_second(bodies, between, first + bodies.elements[f, 2])
    own, at = corners_of(bodies, bodies.table[between.a, FIRST_POINT], e), dot(nhat, c0)
    if _lowest(nhat, own) > at + between.rounding:
        return
    if _lowest(scale(-1.0, nhat), own) > between.rounding - at:
        return
    if _are_beyond_a_face(bodies, e, (c0, c1, c2, c2), between.rounding):
        return
    corners = c0, c1, c2
    for i in range(3):
        corner = corners[i]
        work[i, 0], work[i, 1], work[i, 2] = corner
        for k in range(4):
            height = height_above_face(bodies, e, k, corner)
            work[i, HEIGHT + k] = _snapped(height, between.rounding)
    at, count, face = clipped(work, 0, 3, 4, -1)
    if face >= 0:
        twin = bodies.beyond[e, face]
        if twin < 0:
            return
        its = vector_in(bodies.fields, twin)
        if twin < e and _agrees(nhat, its, bodies.fields[twin, 4]):
            return
        at, count, face = clipped(work, at, count, 4, face)
    if count:
        count = without_twins(work, at, count, between.rounding)
    if count:
        zero = (0.0, 0.0, 0.0)
        emit(work, at, count, nhat, (g, bodies.fields[e, 3]), zero, between, out)


@inlined
def meet_half_space(
    bodies: Bodies, e: int, slope: float, between: Between, work: Floats, out: Surfaces
) -> None:
    """Put out where element e of the first body meets a half space, the second.

    One of slope 0 is rigid: the tetrahedron is cut by its plane. Else its pressure grows by the
    slope with the depth; a rigid triangle is clipped by the plane, a tetrahedron cut where the
    pressures are equal and clipped.
    """
    up = between.R[0, 2], between.R[1, 2], between.R[2, 2]
    offset = dot(up, between.p)
    h, constant, rounding = scale(-slope, up), slope * offset, between.rounding
    if bodies.table[between.a, KIND] == SURFACE:
        nhat = vector_at_plane(bodies, e, 0)
        # The rigid surface is N and the half space M, the reverse of tetrahedra on a rigid one.
        if not _agrees(nhat, h, slope):
            return
        first = bodies.table[between.a, FIRST_POINT]
        for i in range(3):
            corner = vector_in(bodies.points, first + bodies.elements[e, i])
            work[i, 0], work[i, 1], work[i, 2] = corner
        count, field, other = 3, (h, constant), (0.0, 0.0, 0.0)
    else:
        g = vector_in(bodies.fields, e)
        n, level, length = up, -offset, 1.0
        if slope > 0.0:
            n, level = sub(g, h), bodies.fields[e, 3] - constant
            length = norm(n)
            if not _differ(length, bodies.fields[e, 4], slope):
                return
            rounding *= (bodies.fields[e, 4] + slope) / length
        if not cut_by(bodies, between.a, e, n, level, length, rounding, work):
            return
        nhat = scale(1.0 / length, n)
        agree = _agrees(nhat, g, bodies.fields[e, 4]) and _agrees(scale(-1.0, nhat), h, slope)
        if slope > 0.0 and not agree:
            return
        count, field, other = cut(work, nhat), (g, bodies.fields[e, 3]), h
    at = 0
    if slope > 0.0 and count:
        for i in range(count):
            height = dot(up, vector_in(work, i)) - offset
            work[i, HEIGHT] = _snapped(height, rounding)
        at, count, face = clipped(work, 0, count, 1, -1)
        if face >= 0:
            return
    if count:
        count = without_twins(work, at, count, rounding)
    if count:
        emit(work, at, count, nhat, field, other, between, out)
