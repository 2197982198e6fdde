"""Contacts of bodies whose inner balls overlap, detected without a neighbour list or a kernel.

The first such pair answers the query whether anything touches. The pair of the last contact
usually still touches. Otherwise some pairs are tested, which takes far less time than a list.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.filters.matrix import may_report
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from drake_geom_ros.geometry._proximity.near.arrays import FilterArrays
from drake_geom_ros.geometry._proximity.near.making import FEW
from drake_geom_ros.geometry._proximity.pairs.error_bounds import promised_error_bound
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import COARSEST_GAP, EPS, PLAIN_DEPTH
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays
from drake_geom_ros.geometry._proximity.world.pose_rounding import RADIUS

# Pairs of each movable body that are tested before the list is used. With few bodies the list
# takes hardly longer.
LOOKS_A_BODY, LOOKS_OF_FEW = 8, 3


@inlined
def _along(world: WorldArrays, a: int, b: int, c: int) -> float:
    """Return the offset [m] between the inner balls of two bodies along an axis of World."""
    p_WGs, R_WGs, centres = world.p_WGs, world.R_WGs, world.ball_centres
    apart = p_WGs[b, c] - p_WGs[a, c]
    if world.types[a] == CONVEX:
        for k in range(3):
            apart -= R_WGs[a, c, k] * centres[a, k]
    if world.types[b] == CONVEX:
        for k in range(3):
            apart += R_WGs[b, c, k] * centres[b, k]
    return apart


@inlined
def _is_plain(world: WorldArrays, a: int, b: int) -> bool:
    """Return whether two convex bodies overlap so deeply that every level reports the pair.

    A translation that separates the bodies separates their inner balls, so these overlap by no
    more than the bodies. Certified answers are off by the promise of ``exact``; the few pairs that
    exceed the promise do so by far less than this fraction of a body.
    """
    radii, outer = world.ball_radii, world.outer
    x, y, z = _along(world, a, b, 0), _along(world, a, b, 1), _along(world, a, b, 2)
    squared, balls = x * x + y * y + z * z, radii[a] + radii[b]
    if not squared < balls * balls or radii[a] == 0.0 or radii[b] == 0.0:
        return False
    apart = math.sqrt(squared)
    rounding = world.roundings[a, RADIUS] + world.roundings[b, RADIUS]
    depth = balls - apart - rounding - 16.0 * EPS * (apart + outer[a] + outer[b])
    if not depth > PLAIN_DEPTH * min(radii[a], radii[b]):
        return False
    # Bounds alone never miss a contact, and iterations go on to this gap at every accuracy.
    bound = promised_error_bound(
        COARSEST_GAP, a, b, world.types, outer, world.p_WGs, world.roundings
    )
    return depth > 2.0 * bound


@inlined
def _may_touch(world: WorldArrays, filters: FilterArrays, a: int, b: int) -> bool:
    """Return whether a pair may be reported: movable, posed and unfiltered."""
    if (world.frames[a] == 0 and world.frames[b] == 0) or world.waiting[a] or world.waiting[b]:
        return False
    i, j = filters.slots[a], filters.slots[b]
    return may_report(filters.bits, filters.bodies, filters.bit_rows, i, j)


@compiled
def quick_contact(
    world: WorldArrays, filters: FilterArrays, last_a: int, last_b: int
) -> tuple[int, int]:
    """Return the rows of a pair that plainly overlaps, or (-1, -1) if none was found.

    ``last_a`` and ``last_b`` are the rows of the last contact, or -1.
    """
    still_overlaps = last_a >= 0 and _is_plain(world, last_a, last_b)
    if still_overlaps and _may_touch(world, filters, last_a, last_b):
        return last_a, last_b
    n = world.types.size
    looks = LOOKS_A_BODY if n > FEW else LOOKS_OF_FEW
    for step in range(1, min(looks, n // 2) + 1):
        for k in range(world.movable.size):
            a = world.movable[k]
            b = (a + step * step) % n  # also pairs far apart in the order of registration
            if a != b and _is_plain(world, a, b) and _may_touch(world, filters, a, b):
                return min(a, b), max(a, b)
    return -1, -1
