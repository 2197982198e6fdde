"""Depth of a hull in a barrel that is large beside it: out across the axis, or along it.

Along the unit n the width of the overlap is ``h(n) = r s + l |c| + k(n)`` with ``n = s e + c u``
for the axis u, radius r and half length l of a cylinder, or of a capsule's axis, where r is 0, and
``k(n) = max(-x . n)`` over the vertices x of the hull, from the barrel's middle. ``barrels`` shows
where no h is less than the least across the axis and along it. Along it are two directions. Across
it, on a circle, the vertices x and y that are extreme at the ends of an arc give ``k(n) >=
max(-x . n, -y . n)`` on all of it. The least of that has a closed form; where k is no more the arc
is done, else what is extreme there cuts the arc in two. Each cut finds an edge of the hull's
shadow or a vertex of it that was not known, so this comes to an end, as the methods of cutting
planes do.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Least
from drake_geom_ros.geometry._proximity.kernels.revolution.circles import across
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import hull_radius
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import support
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    column,
    cross,
    dot,
    norm,
    perpendicular,
    scale,
    sub,
    unit,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import CAPSULE, CONVEX, HALF_LENGTH, SHAPE_RADIUS
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

MOST_DIRECTIONS = 160
DIRECTION_WIDTH = 7  # of a row: n, the vertex x that is extreme against it, -x . n
X, VALUE = 3, 6


@compiled
def is_bulged(radius: float, length: float, reach: float) -> bool:
    """Tell whether the least h of all is that of those across the axis and along it.

    For a cylinder with a rest whose support function k is within -reach and reach [m] (see
    ``barrels``).
    """
    turn = math.atan2(length, radius)
    bulge = math.hypot(radius, length)
    return bulge >= max(radius + reach * turn, length + reach * (0.5 * math.pi - turn))


@compiled
def look_along(
    known: Floats, count: int, n: Vector, shape: Floats, R_WB: Floats, p: Vector
) -> None:
    """Put the unit n, and the vertex of the hull that is extreme against it, in row ``count``."""
    x = add(p, support(CONVEX, shape, R_WB, scale(-1.0, n), 0.0))
    for i in range(3):
        known[count, i] = n[i]
        known[count, X + i] = x[i]
    known[count, VALUE] = -dot(x, n)


@compiled
def least_of_two(known: Floats, i: int, j: int, u: Vector) -> tuple[Vector, float]:
    """Return (n, least): where on the arc from row i to j the larger of ``-x . n`` is least."""
    start, end = vector_in(known, i), vector_in(known, j)
    x, y = vector_in(known, i, X), vector_in(known, j, X)
    at, least = start, known[i, VALUE]
    if known[j, VALUE] < least:
        at, least = end, known[j, VALUE]
    # On the arc: (y - x) . n is not negative at its start, where x is extreme, nor positive at
    # its end.
    crossing = across(unit(cross(u, sub(y, x))), u)
    for way in (crossing, unit(cross(cross(u, x), u)), unit(cross(cross(u, y), u))):
        inside = dot(cross(start, way), u) > 0.0 and dot(cross(way, end), u) > 0.0
        value = max(-dot(x, way), -dot(y, way))
        if inside and value < least:
            at, least = way, value
    return at, least


@allocating
def least_across(
    known: Floats, u: Vector, shape: Floats, R_WB: Floats, p: Vector, enough: float, noise: float
) -> tuple[bool, int, float, int]:
    """Return (complete, best, floor, count): the least k at right angles to the unit u.

    Rows of ``known`` below ``count`` are directions looked along, ``best`` is that of the least,
    and no k is below ``floor`` [m]. Not complete where the cuts did not come to an end.
    """
    e = perpendicular(u)
    f = cross(u, e)
    arcs, count, best = np.empty((MOST_DIRECTIONS, 2), dtype=np.int64), 4, 0
    for k in range(4):
        m = e if k % 2 == 0 else f
        look_along(known, k, m if k < 2 else scale(-1.0, m), shape, R_WB, p)
        arcs[k, 0], arcs[k, 1] = k, (k + 1) % 4
        best = k if known[k, VALUE] < known[best, VALUE] else best
    waiting, floor = 4, known[best, VALUE]
    while waiting > 0:
        waiting -= 1
        i, j = arcs[waiting, 0], arcs[waiting, 1]
        n, least = least_of_two(known, i, j, u)
        if least > known[best, VALUE] + 2.0 * enough:
            continue
        if count == MOST_DIRECTIONS:
            return False, best, -math.inf, count
        look_along(known, count, n, shape, R_WB, p)
        best = count if known[count, VALUE] < known[best, VALUE] else best
        if known[count, VALUE] <= least + noise:
            floor = min(floor, least)
        else:
            arcs[waiting, 0], arcs[waiting, 1] = i, count
            arcs[waiting + 1, 0], arcs[waiting + 1, 1] = count, j
            waiting += 2
        count += 1
    return True, best, floor, count


@allocating
def least_of_hull_in_barrel(pair: CorePair, enough: float, noise: float) -> Least:
    """Return (complete, h, floor, n, unique) of a barrel A that is large beside a hull B.

    A is the core of a cylinder or of a capsule, whose radius is 0.
    """
    kind_A, shape_A, R_WA, _, shape_B, R_WB, p = pair
    radius, length = shape_A[SHAPE_RADIUS], shape_A[HALF_LENGTH]
    u = column(R_WA, 2)
    if kind_A == CAPSULE:
        radius = 0.0
    if not is_bulged(radius, length, norm(p) + hull_radius(shape_B)):
        return Least(False, math.inf, -math.inf, u, False)
    known = np.empty((MOST_DIRECTIONS + 2, DIRECTION_WIDTH))
    complete, best, floor, count = least_across(known, u, shape_B, R_WB, p, enough, noise)
    floor += radius
    for k in range(count):
        known[k, VALUE] += radius
    for side in (-1.0, 1.0):
        look_along(known, count, scale(side, u), shape_B, R_WB, p)
        known[count, VALUE] += length
        best = count if known[count, VALUE] < known[best, VALUE] else best
        count += 1
    n, h, unique = vector_in(known, best), known[best, VALUE], True
    for k in range(count):
        elsewhere = dot(vector_in(known, k), n) < SAME_DIRECTION
        unique = unique and not (elsewhere and known[k, VALUE] <= h + 2.0 * enough)
    return Least(complete, h, min(floor, h), n, unique)
