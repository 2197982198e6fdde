"""Whether a core or a solid is within reach of a solid, before it is asked how near.

Bodies are given as in ``distance``. A walk that leaves out what is beyond a limit sees others for
another limit, and each leaf is begun from where the last one ended: last digits would depend on
what was asked. So a limit only decides whether there is an answer.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF, OVERLAP
from drake_geom_ros.geometry._proximity.kernels.solids.distance import (
    Nearest,
    nearest,
    separation_of_leaves,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import Solid, TreeBody, first_of_leaf
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating


@allocating
def least_beyond(
    A: TreeBody, B: Solid, p: Vector, n: Vector, size: float, tolerance: float, limit: float
) -> float:
    """Return what surfaces are apart at least [m] if that is beyond a limit, else -infinity."""
    path, top, least = walk(A, B, p), 1, math.inf
    while True:
        top, i, j, skipped = next_leaves(A, B, p, path, top, limit)
        least = min(least, skipped)
        if i < 0:
            return least
        for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
            for m in range(first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)):
                found = separation_of_leaves(A, k, B, m, p, n, size, tolerance, limit)
                if found.end == OVERLAP or (found.end != BEYOND_CUTOFF and found.lower <= limit):
                    return -math.inf
                least = min(least, found.lower)


@allocating
def nearest_within(
    A: TreeBody, B: Solid, p: Vector, n: Vector, size: float, tolerance: float, limit: float
) -> Nearest:
    """Return what ``nearest`` does without a limit, or that all is beyond one [m]."""
    if limit < math.inf:
        least = least_beyond(A, B, p, n, size, tolerance, limit)
        if least > limit:
            return Nearest(BEYOND_CUTOFF, math.inf, least, n, p, p, True)
    return nearest(A, B, p, n, size, tolerance, math.inf)
