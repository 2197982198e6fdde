"""Lower bounds of the distance of two geometries, from their boxes and balls."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.broadphase import box_gap, plane_gap
from drake_geom_ros.geometry._proximity.compiled import inlined
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.pose_rounding import RADIUS
from drake_geom_ros.geometry._proximity.tolerances import EPS, LARGE_SQUARE


@inlined
def gap_of_boxes(i, j, types, R_WGs, p_WGs, roundings, half_extents):  # type: ignore[no-untyped-def]
    """Return a lower bound of the distance [m] of the boxes of i and j; a half space is one."""
    if types[i] == HALF_SPACE:
        return plane_gap(R_WGs, p_WGs, roundings, half_extents, i, j)
    if types[j] == HALF_SPACE:
        return plane_gap(R_WGs, p_WGs, roundings, half_extents, j, i)
    return box_gap(p_WGs, half_extents, i, j)


@inlined
def gap_of_balls(i, j, p_WGs, roundings, outer):  # type: ignore[no-untyped-def]
    """Return a lower bound of the distance [m] of the balls around i and j."""
    squared = 0.0
    for k in range(3):
        apart = p_WGs[j, k] - p_WGs[i, k]
        squared += apart * apart
    if not squared < LARGE_SQUARE:
        return -math.inf  # so large that boxes have to tell
    centres, balls = math.sqrt(squared), outer[i] + outer[j]
    rounding = roundings[i, RADIUS] + roundings[j, RADIUS]
    return centres - balls - rounding - 8.0 * EPS * (centres + balls)


@inlined
def gap_of_bounds(i, j, types, R_WGs, p_WGs, roundings, half_extents, outer):  # type: ignore[no-untyped-def]
    """Return a lower bound of the distance [m] by boxes and balls."""
    # The ball of a half space has no bound, and its gap is minus infinity.
    boxes = gap_of_boxes(i, j, types, R_WGs, p_WGs, roundings, half_extents)
    return max(boxes, gap_of_balls(i, j, p_WGs, roundings, outer))


@inlined
def apart(p_WGs, a, b):  # type: ignore[no-untyped-def]
    """Return no less than the distance [m] of two origins, what no square overflows."""
    x, y, z = (p_WGs[b, 0] - p_WGs[a, 0], p_WGs[b, 1] - p_WGs[a, 1], p_WGs[b, 2] - p_WGs[a, 2])
    return abs(x) + abs(y) + abs(z)
