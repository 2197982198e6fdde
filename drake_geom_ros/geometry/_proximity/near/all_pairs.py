"""Which boxes are near, by a look at each pair: for few bodies, or where all are asked for."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.near.arrays import ORIGIN, ListArrays
from drake_geom_ros.geometry._proximity.near.box_lanes import (
    LANES,
    above,
    below,
    box_at,
    first_lanes,
    lowest,
    overlapping,
)
from drake_geom_ros.geometry._proximity.near.grids import put_code
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import EPS, SINGLE_LARGEST
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays


@inlined
def _finite(value: float) -> float:
    """Return a coordinate, or 0 for one that is too large to measure from."""
    return value if abs(value) < SINGLE_LARGEST else 0.0


@inlined
def _set_side(near: ListArrays, g: int, cutoff: float) -> None:
    """Write the sides of a box, of which the lower ones are out by the cutoff [m].

    They are measured from ORIGIN, for far from World's they keep their digits so. A plane is
    everywhere.
    """
    for c in range(3):
        origin, lower, upper = near.lengths[ORIGIN + c], near.lowers[g, c], near.uppers[g, c]
        if near.is_plane[g]:
            lower, upper = -math.inf, math.inf
        rounding = 8.0 * EPS * (abs(lower) + abs(upper) + abs(origin) + cutoff)
        near.sides[c, g] = below((lower - origin) - cutoff - rounding)
        near.sides[3 + c, g] = above((upper - origin) + rounding)


@inlined
def _are_within(lowers: Floats, uppers: Floats, i: int, k: int, cutoff: float) -> bool:
    """Tell whether two boxes are within a cutoff [m] along each axis.

    Corners are rounded, and the sums of them and the cutoff: each by half a spacing at most, of
    numbers that where it matters are about as large.
    """
    far, within = cutoff, True
    for c in range(3):
        far += abs(lowers[i, c]) + abs(uppers[i, c])
    limit = cutoff + 16.0 * EPS * far
    for c in range(3):
        within &= (lowers[k, c] - limit <= uppers[i, c]) & (lowers[i, c] - limit <= uppers[k, c])
    return within


@inlined
def _is_pair(near: ListArrays, frames: Indices, i: int, k: int, cutoff: float) -> bool:
    """Tell whether two bodies whose rounded boxes overlap are a pair of the list."""
    if frames[i] == 0 and frames[k] == 0:
        return False
    if near.is_plane[i] or near.is_plane[k]:
        return not (near.is_plane[i] and near.is_plane[k])
    return math.isinf(cutoff) or _are_within(near.lowers, near.uppers, i, k, cutoff)


@inlined
def _look_at_one(near: ListArrays, world: WorldArrays, i: int, cutoff: float, count: int) -> int:
    """Append the codes of the pairs of i with those behind it; return how many there are."""
    n, box = near.is_plane.size, box_at(near.sides, i)
    for first in range(i + 1, n, LANES):
        bits = overlapping(near.sides, first, box) & first_lanes(n - first)
        while bits != 0:
            k = first + lowest(bits)
            bits &= bits - 1
            count = put_code(near.found, count, i, k, _is_pair(near, world.frames, i, k, cutoff))
    return count


@compiled
def look_at_all(near: ListArrays, world: WorldArrays, cutoff: float) -> int:
    """Fill in the codes of near pairs, in order; return how many there are, beyond the room too.

    ``near`` is a ``ListArrays``. Those of two anchored bodies, or of two planes, are left out;
    every body is paired with every plane, so that these may move freely.
    """
    n, count = near.is_plane.size, 0
    if n == 0:
        return 0
    for c in range(3):
        near.lengths[ORIGIN + c] = _finite(near.lowers[0, c])
    for g in range(n):
        _set_side(near, g, cutoff)
    for i in range(n):
        count = _look_at_one(near, world, i, cutoff, count)
    return count
