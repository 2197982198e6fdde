"""The triangles of a solid that are nearest to a point: a walk over its tree for points.

The result does not depend on where the walk began, nor on its order: all triangles that are as
near as the nearest one, to rounding, each with the vector to its nearest point.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.cores.simplices import (
    closest_on_triangle,
    weighted,
)
from drake_geom_ros.geometry._proximity.kernels.solids.lane_tree import (
    MOST_WAITING,
    LaneTree,
    boxes_in,
    first_of_block,
    groups_in,
)
from drake_geom_ros.geometry._proximity.kernels.solids.lanes import (
    BOX_LANES,
    LANES,
    TRIANGLE_LANES,
    lowest,
    near_boxes,
    near_triangles,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import CORNERS, Tree
from drake_geom_ros.geometry._proximity.kernels.vectors import norm, sub, vector_at
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import EPS, LANE_ERROR, ROUNDING

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

FEW = 64  # triangles that the first scratch holds
FULL = -1  # more are as near than the scratch holds


class PointScratch(NamedTuple):
    """The arrays of a walk: boxes that wait, gaps of lanes, and the nearest triangles so far."""

    firsts: Indices  # (levels,) where the groups of each begin
    levels: Indices  # (MOST_WAITING,)
    boxes: Indices  # (MOST_WAITING,)
    waiting: Floats  # (MOST_WAITING,) gaps [m]
    gaps: Floats  # (LANES,) [m]
    triangles: Indices  # (k,)
    away: Floats  # (k,) [m]
    vectors: Floats  # (k, 3) [m] from the point to the nearest one on each


@allocating
def scratch_for(lanes: LaneTree, count: int) -> PointScratch:
    """Return scratch arrays for up to ``count`` triangles that are as near as the nearest."""
    firsts = np.zeros(lanes.levels, dtype=np.int64)
    for level in range(1, lanes.levels):
        firsts[level] = firsts[level - 1] + groups_in(lanes.blocks, lanes.levels, level - 1)
    return PointScratch(
        firsts,
        np.empty(MOST_WAITING, dtype=np.int64),
        np.empty(MOST_WAITING, dtype=np.int64),
        np.empty(MOST_WAITING),
        np.empty(LANES),
        np.empty(count, dtype=np.int64),
        np.empty(count),
        np.empty((count, 3)),
    )


@inlined
def rounding_at(distance: float, extent: float) -> float:
    """Return how far off the distance [m] of a point from a triangle of a solid may be.

    All is computed from the differences of corners and the point, none of which is longer than the
    distance and the solid's ``extent`` [m] together.
    """
    return ROUNDING * EPS * (distance + extent)


@inlined
def same_at(distance: float, extent: float) -> float:
    """Return how much farther [m] a triangle may seem that is as near."""
    return 2.0 * rounding_at(distance, extent)


@inlined
def vector_to(shape: Floats, tree: Tree, j: int, q: Vector) -> Vector:
    """Return the vector from q to the point of triangle j that is nearest to it."""
    at = tree.corners + CORNERS * j
    a, b = sub(vector_at(shape, at), q), sub(vector_at(shape, at + 3), q)
    c = sub(vector_at(shape, at + 6), q)
    return weighted(a, b, c, closest_on_triangle(a, b, c))


@inlined
def _examine_block(
    shape: Floats,
    tree: Tree,
    lanes: LaneTree,
    k: int,
    q: Vector,
    extent: float,
    best_so_far: tuple[float, int],
    scratch: PointScratch,
) -> tuple[float, int]:
    """Add the near triangles of block k to ``best_so_far``, (best, count); return its new value.

    The count is FULL if the scratch holds no more.
    """
    best, count = best_so_far
    first, last = first_of_block(tree, lanes, k), first_of_block(tree, lanes, k + 1)
    at, loose = lanes.blocks_at + TRIANGLE_LANES * k, LANE_ERROR * (best + extent)
    bits = near_triangles(shape, at, q, best, loose) & ((1 << (last - first)) - 1)
    while bits != 0:
        j = first + lowest(bits)
        bits &= bits - 1
        v = vector_to(shape, tree, j, q)
        distance = norm(v)
        if distance > best + same_at(best, extent):
            continue
        if count == scratch.triangles.size:
            count = _without_farther(scratch, count, best + same_at(best, extent))
            if count == scratch.triangles.size:
                return best, FULL
        scratch.triangles[count], scratch.away[count] = j, distance
        scratch.vectors[count, 0], scratch.vectors[count, 1], scratch.vectors[count, 2] = v
        count += 1
        best = min(best, distance)
    return best, count


@compiled
def _without_farther(scratch: PointScratch, count: int, limit: float) -> int:
    """Drop the triangles that are farther than a limit [m]; return how many are left."""
    remaining = 0
    for i in range(count):
        if scratch.away[i] <= limit:
            scratch.triangles[remaining], scratch.away[remaining] = (
                scratch.triangles[i],
                scratch.away[i],
            )
            for c in range(3):
                scratch.vectors[remaining, c] = scratch.vectors[i, c]
            remaining += 1
    return remaining


@inlined
def _put(top: int, level: int, box: int, gap: float, scratch: PointScratch) -> None:
    """Put a box among those that wait."""
    scratch.levels[top], scratch.boxes[top], scratch.waiting[top] = level, box, gap


@compiled
def nearest_triangles(
    shape: Floats, tree: Tree, lanes: LaneTree, q: Vector, extent: float, scratch: PointScratch
) -> int:
    """Find the nearest triangles to q; return how many, or FULL.

    They are the scratch's first, in no order, and no other is as near, to rounding. Boxes and
    triangles farther than the nearest so far, by more than rounding, are left out. The nearest box
    of each group is examined first, the others wait.
    """
    best, count, top = math.inf, 0, 0
    level, group = 0, 0
    while True:
        at = lanes.boxes + BOX_LANES * (scratch.firsts[level] + group)
        limit = best + 2.0 * same_at(best, extent)
        bits, nearest = near_boxes(shape, at, q, limit, scratch.gaps)
        if level == 0:
            bits &= (1 << min(boxes_in(lanes.blocks, lanes.levels, 0), LANES)) - 1
        others = bits & ~(1 << nearest)
        while others != 0:
            lane = lowest(others)
            others &= others - 1
            _put(top, level, LANES * group + lane, scratch.gaps[lane], scratch)
            top += 1
        if bits >> nearest & 1:
            _put(top, level, LANES * group + nearest, scratch.gaps[nearest], scratch)
            top += 1
        while True:
            if top == 0:
                return _without_farther(scratch, count, best + same_at(best, extent))
            top -= 1
            if scratch.waiting[top] > best + 2.0 * same_at(best, extent):
                continue
            level, group = scratch.levels[top] + 1, scratch.boxes[top]
            if level < lanes.levels:
                break
            best, count = _examine_block(
                shape, tree, lanes, group, q, extent, (best, count), scratch
            )
            if count == FULL:
                return FULL
