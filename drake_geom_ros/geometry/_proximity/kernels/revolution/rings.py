"""Depth of a hull in a barrel much larger than the hull: radially or along the axis.

Along the unit n the width of the overlap is ``h(n) = r s + l |c| + k(n)`` with ``n = s e + c u``
for the axis u, radius r and half length l of a cylinder, or of a capsule's axis, where r is 0, and
``k(n) = max(-x . n)`` over the vertices x of the hull, from the barrel's centre. ``barrels`` shows
when no h is less than the least of those normal to the axis and along it. There are two directions
along it. Normal to it, on a circle, the vertices x and y extreme at the ends of an arc give
``k(n) >= max(-x . n, -y . n)`` on the whole arc. The least of that bound has a closed form. If k
is equal there, the arc is done; otherwise the extreme vertex there splits the arc. Each split
finds a new edge or vertex of the hull's projection, so the method ends, like cutting planes.
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
DIRECTION_WIDTH = 7  # of a row: n, the vertex x extreme along -n, -x . n
X, VALUE = 3, 6


@compiled
def is_bulged(radius: float, length: float, reach: float) -> bool:
    """Return whether the least h of all directions is normal to the axis or along it.

    For a cylinder with a rest whose support function k is within -reach and reach [m] (see
    ``barrels``).
    """
    turn = math.atan2(length, radius)
    bulge = math.hypot(radius, length)
    return bulge >= max(radius + reach * turn, length + reach * (0.5 * math.pi - turn))


@compiled
def look_along(
    directions: Floats, count: int, n: Vector, shape: Floats, R_WB: Floats, p: Vector
) -> None:
    """Write the unit n, and the vertex of the hull extreme along -n, to row ``count``."""
    x = add(p, support(CONVEX, shape, R_WB, scale(-1.0, n), 0.0))
    for i in range(3):
        directions[count, i] = n[i]
        directions[count, X + i] = x[i]
    directions[count, VALUE] = -dot(x, n)


@compiled
def least_of_two(directions: Floats, i: int, j: int, u: Vector) -> tuple[Vector, float]:
    """Return (n, least): the minimum of the larger ``-x . n`` on the arc from row i to j."""
    start, end = vector_in(directions, i), vector_in(directions, j)
    x, y = vector_in(directions, i, X), vector_in(directions, j, X)
    at, least = start, directions[i, VALUE]
    if directions[j, VALUE] < least:
        at, least = end, directions[j, VALUE]
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
    directions: Floats,
    u: Vector,
    shape: Floats,
    R_WB: Floats,
    p: Vector,
    enough: float,
    noise: float,
) -> tuple[bool, int, float, int]:
    """Return (complete, best, floor, count) of the least k normal to the unit u.

    The first ``count`` rows of ``directions`` are filled, ``best`` is the row of the least, and no
    k is below ``floor`` [m]. The search is not complete if the splitting was ended.
    """
    e = perpendicular(u)
    f = cross(u, e)
    arcs, count, best = np.empty((MOST_DIRECTIONS, 2), dtype=np.int64), 4, 0
    for k in range(4):
        m = e if k % 2 == 0 else f
        look_along(directions, k, m if k < 2 else scale(-1.0, m), shape, R_WB, p)
        arcs[k, 0], arcs[k, 1] = k, (k + 1) % 4
        best = k if directions[k, VALUE] < directions[best, VALUE] else best
    waiting, floor = 4, directions[best, VALUE]
    while waiting > 0:
        waiting -= 1
        i, j = arcs[waiting, 0], arcs[waiting, 1]
        n, least = least_of_two(directions, i, j, u)
        if least > directions[best, VALUE] + 2.0 * enough:
            continue
        if count == MOST_DIRECTIONS:
            return False, best, -math.inf, count
        look_along(directions, count, n, shape, R_WB, p)
        best = count if directions[count, VALUE] < directions[best, VALUE] else best
        if directions[count, VALUE] <= least + noise:
            floor = min(floor, least)
        else:
            arcs[waiting, 0], arcs[waiting, 1] = i, count
            arcs[waiting + 1, 0], arcs[waiting + 1, 1] = count, j
            waiting += 2
        count += 1
    return True, best, floor, count


@allocating
def least_of_hull_in_barrel(pair: CorePair, enough: float, noise: float) -> Least:
    """Return the least h of a hull B in a barrel A that is much larger.

    A is the core of a cylinder or of a capsule, whose radius is 0.
    """
    kind_A, shape_A, R_WA, _, shape_B, R_WB, p = pair
    radius, length = shape_A[SHAPE_RADIUS], shape_A[HALF_LENGTH]
    u = column(R_WA, 2)
    if kind_A == CAPSULE:
        radius = 0.0
    if not is_bulged(radius, length, norm(p) + hull_radius(shape_B)):
        return Least(False, math.inf, -math.inf, u, False)
    directions = np.empty((MOST_DIRECTIONS + 2, DIRECTION_WIDTH))
    complete, best, floor, count = least_across(directions, u, shape_B, R_WB, p, enough, noise)
    floor += radius
    for k in range(count):
        directions[k, VALUE] += radius
    for side in (-1.0, 1.0):
        look_along(directions, count, scale(side, u), shape_B, R_WB, p)
        directions[count, VALUE] += length
        best = count if directions[count, VALUE] < directions[best, VALUE] else best
        count += 1
    n, h, unique = vector_in(directions, best), directions[best, VALUE], True
    for k in range(count):
        elsewhere = dot(vector_in(directions, k), n) < SAME_DIRECTION
        unique = unique and not (elsewhere and directions[k, VALUE] <= h + 2.0 * enough)
    return Least(complete, h, min(floor, h), n, unique)
