"""The least translation that separates two sets of boxes: no shorter one separates the solids.

All boxes of A have the axes of A and all of B those of B, so the same few axes separate any two of
them: three where A's axes are B's, else up to fifteen. A box of A is moved out of one of B when it
is moved along one of these directions m by at least a width. So the least translation t fulfils
``m . t >= width`` for a direction of each two boxes that overlap. A best-first search finds it:
a node has a bound for some directions; the shortest t within them has a closed form; the search
branches on the two boxes that overlap the most after it. The shortest t of all remaining nodes is
a lower bound at any time, and where it separates all boxes it is the least.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    column,
    cross,
    dot,
    norm,
    rotate,
    scale,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    INDEPENDENT,
    PARALLEL,
    SAME_DIRECTION,
)

MOST_NODES = 400
SNAP = 16.0 * EPS  # of a rotation's elements from 0 and 1, to take its axes for the other's
TIES = 8.0  # roundings that translations as long may differ by
NO_BOUND = -math.inf


class Parting(NamedTuple):
    """Bounds of the least translation that separates: it is no shorter than ``lower``.

    If ``separates``, ``t`` (3,) separates all boxes and is as long as ``lower``, to rounding. If
    ``alone``, no other as long does along a clearly different direction.
    """

    lower: float
    t: Vector
    separates: bool
    alone: bool


@compiled
def nearly_swaps_axes(R: Floats) -> bool:
    """Return whether a rotation takes axes to axes, to rounding."""
    for i in range(3):
        for j in range(3):
            if abs(R[i, j]) > SNAP and abs(abs(R[i, j]) - 1.0) > SNAP:
                return False
    return True


@allocating
def directions_of(R: Floats) -> tuple[Floats, float]:
    """Return (directions (2 n, 3), slack [-] for those left out): axes and their reverses."""
    ways, count, slack = np.empty((30, 3)), 0, 0.0
    for k in range(15):
        if k < 3:
            e = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
        elif nearly_swaps_axes(R):
            return ways[:count].copy(), 4.0 * SNAP
        elif k < 6:
            e = column(R, k - 3)
        else:
            i, j = (k - 6) // 3, (k - 6) % 3
            x = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
            e = cross(x, column(R, j))
            if norm(e) < PARALLEL:
                slack = 4.0 * PARALLEL
                continue
            e = unit(e)
        for c in range(3):
            ways[count, c], ways[count + 1, c] = e[c], -e[c]
        count += 2
    return ways[:count].copy(), slack


@allocating
def widths_of(
    boxes: tuple[Floats, Floats],
    R: Floats,
    p: Vector,
    ways: Floats,
    slack: float,
    limits: tuple[float, float],
) -> Floats:
    """Return the widths (k, 2 n) of each two boxes that may overlap within moves below ``upper``.

    A width is how far a box of A is to be moved along a direction to be beyond one of B by
    ``more``; ``limits`` are (upper, more) [m], ``slack`` [-] is for directions left out.
    """
    (boxes_A, boxes_B), (upper, more) = boxes, limits
    count, width = 0, np.empty((boxes_A.shape[0] * boxes_B.shape[0], ways.shape[0]))
    for i in range(boxes_A.shape[0]):
        low, high = vector_at(boxes_A[i], 0), vector_at(boxes_A[i], 3)
        half = 0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2])
        middle = add(rotate(R, scale(0.5, add(low, high))), p)
        for j in range(boxes_B.shape[0]):
            start, end = vector_at(boxes_B[j], 0), vector_at(boxes_B[j], 3)
            room = 0.5 * (end[0] - start[0]), 0.5 * (end[1] - start[1]), 0.5 * (end[2] - start[2])
            between = add_scaled(scale(0.5, add(start, end)), -1.0, middle)
            least = math.inf
            for d in range(ways.shape[0]):
                m = vector_at(ways[d], 0)
                reach = abs(m[0]) * room[0] + abs(m[1]) * room[1] + abs(m[2]) * room[2]
                for c in range(3):
                    reach += abs(dot(m, column(R, c))) * half[c]
                width[count, d] = dot(m, between) + reach - slack * (norm(half) + norm(room))
                width[count, d] += more
                least = min(least, width[count, d])
            if least > -upper:
                count += 1
    return width[:count].copy()


@compiled
def on_axes(bounds: Floats) -> tuple[bool, Vector]:
    """Return (feasible, t): the shortest t within bounds along three axes and their reverses."""
    t = (
        max(bounds[0], 0.0) - max(bounds[1], 0.0),
        max(bounds[2], 0.0) - max(bounds[3], 0.0),
        max(bounds[4], 0.0) - max(bounds[5], 0.0),
    )
    for k in range(3):
        if bounds[2 * k] + bounds[2 * k + 1] > 0.0:
            return False, t
    return True, t


@compiled
def weights_of(
    m: Vector, n: Vector, o: Vector, a: float, b: float, c: float
) -> tuple[bool, Vector]:
    """Return (is_valid, t) with m . t = a, n . t = b and o . t = c.

    It is valid if t is a sum of m, n and o, clearly independent, with no negative weight.
    """
    volume = dot(m, cross(n, o))
    if volume * volume < INDEPENDENT:
        return False, m
    x, y, z = (
        scale(1.0 / volume, cross(n, o)),
        scale(1.0 / volume, cross(o, m)),
        scale(1.0 / volume, cross(m, n)),
    )
    t = add(add(scale(a, x), scale(b, y)), scale(c, z))
    return dot(t, x) >= 0.0 and dot(t, y) >= 0.0 and dot(t, z) >= 0.0, t


@compiled
def longest_foot(ways: Floats, bounds: Floats) -> Vector:
    """Return the shortest t within bounds along any directions, as the longest that some require.

    One, two or three active bounds require a t, and every t within all bounds is no shorter: so
    the result is no longer than the shortest, whatever is left out.
    """
    best, longest = (0.0, 0.0, 0.0), 0.0
    for i in range(bounds.size):
        a, m = bounds[i], vector_at(ways[i], 0)
        if a > longest:
            best, longest = scale(a, m), a
        if a == NO_BOUND:
            continue
        for j in range(i + 1, bounds.size):
            b, n = bounds[j], vector_at(ways[j], 0)
            g = dot(m, n)
            if b == NO_BOUND or 1.0 - g * g < INDEPENDENT:
                continue
            x, y = (a - g * b) / (1.0 - g * g), (b - g * a) / (1.0 - g * g)
            if x >= 0.0 and y >= 0.0:
                t = add(scale(x, m), scale(y, n))
                if norm(t) > longest:
                    best, longest = t, norm(t)
            for k in range(j + 1, bounds.size):
                c, o = bounds[k], vector_at(ways[k], 0)
                if c == NO_BOUND:
                    continue
                is_valid, t = weights_of(m, n, o, a, b, c)
                if is_valid and norm(t) > longest:
                    best, longest = t, norm(t)
    return best


@compiled
def shortest(ways: Floats, bounds: Floats) -> tuple[bool, Vector]:
    """Return (feasible, t): the shortest t within bounds, or that there is none."""
    if ways.shape[0] == 6:
        return on_axes(bounds)
    for k in range(0, bounds.size, 2):
        if bounds[k] + bounds[k + 1] > 0.0:
            return False, (0.0, 0.0, 0.0)
    return True, longest_foot(ways, bounds)


@compiled
def most_overlapping(width: Floats, ways: Floats, t: Vector) -> tuple[int, float]:
    """Return (k, depth): the two boxes that overlap the most after the move by t, and how deep."""
    best, deepest = -1, -math.inf
    for k in range(width.shape[0]):
        least = math.inf
        for d in range(ways.shape[0]):
            least = min(least, width[k, d] - dot(vector_at(ways[d], 0), t))
            if least <= deepest:
                break
        if least > deepest:
            best, deepest = k, least
    return best, deepest


@compiled
def is_listed(bounds: Floats, lengths: Floats, count: int, new: Floats, length: float) -> bool:
    """Return whether a node of the same bounds is listed already."""
    for k in range(count):
        if lengths[k] == length:
            same = True
            for d in range(new.size):
                same = same and bounds[k, d] == new[d]
            if same:
                return True
    return False


@compiled
def is_alone(
    ways: Floats, bounds: Floats, lengths: Floats, count: int, t: Vector, longest: float
) -> bool:
    """Return whether all nodes up to a length go along about the same direction as t."""
    for k in range(count):
        if lengths[k] <= longest:
            _, other = shortest(ways, bounds[k])
            if dot(unit(other), unit(t)) < SAME_DIRECTION:
                return False
    return True


@allocating
def least_parting(
    boxes: tuple[Floats, Floats], R: Floats, p: Vector, limits: tuple[float, float], noise: float
) -> Parting:
    """Return the ``Parting`` of boxes (k, 6) of A, turned by R and moved by p, from boxes of B.

    ``limits`` are (upper, more) [m]: ``lower`` is no more than ``upper``, which separates them,
    and they count as apart from ``more`` on; ``noise`` [m] is rounding.
    """
    (boxes_A, boxes_B), upper = boxes, limits[0]
    nothing = Parting(0.0, (0.0, 0.0, 0.0), False, False)
    if boxes_A.shape[0] == 0 or boxes_B.shape[0] == 0:
        return nothing
    ways, slack = directions_of(R)
    width = widths_of(boxes, R, p, ways, slack, limits)
    bounds, lengths = np.empty((MOST_NODES, ways.shape[0])), np.empty(MOST_NODES)
    bounds[0], lengths[0], count = NO_BOUND, 0.0, 1
    here = np.empty(ways.shape[0])
    while True:
        node = 0
        for k in range(1, count):
            if lengths[k] < lengths[node]:
                node = k
        length = lengths[node] if count > 0 else upper
        if length >= upper - noise:
            return Parting(max(upper - noise, 0.0), (0.0, 0.0, 0.0), False, False)
        here[:] = bounds[node]
        _, t = shortest(ways, here)
        pair, deep = most_overlapping(width, ways, t)
        if deep <= noise or count + ways.shape[0] > MOST_NODES:
            alone = is_alone(ways, bounds, lengths, count, t, length + TIES * noise)
            return Parting(max(length - noise, 0.0), t, deep <= noise, alone)
        count, least = count - 1, length
        bounds[node], lengths[node] = bounds[count], lengths[count]
        for d in range(ways.shape[0]):
            before = here[d]
            if width[pair, d] <= before:  # rounding hides that it is beyond this bound
                return Parting(max(least - noise, 0.0), t, False, False)
            if width[pair, d] < upper:
                here[d] = width[pair, d]
                feasible, t = shortest(ways, here)
                length = norm(t)
                if (
                    feasible
                    and length < upper
                    and not is_listed(bounds, lengths, count, here, length)
                ):
                    bounds[count], lengths[count] = here, length
                    count += 1
                here[d] = before
