"""A test whether a core or a solid is within reach of a solid, before their distance is computed.

Bodies are given as in ``distance``. A walk that leaves out what is beyond a limit examines other
leaves for another limit, and each leaf begins where the last one ended: last digits would depend
on the limit. So a limit only decides whether there is an answer.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF, OVERLAP
from drake_geom_ros.geometry._proximity.kernels.solids.distance import Nearest, nearest
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import (
    gap_of_leaves,
    leaf_of_B,
    separation_of_leaves,
)
from drake_geom_ros.geometry._proximity.kernels.solids.slabs import (
    BEGIN,
    END,
    blocks_of,
    gap_of_blocks,
    leaf_in_block,
    scratch_for_blocks,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import SolidPair, first_of_leaf
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating


@allocating
def least_beyond(pair: SolidPair, n: Vector, limit: float) -> float:
    """Return a lower bound [m] of the surfaces' distance if beyond a limit, else -infinity."""
    A, B, p = blocks_of(pair)
    path, top, least, is_core = walk(A, B, p), 1, math.inf, A.kind != SOLID
    scratch = scratch_for_blocks()
    while True:
        top, i, j, skipped = next_leaves(A, B, p, path, top, limit)
        least = min(least, skipped)
        if i < 0:
            return least
        gap = gap_of_blocks(pair, i, j, scratch)
        if gap > limit:
            least = min(least, gap)
            continue
        first, start = first_of_leaf(A.tree, i), first_of_leaf(B.tree, j)
        for k in range(first, first_of_leaf(A.tree, i + 1)):
            leaf_A = leaf_in_block(pair, k, first, scratch)
            for m in range(start, first_of_leaf(B.tree, j + 1)):
                gap = scratch[m - start, BEGIN] - scratch[k - first, END]
                if gap <= limit:
                    gap = gap_of_leaves(leaf_A, leaf_of_B(B, m), is_core)
                if gap <= limit:
                    separation = separation_of_leaves(pair, k, m, n, limit)
                    if separation.end == OVERLAP:
                        return -math.inf
                    if separation.end != BEYOND_CUTOFF and separation.lower <= limit:
                        return -math.inf
                    gap = separation.lower
                least = min(least, gap)


@allocating
def nearest_within(pair: SolidPair, n: Vector, limit: float, touch: float) -> Nearest:
    """Return what ``nearest`` does without a limit, or a bound alone if all is beyond one [m]."""
    if limit < math.inf:
        least = least_beyond(pair, n, limit)
        if least > limit:
            return Nearest(BEYOND_CUTOFF, math.inf, least, n, pair.p, pair.p, True)
    return nearest(pair, n, math.inf, touch)
