"""Depth of two cores that are almost bodies of revolution about one axis, by half planes.

Two ellipsoids, or one in a cylinder or capsule, whose axes are almost parallel have a ring of
directions almost as good as the best. EPA would have to cover the ring with faces. Two facts
reduce it to some dozen half planes. Let u be the axis, e a unit vector normal to it at the angle
phi, and ``n = s e + c u``.

*A half plane is a planar problem.* With phi fixed, n moves along half of a great circle, and a
polygon proves that h is nowhere on it below a given number (see ``circles``).

*Between half planes h hardly bends.* With c fixed, each term of h as a function of phi has a
second derivative of at most

- ``S / b + |c| T / b`` for ``|E n|``, an ellipsoid with least semi-axis b, where S is the
  difference of the eigenvalues of ``Q = E^T E`` in the plane normal to u, and T the length of the
  component of Q u in that plane: for ``g = n . Q n`` it is ``g'' = 2 s^2 (e' . Q e' - e . Q e) -
  2 s c u . Q e``, and ``(sqrt g)'' <= g'' / (2 sqrt g)``;
- the length of q for ``-p . n``, where q is the component of p normal to u;
- 0 for a segment along u or a disk about u.

A function whose second derivative is at most M is at least the lesser of its values at the ends of
an interval of length w minus ``M w^2 / 8``. So a *cell* between two half planes w apart contains
no h below a number if ``h - (M_0 + |c| M_1) w^2 / 8`` is nowhere below it on both, where M_0 and
M_1 are the sums of the above. On either side of ``c = 0`` that subtracts only a constant and a
linear function from h. Cells that fail are halved.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.records import Difference, Least
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    AXES_A,
    AXES_B,
    LENGTH,
    SEGMENT,
    ends_at,
    width,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.circles import (
    ARC_WIDTH,
    BORDER,
    END,
    END_POINT,
    MOST_ARCS,
    START,
    START_POINT,
    chord_normal,
    improved,
    is_away,
    point_on_arc,
    put_arc,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    norm,
    perpendicular,
    scale,
    sub,
    unit,
    vector_at,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION, TIE

MOST_LOOKS = 1000  # examined cells; some dozens are usual
MOST_CELLS = 64
MOST_SPLITS = 400  # of the arcs of a half plane; some dozens are usual
FIRST_CELLS = 8
# Columns of a cell: the angle of its first half plane, and its width [rad].
ANGLE, SPAN = 0, 1


class Direction(NamedTuple):
    """The best direction n so far, its h [m]; unique if nothing clearly elsewhere is as good."""

    n: Vector
    h: float
    unique: bool


@compiled
def largest_curvatures(terms: Floats, u: Vector) -> tuple[float, float]:
    """Return (M_0, M_1) [m] about the axis u, common to all segments and disks."""
    x = perpendicular(u)
    y = cross(u, x)
    p = vector_in(terms, 0)
    flat, steep = norm(add_scaled(p, -dot(p, u), u)), 0.0
    for axes in (AXES_A, AXES_B):
        if terms[axes + 2, LENGTH] > 0.0:
            xx, yy, xy, xu, yu = 0.0, 0.0, 0.0, 0.0, 0.0
            for k in range(3):
                a = vector_in(terms, axes + k)
                v, w, t = dot(a, x), dot(a, y), dot(a, u)
                xx, yy, xy = xx + v * v, yy + w * w, xy + v * w
                xu, yu = xu + v * t, yu + w * t
            least = min(terms[axes, LENGTH], terms[axes + 1, LENGTH], terms[axes + 2, LENGTH])
            # Differences of squares are rounded.
            flat += (2.0 * math.hypot(0.5 * (xx - yy), xy) + TIE * (xx + yy)) / least
            steep += (math.hypot(xu, yu) + TIE * (xx + yy)) / least
    return flat, steep


@compiled
def roundest_axis(difference: Difference) -> tuple[Vector, float, float]:
    """Return (u, M_0, M_1) for the axis u about which the cores are most nearly round.

    It is that of a segment or disk if there is one, or else an axis of an ellipsoid.
    """
    terms, _, last, _, _ = difference
    if last > SEGMENT:
        u = scale(1.0 / terms[SEGMENT, LENGTH], vector_in(terms, SEGMENT))
        flat, steep = largest_curvatures(terms, u)
        return u, flat, steep
    best, flat, steep = (0.0, 0.0, 1.0), math.inf, math.inf
    for axes in (AXES_A, AXES_B):
        for k in range(3):
            u = unit(vector_in(terms, axes + k))
            flat_there, steep_there = largest_curvatures(terms, u)
            if flat_there + steep_there < flat + steep:
                best, flat, steep = u, flat_there, steep_there
    return best, flat, steep


@compiled
def slice_holds(
    difference: Difference,
    u: Vector,
    e: Vector,
    span: float,
    bends: tuple[float, float],
    best: Direction,
    enough: float,
    arcs: Floats,
) -> tuple[bool, float, Vector]:
    """Return (holds, floor, m): whether h is high enough on the half circle from -u over e to u.

    For a cell of width ``span`` [rad], with ``bends`` M_0 and M_1, h is compared with the best h
    minus ``enough``; clearly away from the best direction, if that is unique so far, with the best
    h plus twice that. ``floor`` is a lower bound of h in the cell; m is the direction that failed,
    or the last one examined.
    """
    terms, _, last, r_A, r_B = difference
    n, h, unique = best
    flat, steep = bends
    drop, tilt = 0.125 * span * span * flat, 0.125 * span * span * steep
    radius, axis, m = r_A + r_B + drop, cross(e, u), e
    waiting, floor = 0, math.inf
    for start, end, lean in ((scale(-1.0, u), e, tilt), (e, u, -tilt)):
        base = add_scaled(ends_at(terms, last, add(start, end)), lean, u)
        v, w = point_on_arc(terms, base, start), point_on_arc(terms, base, end)
        put_arc(arcs[waiting], start, end, v, w)
        waiting += 1
    for _ in range(MOST_SPLITS):
        if waiting == 0:
            return True, floor, m
        waiting -= 1
        arc = arcs[waiting]
        start, end = vector_at(arc, START), vector_at(arc, END)
        v, w = vector_at(arc, START_POINT), vector_at(arc, END_POINT)
        from_n, to_n = dot(start, n), dot(end, n)
        m, ends = chord_normal(arc, axis), min(dot(v, start), dot(w, end))
        at_end = dot(m, m) == 0.0 or ends < min(dot(v, m), dot(w, m))
        if at_end:
            m = start if dot(v, start) < dot(w, end) else end
        least = (ends if at_end else min(dot(v, m), dot(w, m))) - radius
        width_there = width(terms, last, r_A + r_B, m) - drop - tilt * abs(dot(m, u))
        needed, needed_here = h - enough, h - enough
        if unique and (span > BORDER or is_away(from_n, to_n, norm(sub(end, start)))):
            needed = h + 2.0 * enough
        if unique and (span > BORDER or dot(m, n) < SAME_DIRECTION):
            needed_here = h + 2.0 * enough
        if least >= needed:
            floor = min(floor, least)
            continue
        if width_there < needed_here or waiting + 2 > MOST_ARCS:
            return False, -math.inf, m
        if at_end:
            m = unit(add(start, end))
        base = add_scaled(ends_at(terms, last, m), tilt if dot(m, u) < 0.0 else -tilt, u)
        x = point_on_arc(terms, base, m)
        put_arc(arcs[waiting], start, m, v, x)
        put_arc(arcs[waiting + 1], m, end, x, w)
        waiting += 2
    return False, -math.inf, m


@compiled
def bettered(
    difference: Difference, best: Direction, m: Vector, enough: float, noise: float
) -> Direction:
    """Return the best ``Direction`` after examining m."""
    terms, _, last, r_A, r_B = difference
    n, h, unique = best
    width_there, far = width(terms, last, r_A + r_B, m), dot(m, n) < SAME_DIRECTION
    if width_there < h - noise:
        unique = h > width_there + 2.0 * enough if far else unique
        n, h, _ = improved(difference, m, width_there, enough, noise)
    elif far and width_there <= h + 2.0 * enough:
        unique = False
    return Direction(n, h, unique)


@allocating
def least_over_slices(
    difference: Difference, n: Vector, h: float, enough: float, noise: float
) -> Least:
    """Return the least h over all directions.

    ``n`` is a direction to start from and h [m] its value. The search is not complete if the
    splitting of cells was ended.
    """
    u, flat, steep = roundest_axis(difference)
    x = perpendicular(u)
    y = cross(u, x)
    arcs, cells = np.empty((MOST_ARCS, ARC_WIDTH)), np.empty((MOST_CELLS, 2))
    best, floor, waiting = Direction(n, h, True), h, FIRST_CELLS
    for k in range(FIRST_CELLS):
        cells[k, SPAN] = 2.0 * math.pi / FIRST_CELLS
        cells[k, ANGLE] = k * cells[k, SPAN]
    for _ in range(MOST_LOOKS):
        if waiting == 0:
            return Least(True, best.h, min(floor, best.h), best.n, best.unique)
        waiting -= 1
        angle, span = cells[waiting, ANGLE], cells[waiting, SPAN]
        passed, least = True, math.inf
        for k in range(2):
            phi = angle + k * span
            e = add_scaled(scale(math.cos(phi), x), math.sin(phi), y)
            if passed:
                passed, low, m = slice_holds(
                    difference, u, e, span, (flat, steep), best, enough, arcs
                )
                least = min(least, low)
                if not passed:
                    best = bettered(difference, best, m, enough, noise)
        if passed:
            floor = min(floor, least)
            continue
        if waiting + 2 > MOST_CELLS:
            break
        for k in range(2):
            cells[waiting + k, ANGLE] = angle + 0.5 * k * span
            cells[waiting + k, SPAN] = 0.5 * span
        waiting += 2
    return Least(False, best.h, floor, best.n, best.unique)
