"""Polygons: cut out of tetrahedra by planes, and clipped by them.

A polygon is rows of seven numbers: a position, and its heights above up to four planes, which are
interpolated where an edge is cut. So two tetrahedra see the same heights above the face that they
share but for their sign. (Sutherland and
Hodgman, Reentrant polygon clipping, CACM 17, 1974.)
"""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import MOST_CORNERS, Floats
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.vectors import cross, dot, sub, vector_in
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector, unsigned

HEIGHT = 3  # the first column of heights
CORNERS = 2 * MOST_CORNERS  # the row where the corners of a tetrahedron are, behind two polygons
ROWS, COLUMNS = CORNERS + 4, 7  # of the room that all this is done in


@inlined
def _cut_edge(work: Floats, i: int, j: int, column: int, to: int) -> None:
    """Put the point of height 0 between rows i and j into row ``to``."""
    first, second = work[unsigned(i), unsigned(column)], work[unsigned(j), unsigned(column)]
    t = first / (first - second)
    a, b, c = unsigned(i), unsigned(j), unsigned(to)
    for k in range(COLUMNS):
        work[c, k] = work[a, k] + t * (work[b, k] - work[a, k])


@compiled
def cut(work: Floats, normal: Vector) -> int:
    """Put the polygon where a tetrahedron meets a plane into the first rows.

    Return how many corners it has: 0, 3 or 4, counter-clockwise about ``normal``, the way that the
    heights grow. The tetrahedron's corners are in rows CORNERS on, with their heights; those of
    height 0 count as below.
    """
    first = second = third = low = lower = lowest = -1
    above = 0
    for i in range(CORNERS, CORNERS + 4):
        if work[i, HEIGHT] > 0.0:
            above += 1
            first, second, third = i, first, second
        else:
            low, lower, lowest = i, low, lower
    if above == 0 or above == 4:
        return 0
    if above == 2:
        _cut_edge(work, first, low, HEIGHT, 0)
        _cut_edge(work, first, lower, HEIGHT, 1)
        _cut_edge(work, second, lower, HEIGHT, 2)
        _cut_edge(work, second, low, HEIGHT, 3)
        count = 4
    else:
        tip = first if above == 1 else low
        others = (low, lower, lowest) if above == 1 else (first, second, third)
        for k in range(3):
            _cut_edge(work, tip, others[k], HEIGHT, k)
        count = 3
    one, last = vector_in(work, 1), vector_in(work, count - 1)
    middle = vector_in(work, 2 if count == 4 else 0)
    side = sub(middle, vector_in(work, 0)) if count == 4 else sub(one, middle)
    other = sub(last, one) if count == 4 else sub(last, middle)
    if dot(cross(side, other), normal) < 0.0:
        for k in range(COLUMNS):
            work[1, k], work[count - 1, k] = work[count - 1, k], work[1, k]
    return count


@compiled
def clipped(work: Floats, at: int, count: int, planes: int, passed: int) -> tuple[int, int, int]:
    """Clip a polygon in rows ``at`` on by planes; return where it is then, its corners, and -1.

    It is kept where all heights are 0 or less; what is no polygon has 0 corners. Where all of it
    is on a plane that is not ``passed`` it is returned as it is then, with that plane: whose it
    is others say.
    """
    if _are_above_one(work, at, count, planes):
        return at, 0, -1
    return clipped_by_each(work, at, count, planes, passed)


@inlined
def clipped_by_each(
    work: Floats, at: int, count: int, planes: int, passed: int
) -> tuple[int, int, int]:
    """Return what ``clipped`` does, of a polygon that is above none of the planes."""
    for k in range(planes):
        below = above = 0
        column = unsigned(HEIGHT + k)
        for i in range(at, at + count):
            height = work[unsigned(i), column]
            below += height < 0.0
            above += height > 0.0
        if below == 0 and above > 0:
            return at, 0, -1
        if below == 0 and k != passed:
            return at, count, k
        if above > 0:
            count = _clip(work, at, count, HEIGHT + k)
            at = MOST_CORNERS - at
        if count < 3:
            return at, 0, -1
    return at, count, -1


@inlined
def _are_above_one(work: Floats, at: int, count: int, planes: int) -> bool:
    """Return whether a plane has no corner below it, and not all of them on it."""
    for k in range(planes):
        lowest = highest = work[at, HEIGHT + k]
        for i in range(at + 1, at + count):
            lowest, highest = min(lowest, work[i, HEIGHT + k]), max(highest, work[i, HEIGHT + k])
        if lowest >= 0.0 and highest > 0.0:
            return True
    return False


@inlined
def _clip(work: Floats, at: int, count: int, column: int) -> int:
    """Put the part of a polygon below a plane into the other rows; return its corners."""
    to = first = MOST_CORNERS - at
    before = at + count - 1
    height = work[unsigned(before), unsigned(column)]
    for i in range(at, at + count):
        next_height = work[unsigned(i), unsigned(column)]
        if next_height * height < 0.0:
            _cut_edge(work, before, i, column, to)
            work[unsigned(to), unsigned(column)] = 0.0
            to += 1
        # Without a branch, for which corners stay nobody can guess.
        a, b = unsigned(i), unsigned(to)
        for k in range(COLUMNS):
            work[b, k] = work[a, k]
        to += next_height <= 0.0
        before, height = i, next_height
    return to - first


@inlined
def without_twins(work: Floats, at: int, count: int, near: float) -> int:
    """Leave out corners that are nearer than ``near`` [m] to the one before; return how many stay.

    Fewer than three are none.
    """
    kept = at
    for i in range(at, at + count):
        before = kept - 1 if kept > at else at + count - 1
        offset = sub(vector_in(work, i), vector_in(work, before))
        if dot(offset, offset) < near * near:
            continue
        if kept != i:
            for k in range(COLUMNS):
                work[kept, k] = work[i, k]
        kept += 1
    return kept - at if kept - at >= 3 else 0
