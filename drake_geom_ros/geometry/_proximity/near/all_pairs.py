"""Brute-force broad phase, for few bodies and for unlimited queries."""

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
    """Return a coordinate, or 0 for one too large to be an origin."""
    return value if abs(value) < SINGLE_LARGEST else 0.0


@inlined
def _set_side(near: ListArrays, g: int, cutoff: float) -> None:
    """Write the sides of a box, with the lower ones extended by the cutoff [m].

    They are measured from ORIGIN, so they retain their digits far from World's origin. A plane
    extends everywhere.
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
    """Return whether two boxes are within a cutoff [m] along each axis.

    Corners and their sums with the cutoff are rounded, each by at most half a spacing of numbers
    that are about as large in the decisive cases.
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
    """Return whether two bodies whose rounded boxes overlap are a candidate pair."""
    if frames[i] == 0 and frames[k] == 0:
        return False
    if near.is_plane[i] or near.is_plane[k]:
        return not (near.is_plane[i] and near.is_plane[k])
    return math.isinf(cutoff) or _are_within(near.lowers, near.uppers, i, k, cutoff)


@inlined
def _look_at_one(near: ListArrays, world: WorldArrays, i: int, cutoff: float, count: int) -> int:
    """Append the codes of pairs of i with later bodies; return the number of codes."""
    n, box = near.is_plane.size, box_at(near.sides, i)
    for first in range(i + 1, n, LANES):
        bits = overlapping(near.sides, first, box) & first_lanes(n - first)
        while bits != 0:
            k = first + lowest(bits)
            bits &= bits - 1
            count = put_code(
                near.candidates, count, i, k, _is_pair(near, world.frames, i, k, cutoff)
            )
    return count


@compiled
def look_at_all(near: ListArrays, world: WorldArrays, cutoff: float) -> int:
    """Write the codes of candidate pairs, in order; return their number, even if not all fit.

    Pairs of two anchored bodies and of two planes are omitted. Every body is paired with every
    plane, so planes may move freely.
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
