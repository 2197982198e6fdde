"""Separation of two bodies over a time span, by a plane or by a bound of their relative motion.

Let a plane whose normal is fixed in the axes of a node have A on one side and B on the other.
Their distance is at least the gap that the plane leaves. Along the normal, a point deviates from
the chord of its path by at most ``bend w^2 / 8`` in a span w (de Boor, A Practical Guide to
Splines, chapter II, the error of linear interpolation). So the gap is at least that parabola
through its values at both ends.

This bound is of second order: short spans of bodies that pass each other closely are proved at
once. The bound by relative motion is of first order (Schwarzer, Saha, Latombe, 2002) and needs as
many spans as the ratio of motion and distance.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import support_value
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    column,
    cross,
    dot,
    rotate,
    scale,
    unit,
    unrotate,
    vector_at,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.motion.arrays import MotionArrays
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import apart
from drake_geom_ros.geometry._proximity.pairs.error_bounds import (
    rounding_of_pair,
    size_of_pair,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import CARRIED_PLANE
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays


@inlined
def _turned(q: Floats, v: Vector, sign: float) -> Vector:
    """Return v rotated by a pose (7,), or by its inverse for a sign of -1."""
    axis, w = (sign * q[3], sign * q[4], sign * q[5]), q[6]
    twice = scale(2.0, cross(axis, v))
    return add(add(v, scale(w, twice)), cross(axis, twice))


@inlined
def _carrier_of(motion: MotionArrays, node: int) -> int:
    """Return the node that carries the robot of a link: the world or a frame."""
    while 0 < node <= motion.X_WLs.shape[0]:
        node = motion.parents[node]
    return node


@inlined
def in_world(motion: MotionArrays, world: WorldArrays, node: int, n: Vector) -> Vector:
    """Return a direction in the world's axes, given in those of a node."""
    links = motion.X_WLs.shape[0]
    if 0 < node <= links:
        n = _turned(row(motion.X_WLs, node - 1), n, 1.0)
        node = _carrier_of(motion, node)
    if node == 0:
        return n
    return rotate(row(world.R_WFs, node - links), n)


@inlined
def in_node(motion: MotionArrays, world: WorldArrays, node: int, n: Vector) -> Vector:
    """Return a direction in the axes of a node, given in those of the world."""
    links, carrier = motion.X_WLs.shape[0], _carrier_of(motion, node)
    if carrier != 0:
        n = unrotate(row(world.R_WFs, carrier - links), n)
    if node == carrier:
        return n
    return _turned(row(motion.X_WLs, node - 1), n, -1.0)


@inlined
def _reach_along(world: WorldArrays, g: int, n: Vector) -> float:
    """Return the support value [m] of a body, from its origin, along a unit vector in World."""
    shape = part(world.pool, world.starts[g], world.starts[g + 1])
    return support_value(world.types[g], shape, unrotate(row(world.R_WGs, g), n))


@inlined
def gap_along(world: WorldArrays, a: int, b: int, n: Vector) -> float:
    """Return a lower bound of the gap [m] between a and b along the unit normal n, from a to b.

    It is negative where there is no gap. For a half space its own normal replaces n. The rounding
    of poses, of the carried normal and of this sum is subtracted.
    """
    types, p_WGs = world.types, world.p_WGs
    if types[a] == HALF_SPACE:
        n = column(row(world.R_WGs, a), 2)
    elif types[b] == HALF_SPACE:
        n = scale(-1.0, column(row(world.R_WGs, b), 2))
    p_WA, p_WB = vector_in(p_WGs, a), vector_in(p_WGs, b)
    gap = dot(n, (p_WB[0] - p_WA[0], p_WB[1] - p_WA[1], p_WB[2] - p_WA[2]))
    if types[a] != HALF_SPACE:
        gap -= _reach_along(world, a, n)
    if types[b] != HALF_SPACE:
        gap -= _reach_along(world, b, scale(-1.0, n))
    extent = size_of_pair(a, b, types, world.outer) + apart(p_WGs, a, b)
    rounding = rounding_of_pair(a, b, extent, world.roundings)
    return gap - rounding - CARRIED_PLANE * extent


@inlined
def first_guess(world: WorldArrays, a: int, b: int) -> Vector:
    """Return a unit vector in World from one body to the other, guessed from boxes and origins.

    It is the axis along which the boxes are farthest apart, or the line of the origins if that
    leaves a larger gap.
    """
    p_WGs, halves = world.p_WGs, world.half_extents
    most, best = -math.inf, 0
    for c in range(3):
        separation = abs(p_WGs[b, c] - p_WGs[a, c]) - halves[a, c] - halves[b, c]
        if separation > most:
            most, best = separation, c
    sign = 1.0 if p_WGs[b, best] >= p_WGs[a, best] else -1.0
    axis = (
        sign if best == 0 else 0.0,
        sign if best == 1 else 0.0,
        sign if best == 2 else 0.0,
    )
    line = unit((p_WGs[b, 0] - p_WGs[a, 0], p_WGs[b, 1] - p_WGs[a, 1], p_WGs[b, 2] - p_WGs[a, 2]))
    straight = gap_along(world, a, b, line)
    if straight > most and dot(line, line) > 0.0:
        return line
    return axis


@inlined
def least_gap(first: float, last: float, sag: float) -> float:
    """Return the least value [m] of a gap within a span, from its values at both ends.

    In between it is at most ``4 sag u (1 - u)`` below the chord, for u from 0 to 1.
    """
    least = min(first, last)
    rise = abs(last - first)
    if not rise < 4.0 * sag:
        return least
    # The parabola has its lowest point within the span.
    return 0.5 * (first + last) - sag - 0.0625 * rise * (rise / sag)


@inlined
def least_by_way(first: float, last: float, way: float) -> float:
    """Return the least distance [m] of bodies within a span, from those at both ends.

    Meanwhile they move relative to each other by at most ``way`` [m].
    """
    return min(0.5 * (first + last - way), first, last)


@inlined
def normal_of_answer(out: Floats, normal: int) -> Vector:
    """Return the unit normal out of A towards B of an answer's row."""
    return scale(-1.0, vector_at(out, normal))
