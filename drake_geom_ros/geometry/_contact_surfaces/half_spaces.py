"""The polygon of an element and a half space."""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FIRST_POINT,
    KIND,
    SURFACE,
    Between,
    Bodies,
    Floats,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.clipping import HEIGHT, clipped, cut, without_twins
from drake_geom_ros.geometry._contact_surfaces.compiled import inlined
from drake_geom_ros.geometry._contact_surfaces.elements import (
    agrees,
    corners_of,
    differ,
    is_cut_by,
    snapped,
    vector_at_plane,
)
from drake_geom_ros.geometry._contact_surfaces.emitting import emit
from drake_geom_ros.geometry._proximity.kernels.vectors import dot, norm, scale, sub, vector_in


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
        if not (agrees(nhat, h, slope) or between.anyway):
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
            if not differ(length, bodies.fields[e, 4], slope):
                return
            rounding *= (bodies.fields[e, 4] + slope) / length
        corners = corners_of(bodies, bodies.table[between.a, FIRST_POINT], e)
        if not is_cut_by(bodies, e, corners, (n, level, length), rounding, work):
            return
        nhat = scale(1.0 / length, n)
        agree = agrees(nhat, g, bodies.fields[e, 4]) and agrees(scale(-1.0, nhat), h, slope)
        if slope > 0.0 and not (agree or between.anyway):
            return
        count, field, other = cut(work, nhat), (g, bodies.fields[e, 3]), h
    at = 0
    if slope > 0.0 and count:
        for i in range(count):
            height = dot(up, vector_in(work, i)) - offset
            work[i, HEIGHT] = snapped(height, rounding)
        at, count, face = clipped(work, 0, count, 1, -1)
        if face >= 0:
            return
    if count:
        count = without_twins(work, at, count, rounding)
    if count:
        emit(work, at, count, nhat, field, other, between, out)
