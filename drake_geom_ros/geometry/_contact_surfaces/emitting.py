"""Putting polygons, and their integrals, where surfaces come out."""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    AREA,
    CENTROID,
    CORNERS,
    FACE_AREA,
    FIRST_MOMENT,
    FORCE,
    GRAD_M,
    GRAD_N,
    NORMAL,
    POLYGONS,
    PRESSURE,
    PRESSURE_MOMENT,
    TORQUE,
    Between,
    Field,
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
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector, unsigned


@inlined
def _put(rows: Floats, row: int, column: int, v: Vector) -> None:
    """Put a vector into a row."""
    k = unsigned(row)
    rows[k, column], rows[k, column + 1], rows[k, column + 2] = v


@inlined
def _increase(rows: Floats, row: int, column: int, v: Vector) -> None:
    """Add a vector to a row."""
    k = unsigned(row)
    rows[k, column] += v[0]
    rows[k, column + 1] += v[1]
    rows[k, column + 2] += v[2]


@inlined
def emit(
    work: Floats,
    at: int,
    count: int,
    nhat: Vector,
    field: Field,
    gradients: tuple[Vector, Vector],
    between: Between,
    surfaces: Surfaces,
) -> None:
    """Put a polygon out, in World, if there is room for it, and count it.

    Its normal, the pressure and the gradients of the first body and the other one are those of the
    first body's frame. Nothing is put out, or counted, without area.
    """
    origin = vector_in(work, at)
    at_origin = _pressure(field, origin)
    area, moment = 0.0, (0.0, 0.0, 0.0)
    # Of pressure, and of it times position from the first corner: it is linear, so over a triangle
    # they are the mean of its corners' times the area, and area / 12 (sum p sum x + sum p x).
    force, pressed = 0.0, (0.0, 0.0, 0.0)
    side, before = (
        sub(vector_in(work, unsigned(at + 1)), origin),
        _pressure(field, vector_in(work, unsigned(at + 1))),
    )
    for i in range(at + 2, at + count):
        corner = vector_in(work, unsigned(i))
        next_side, after = sub(corner, origin), _pressure(field, corner)
        twice = dot(cross(side, next_side), nhat)
        area += 0.5 * twice
        moment = add_scaled(moment, twice / 6.0, add(side, next_side))
        total = at_origin + before + after
        force += twice / 6.0 * total
        pressed = add_scaled(pressed, twice / 24.0 * (total + before), side)
        pressed = add_scaled(pressed, twice / 24.0 * (total + after), next_side)
        side, before = next_side, after
    if not area > between.rounding * between.rounding:
        return
    row, faces, points = between.row, surfaces.counts[POLYGONS], surfaces.counts[CORNERS]
    surfaces.counts[POLYGONS], surfaces.counts[CORNERS] = faces + 1, points + count
    if faces >= len(surfaces.ends) or points + count > len(surfaces.points):
        return
    surfaces.ends[unsigned(faces)] = points + count
    for i in range(count):
        corner = vector_in(work, unsigned(at + (count - 1 - i if between.flip else i)))
        surfaces.pressures[unsigned(points + i)] = _pressure(field, corner)
        _put(surfaces.points, points + i, 0, add(rotate(between.R_W, corner), between.p_W))
    normal = scale(-1.0, nhat) if between.flip else nhat
    _put(surfaces.faces, faces, NORMAL, rotate(between.R_W, normal))
    surfaces.faces[unsigned(faces), FACE_AREA] = area
    middle = add_scaled(origin, 1.0 / area, moment)
    _put(surfaces.faces, faces, CENTROID, add(rotate(between.R_W, middle), between.p_W))
    own, others = (GRAD_N, GRAD_M) if between.flip else (GRAD_M, GRAD_N)
    _put(surfaces.faces, faces, own, rotate(between.R_W, gradients[0]))
    _put(surfaces.faces, faces, others, rotate(between.R_W, gradients[1]))
    _add(surfaces.sums, row, AREA, area, add_scaled(moment, area, origin))
    pressed = add_scaled(pressed, force, origin)
    _increase(surfaces.sums, row, FORCE, scale(force, nhat))
    _add(surfaces.sums, row, PRESSURE, force, pressed)
    _increase(surfaces.sums, row, TORQUE, cross(pressed, nhat))


@compiled
def sums_in_world(sums: Floats, between: Between) -> None:
    """Put the integrals of a pair, which are summed up in the first body's frame, into World.

    Once a pair: far from World's origin positions in it are coarse, and many of them add up.
    """
    row, sign = between.row, -1.0 if between.flip else 1.0
    for k in (FIRST_MOMENT, PRESSURE_MOMENT):
        moment = rotate(between.R_W, vector_in(sums, row, k))
        weight = sums[row, k - 1]
        _put(sums, row, k, add_scaled(moment, weight, between.p_W))
    force = scale(sign, rotate(between.R_W, vector_in(sums, row, FORCE)))
    torque = scale(sign, rotate(between.R_W, vector_in(sums, row, TORQUE)))
    _put(sums, row, FORCE, force)
    _put(sums, row, TORQUE, add(torque, cross(between.p_W, force)))


@inlined
def _add(sums: Floats, row: int, column: int, weight: float, moment: Vector) -> None:
    """Add to an integral, and to that of it times position in the columns behind it."""
    sums[unsigned(row), column] += weight
    _increase(sums, row, column + 1, moment)


@inlined
def _pressure(field: Field, corner: Vector) -> float:
    """Return the pressure at a corner: less than none is rounding."""
    pressure: float = max(dot(field.gradient, corner) + field.level, 0.0)
    return pressure
