"""Promised width of the certified bounds of an answer, at each accuracy.

This is the one rule, for kernels and for their checks: the accuracy [m] plus rounding. At
``exact`` and below it is relative to the radius of the smaller body, up to 1 m. Answers from
bounds alone (BOUND_ONLY) and of overlapping solids promise no width, only that their bounds hold.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import DISTANCE, ERROR_BOUND
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.tolerances import (
    COARSEST_GAP,
    EPS,
    PROMISED_ROUNDING,
    TOUCHING_DEPTH,
    UNSEEN_DEPTH,
)
from drake_geom_ros.geometry._proximity.world.pose_rounding import RADIUS, TILT


@inlined
def size_of_pair(a: int, b: int, types: Indices, outer: Floats) -> float:
    """Return the size of a pair [m], the sum of its outer radii; a half space counts as 0."""
    size = 0.0 if types[a] == HALF_SPACE else outer[a]
    return size if types[b] == HALF_SPACE else size + outer[b]


@inlined
def tolerance_of_pair(level_gap: float, a: int, b: int, outer: Floats) -> float:
    """Return the gap [m] between the bounds of a pair that iterations aim for.

    It is absolute for bodies of one metre or more, and relative to the smaller body below, and at
    most COARSEST_GAP, so that no accuracy hides a contact.
    """
    return min(level_gap, COARSEST_GAP) * min(1.0, outer[a], outer[b])


@inlined
def rounding_of_pair(a: int, b: int, extent: float, roundings: Floats) -> float:
    """Return the rounding error of the pair's world poses [m]; see ``pose_rounding``.

    ``extent`` [m] is the size of the pair plus the distance of the origins. No point of a body is
    farther than that from the origin of a half space.
    """
    rounding = roundings[a, RADIUS] + roundings[b, RADIUS]
    tilt = roundings[a, TILT] + roundings[b, TILT]
    return rounding + tilt * extent if tilt > 0.0 else rounding


@inlined
def hides_contact(out: Floats, a: int, b: int, extent: float, roundings: Floats) -> bool:
    """Return whether a pair may overlap while rounding hides more than UNSEEN_DEPTH."""
    hidden = max(TOUCHING_DEPTH * extent, rounding_of_pair(a, b, extent, roundings))
    return hidden > UNSEEN_DEPTH and out[DISTANCE] < out[ERROR_BOUND]


@inlined
def promised_error_bound(
    level_gap: float,
    a: int,
    b: int,
    types: Indices,
    outer: Floats,
    p_WGs: Floats,
    roundings: Floats,
) -> float:
    """Return the largest error bound [m] that keeps the promise of an accuracy.

    Up to COARSEST_GAP this is the gap that iterations aim for, and else the length itself.
    """
    squared = 0.0
    for k in range(3):
        apart = p_WGs[b, k] - p_WGs[a, k]
        squared += apart * apart
    extent = size_of_pair(a, b, types, outer) + math.sqrt(squared)
    rounding = PROMISED_ROUNDING * EPS * extent + rounding_of_pair(a, b, extent, roundings)
    aimed = tolerance_of_pair(level_gap, a, b, outer)
    return (aimed if level_gap <= COARSEST_GAP else level_gap) + rounding
