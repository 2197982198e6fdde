"""The polygon of an element and a half space."""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FIRST_POINT,
    KIND,
    SURFACE,
    Between,
    Bodies,
    Field,
    Floats,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.clipping import HEIGHT, clipped, cut, without_twins
from drake_geom_ros.geometry._contact_surfaces.compiled import inlined
from drake_geom_ros.geometry._contact_surfaces.elements import (
    agrees,
    corners_of,
    differ,
    differences,
    is_cut,
    is_pressed,
    snapped,
    softer,
    vector_at_plane,
)
from drake_geom_ros.geometry._contact_surfaces.emitting import emit
from drake_geom_ros.geometry._proximity.kernels.vectors import dot, norm, scale, sub, vector_in
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector


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
    offset, rounding, nowhere = dot(up, between.p), between.rounding, (0.0, 0.0, 0.0)
    own, half = Field(nowhere, 0.0, 0.0), Field(scale(-slope, up), slope * offset, slope)
    if bodies.table[between.a, KIND] == SURFACE:
        nhat = vector_at_plane(bodies, e, 0)
        # The rigid surface is N and the half space M, the reverse of tetrahedra on a rigid one.
        if not (agrees(nhat, half.gradient, slope) or between.anyway):
            return
        corner = bodies.table[between.a, FIRST_POINT]
        for i in range(3):
            work[i, 0], work[i, 1], work[i, 2] = vector_in(
                bodies.points, corner + bodies.elements[e, i]
            )
        count, pressure, gradients = 3, half, (half.gradient, nowhere)
    else:
        own = Field(vector_in(bodies.fields, e), bodies.fields[e, 3], bodies.fields[e, 4])
        corners = corners_of(bodies, bodies.table[between.a, FIRST_POINT], e)
        n, length, pressure = up, 1.0, own
        if slope > 0.0:
            n, pressure = sub(own.gradient, half.gradient), softer(own, half)
            length = norm(n)
            if not differ(length, own.length, slope):
                return
            heights = differences(corners, own, half, rounding)
            rounding *= (own.length + slope) / length
        else:
            heights = _heights_above(up, offset, corners, rounding)
        if not is_cut(bodies, e, corners, heights, work):
            return
        nhat = scale(1.0 / length, n)
        agree = agrees(nhat, own.gradient, own.length)
        agree = agree and agrees(scale(-1.0, nhat), half.gradient, slope)
        if slope > 0.0 and not (agree or between.anyway):
            return
        count, gradients = cut(work, nhat), (own.gradient, half.gradient)
    at = 0
    if slope > 0.0 and count:
        for i in range(count):
            height = dot(up, vector_in(work, i)) - offset
            work[i, HEIGHT] = snapped(height, rounding)
        at, count, face = clipped(work, 0, count, 1, -1)
        # On the plane that bounds it no half space presses: as of two bodies in ``elements``.
        if face >= 0 and not is_pressed(work, at, count, own, between.rounding):
            return
    if count:
        count = without_twins(work, at, count, rounding)
    if count:
        emit(work, at, count, nhat, pressure, gradients, between, out)


@inlined
def _heights_above(
    up: Vector, offset: float, corners: tuple[Vector, Vector, Vector, Vector], rounding: float
) -> tuple[float, float, float, float]:
    """Return how high corners are above a plane."""
    c0, c1, c2, c3 = corners
    return (
        snapped(dot(up, c0) - offset, rounding),
        snapped(dot(up, c1) - offset, rounding),
        snapped(dot(up, c2) - offset, rounding),
        snapped(dot(up, c3) - offset, rounding),
    )
