"""Distance of a core or a solid from a solid's surface: branch and bound over trees of boxes.

A is a ``TreeBody`` and B a ``Solid``, and A's origin is at p in B. Points are measured from Bo and
expressed in B's axes; n points from A towards B.
"""

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF, CLOSED, OVERLAP
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import width_of_hulls
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import (
    gap_of_leaves,
    gap_over_planes,
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
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    SolidPair,
    first_of_leaf,
    noise_of,
)
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kernels.vectors import dot, scale
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

TOUCHING = 4  # an end, beside those of GJK
NEVER = -math.inf  # of ``touch``: what touches does not end the walk


class Nearest(NamedTuple):
    """The nearest points a and b of the surfaces of A's core and of B, with n from a to b.

    ``lower <= distance <= upper = |b - a|``. End BEYOND_CUTOFF: farther apart than the limit, and
    only ``lower`` is meaningful. End OVERLAP: they cross, and the rest is meaningless. End
    TOUCHING: they are no farther apart than ``touch``, or cross. ``unique`` is False if other
    points are as near, along a clearly different n.
    """

    end: int
    upper: float
    lower: float
    n: Vector
    a: Vector
    b: Vector
    unique: bool


@compiled
def is_wider(pair: SolidPair, n: Vector, other: Vector) -> bool:
    """Return whether the hulls overlap less along n than along another direction.

    Of walls that are in line and floors that lie on each other, the floors are in contact.
    """
    along, across = scale(-1.0, n), scale(-1.0, other)
    return width_of_hulls(pair, along, 0.0) < width_of_hulls(pair, across, 0.0)


@allocating
def nearest(pair: SolidPair, n: Vector, limit: float, touch: float) -> Nearest:
    """Return the nearest points of the surfaces of A's core and of B.

    Nothing nearer is missed: what is left out, by boxes or within a leaf by GJK, is beyond the
    limit, or farther than the best so far by more than ``noise``, which bounds rounding. The least
    of what was left out is in ``lower``: with ``noise`` added to the error it is a certificate. No
    crossing is missed, if the limit is ``noise`` or more: boxes of leaves that cross have a
    separation of 0, to rounding, and no best is below 0. Of faces as near as the nearest, along
    about the same direction, one is enough. The first leaves that are no farther apart than
    ``touch`` end the walk.
    """
    A, B, p = blocks_of(pair)
    noise, cutoff, is_core = noise_of(pair), limit, A.kind != SOLID
    scratch = scratch_for_blocks()
    path, top = walk(A, B, p), 1
    best, least, a, b, unique = math.inf, math.inf, p, p, True
    n_best = n
    while True:
        top, i, j, skipped = next_leaves(A, B, p, path, top, limit)
        least = min(least, skipped)
        if i < 0:
            break
        gap = gap_of_blocks(pair, i, j, scratch)
        if gap > limit:
            least = min(least, gap)
            continue
        first, start = first_of_leaf(A.tree, i), first_of_leaf(B.tree, j)
        for k in range(first, first_of_leaf(A.tree, i + 1)):
            leaf_A = leaf_in_block(pair, k, first, scratch)
            for m in range(start, first_of_leaf(B.tree, j + 1)):
                gap, is_same_face = scratch[m - start, BEGIN] - scratch[k - first, END], False
                if gap > limit:
                    least = min(least, gap)
                    continue
                leaf_B = leaf_of_B(B, m)
                gap = gap_of_leaves(leaf_A, leaf_B, is_core)
                if gap <= limit:
                    gap, along = gap_over_planes(pair, leaf_A, leaf_B)
                    is_same_face = gap > best - noise and dot(along, n_best) >= SAME_DIRECTION
                if is_same_face or gap > limit:
                    least = min(least, gap)
                    continue
                end, upper, lower, n, x, y, _ = separation_of_leaves(pair, k, m, n_best, limit)
                if end == OVERLAP:
                    return Nearest(OVERLAP, upper, lower, n, x, y, True)
                if upper <= touch and end != BEYOND_CUTOFF:
                    return Nearest(TOUCHING, upper, min(lower, 0.0), n, x, y, True)
                least = min(least, lower)
                if end == BEYOND_CUTOFF:
                    continue
                if upper < best - noise:
                    nearer, unique = True, True
                elif upper > best + noise:
                    continue
                elif dot(n, n_best) < SAME_DIRECTION:
                    nearer, unique = best <= noise and is_wider(pair, n, n_best), False
                else:
                    nearer = upper < best
                best = min(best, upper)
                limit = min(limit, best + noise)
                if nearer:
                    n_best, a, b = n, x, y
    # Omitted pairs are farther than the cutoff; the best pair may be farther too.
    end = CLOSED if best < math.inf and least <= cutoff else BEYOND_CUTOFF
    return Nearest(end, best, min(least, best), n_best, a, b, unique)
