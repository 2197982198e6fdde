"""Lower bounds of the distance of two geometries, from their boxes and balls."""

from __future__ import annotations

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE, SOLID, SPHERE
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.tolerances import EPS, LARGE_SQUARE
from drake_geom_ros.geometry._proximity.world.arrays import world_of
from drake_geom_ros.geometry._proximity.world.pose_rounding import RADIUS, TILT


class BoundedBodies(NamedTuple):
    """Poses and bounds of n bodies without their shapes; fields of ``WorldArrays``.

    Constructed in the call that takes it, which costs nothing: see ``narrow_phase.answer_pairs``.
    """

    types: Indices
    R_WGs: Floats
    p_WGs: Floats
    roundings: Floats
    half_extents: Floats
    outer: Floats


@inlined
def separation_of_aabbs(p_WGs: Floats, half_extents: Floats, i: int, j: int) -> float:
    """Return a lower bound of the distance [m] of the AABBs of i and j, 0 where they overlap."""
    squared, farthest, widest = 0.0, 0.0, 0.0
    for k in range(3):
        p, q = p_WGs[i, k], p_WGs[j, k]
        sizes = half_extents[i, k] + half_extents[j, k]
        farthest = max(farthest, abs(p) + abs(q) + sizes)
        separation = abs(p - q) - sizes
        if separation > 0.0:
            squared += separation * separation
            widest = max(widest, separation)
    if squared < LARGE_SQUARE:
        widest = math.sqrt(squared)
    # Rounding of the corners: a few spacings where they are.
    return max(0.0, widest - 4.0 * EPS * farthest)


@inlined
def separation_from_plane(h: int, g: int, bodies: BoundedBodies) -> float:
    """Return a lower bound of the distance [m] of the box around g above the half space h.

    Boxes include the rounding of their poses; that of h is subtracted, see ``pose_rounding``.
    """
    _, R_WGs, p_WGs, roundings, half_extents, _ = bodies
    height, extent, size = 0.0, 0.0, 0.0
    for k in range(3):
        height += R_WGs[h, k, 2] * (p_WGs[g, k] - p_WGs[h, k])
        extent += abs(R_WGs[h, k, 2]) * half_extents[g, k]
        size += abs(p_WGs[g, k]) + abs(p_WGs[h, k]) + half_extents[g, k]
    return height - extent - roundings[h, RADIUS] - (roundings[h, TILT] + 4.0 * EPS) * size


@inlined
def separation_of_boxes(i: int, j: int, bodies: BoundedBodies) -> float:
    """Return a lower bound of the distance [m] of two boxes; a half space counts as a box."""
    if bodies.types[i] == HALF_SPACE:
        return separation_from_plane(i, j, bodies)
    if bodies.types[j] == HALF_SPACE:
        return separation_from_plane(j, i, bodies)
    return separation_of_aabbs(bodies.p_WGs, bodies.half_extents, i, j)


@inlined
def separation_of_balls(i: int, j: int, p_WGs: Floats, roundings: Floats, outer: Floats) -> float:
    """Return a lower bound of the distance [m] of the bounding balls of i and j."""
    squared = 0.0
    for k in range(3):
        apart = p_WGs[j, k] - p_WGs[i, k]
        squared += apart * apart
    if not squared < LARGE_SQUARE:
        return -math.inf  # the square may overflow: boxes have to decide
    centres, balls = math.sqrt(squared), outer[i] + outer[j]
    rounding = roundings[i, RADIUS] + roundings[j, RADIUS]
    return centres - balls - rounding - 8.0 * EPS * (centres + balls)


@inlined
def separation_of_bounds(i: int, j: int, bodies: BoundedBodies, cutoff: float) -> float:
    """Return a lower bound of the distance [m], by balls, then boxes if within the cutoff.

    Without a cutoff no bound is needed, and the result is minus infinity.
    """
    if cutoff == math.inf:
        return -math.inf
    types = bodies.types
    # The ball of a half space is infinite, so its separation is minus infinity.
    balls = separation_of_balls(i, j, bodies.p_WGs, bodies.roundings, bodies.outer)
    round_ones = types[i] == SPHERE and types[j] == SPHERE and balls > -math.inf
    if round_ones or balls > cutoff:
        return balls
    return max(separation_of_boxes(i, j, bodies), balls)


@inlined
def least_possible(i: int, j: int, bodies: BoundedBodies) -> float:
    """Return a lower bound [m] of a signed distance, including that of overlapping bodies.

    The depth of convex bodies is at most the overlap of their projections on any line. So it is at
    most that of their boxes along an axis, or of their balls along the line of the centres.
    """
    types, _, p_WGs, roundings, half_extents, outer = bodies
    separation = separation_of_boxes(i, j, bodies)
    if types[i] == HALF_SPACE or types[j] == HALF_SPACE:
        return separation
    if separation == 0.0:
        if max(types[i], types[j]) >= SOLID:
            return -math.inf  # the hull of a solid or a map does not bound its depth
        separation, farthest = -math.inf, 0.0
        for k in range(3):
            p, q = p_WGs[i, k], p_WGs[j, k]
            sizes = half_extents[i, k] + half_extents[j, k]
            separation, farthest = (
                max(separation, abs(p - q) - sizes),
                max(farthest, abs(p) + abs(q) + sizes),
            )
        separation -= 4.0 * EPS * farthest
    return max(separation, separation_of_balls(i, j, p_WGs, roundings, outer))


@inlined
def apart(p_WGs: Floats, a: int, b: int) -> float:
    """Return an upper bound of the distance [m] of two origins, computed without squares."""
    x, y, z = (p_WGs[b, 0] - p_WGs[a, 0], p_WGs[b, 1] - p_WGs[a, 1], p_WGs[b, 2] - p_WGs[a, 2])
    return abs(x) + abs(y) + abs(z)


@compiled
def near_pairs(pairs: Indices, world: Handle, cutoff: float, hits: Indices) -> int:
    """Write the numbers of the pairs whose boxes are within ``cutoff``; return how many."""
    world, hit_count = world_of(world), 0
    bodies = BoundedBodies(
        world.types,
        world.R_WGs,
        world.p_WGs,
        world.roundings,
        world.half_extents,
        world.outer,
    )
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        if separation_of_boxes(i, j, bodies) <= cutoff:
            hits[hit_count] = k
            hit_count += 1
    return hit_count
