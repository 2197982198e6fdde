"""Whether a core or a solid is within reach of a solid, before it is asked how near.

Bodies are given as in ``distance``. A walk that leaves out what is beyond a limit sees others for
another limit, and each leaf is begun from where the last one ended: last digits would depend on
what was asked. So a limit only decides whether there is an answer.
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
    room_for_blocks,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import SolidPair, first_of_leaf
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating


@allocating
def least_beyond(pair: SolidPair, n: Vector, limit: float) -> float:
    """Return what surfaces are apart at least [m] if that is beyond a limit, else -infinity."""
    A, B, p = blocks_of(pair)
    path, top, least, is_core = walk(A, B, p), 1, math.inf, A.kind != SOLID
    room = room_for_blocks()
    while True:
        top, i, j, skipped = next_leaves(A, B, p, path, top, limit)
        least = min(least, skipped)
        if i < 0:
            return least
        gap = gap_of_blocks(pair, i, j, room)
        if gap > limit:
            least = min(least, gap)
            continue
        first, start = first_of_leaf(A.tree, i), first_of_leaf(B.tree, j)
        for k in range(first, first_of_leaf(A.tree, i + 1)):
            mine = leaf_in_block(pair, k, first, room)
            for m in range(start, first_of_leaf(B.tree, j + 1)):
                gap = room[m - start, BEGIN] - room[k - first, END]
                if gap <= limit:
                    gap = gap_of_leaves(mine, leaf_of_B(B, m), is_core)
                if gap <= limit:
                    found = separation_of_leaves(pair, k, m, n, limit)
                    if found.end == OVERLAP:
                        return -math.inf
                    if found.end != BEYOND_CUTOFF and found.lower <= limit:
                        return -math.inf
                    gap = found.lower
                least = min(least, gap)


@allocating
def nearest_within(pair: SolidPair, n: Vector, limit: float, touch: float) -> Nearest:
    """Return what ``nearest`` does without a limit, or that all is beyond one [m]."""
    if limit < math.inf:
        least = least_beyond(pair, n, limit)
        if least > limit:
            return Nearest(BEYOND_CUTOFF, math.inf, least, n, pair.p, pair.p, True)
    return nearest(pair, n, math.inf, touch)
