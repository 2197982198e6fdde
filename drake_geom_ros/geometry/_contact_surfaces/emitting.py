"""Putting polygons, and their integrals, where surfaces come out."""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    AREA,
    CENTROID,
    FACE_AREA,
    FIRST_MOMENT,
    FORCE,
    GRAD_M,
    GRAD_N,
    NORMAL,
    PRESSURE,
    PRESSURE_MOMENT,
    TORQUE,
    Between,
    Floats,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    rotate,
    scale,
    sub,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector


@inlined
def _put(rows: Floats, row: int, column: int, v: Vector) -> None:
    """Put a vector into a row."""
    rows[row, column], rows[row, column + 1], rows[row, column + 2] = v


@inlined
def _increase(rows: Floats, row: int, column: int, v: Vector) -> None:
    """Add a vector to a row."""
    rows[row, column] += v[0]
    rows[row, column + 1] += v[1]
    rows[row, column + 2] += v[2]


@compiled
def emit(
    work: Floats,
    at: int,
    count: int,
    nhat: Vector,
    field: tuple[Vector, float],
    other: Vector,
    between: Between,
    surfaces: Surfaces,
    pair: int,
) -> None:
    """Put a polygon out, in World, if there is room for it, and count it.

    Its normal, the pressure (gradient, and value at the origin) and the other body's gradient are
    those of the first body's frame. Nothing is put out, or counted, without area.
    """
    origin = vector_in(work, at)
    area, moment, twice = 0.0, (0.0, 0.0, 0.0), 0.0
    for i in range(at + 1, at + count - 1):
        side, next_side = sub(vector_in(work, i), origin), sub(vector_in(work, i + 1), origin)
        twice = dot(cross(side, next_side), nhat)
        area += 0.5 * twice
        moment = add_scaled(moment, twice / 6.0, add(side, next_side))
    if not area > between.rounding * between.rounding:
        return
    faces, points = surfaces.counts[0], surfaces.counts[1]
    surfaces.counts[0], surfaces.counts[1] = faces + 1, points + count
    if faces >= len(surfaces.ends) or points + count > len(surfaces.points):
        return
    surfaces.ends[faces] = points + count
    gradient, constant = field
    for i in range(count):
        corner = vector_in(work, at + (count - 1 - i if between.flip else i))
        surfaces.pressures[points + i] = max(dot(gradient, corner) + constant, 0.0)
        _put(surfaces.points, points + i, 0, add(rotate(between.R_W, corner), between.p_W))
    sign = -1.0 if between.flip else 1.0
    normal_W = scale(sign, rotate(between.R_W, nhat))
    middle = add_scaled(origin, 1.0 / area, moment)
    _put(surfaces.faces, faces, NORMAL, normal_W)
    surfaces.faces[faces, FACE_AREA] = area
    _put(surfaces.faces, faces, CENTROID, add(rotate(between.R_W, middle), between.p_W))
    own, others = (GRAD_N, GRAD_M) if between.flip else (GRAD_M, GRAD_N)
    _put(surfaces.faces, faces, own, rotate(between.R_W, gradient))
    _put(surfaces.faces, faces, others, rotate(between.R_W, other))
    _sum(surfaces, pair, faces, points, count)


@compiled
def _sum(surfaces: Surfaces, pair: int, face: int, first: int, count: int) -> None:
    """Add the integrals over a polygon to those of its pair.

    The pressure is linear: over a triangle its integral is the mean of its corners' times the
    area, and that of pressure times position area / 12 (sum p sum x + sum p x).
    """
    sums, nhat = surfaces.sums, vector_in(surfaces.faces, face, NORMAL)
    area = surfaces.faces[face, FACE_AREA]
    origin = vector_in(surfaces.points, first)
    force, moment = 0.0, (0.0, 0.0, 0.0)
    for i in range(first + 1, first + count - 1):
        a, b = (
            sub(vector_in(surfaces.points, i), origin),
            sub(vector_in(surfaces.points, i + 1), origin),
        )
        third = dot(cross(a, b), nhat) / 6.0
        p, q, r = surfaces.pressures[first], surfaces.pressures[i], surfaces.pressures[i + 1]
        force += third * (p + q + r)
        moment = add_scaled(moment, 0.25 * third * (p + 2.0 * q + r), a)
        moment = add_scaled(moment, 0.25 * third * (p + q + 2.0 * r), b)
    moment = add_scaled(moment, force, origin)
    sums[pair, AREA] += area
    _increase(sums, pair, FIRST_MOMENT, scale(area, vector_in(surfaces.faces, face, CENTROID)))
    _increase(sums, pair, FORCE, scale(force, nhat))
    sums[pair, PRESSURE] += force
    _increase(sums, pair, PRESSURE_MOMENT, moment)
    _increase(sums, pair, TORQUE, cross(moment, nhat))
