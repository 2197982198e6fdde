"""Leaves of A and B in contact, and the separating translations that they suggest.

Bodies are given as in ``distance``.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import CLOSED, OVERLAP, support_points
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import (
    gap_of_leaves,
    leaf_of_B,
    leaf_pair,
    separation_within,
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
    normal_of,
)
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    dot,
    norm,
    scale,
    sub,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

# Columns of a row of pairs of leaves that are close.
LEAF_A = 0
LEAF_B = 1
CROSSES = 2  # 1 where they cross
APART = 3  # how far they are apart [m], along
ALONG = 4  # 3: the unit vector from A to B
CLOSE_WIDTH = 7

# Columns of a row of pushes: out along a unit vector, by how much [m].
PUSH_WAY = 0  # 3
PUSH_LENGTH = 3
PUSH_WIDTH = 4

MOST_TURNS = 24  # of ``aside_of``
STEEPEST_ASIDE = 0.05  # cosine of the step that it takes and of the way of a slot


@compiled
def push_out(pair: SolidPair, close: Floats) -> tuple[Vector, float]:
    """Return (m, s): moving A by s along the unit m takes it, as far as these leaves go, out of B.

    ``close`` is their row of ``close_pairs``. Where they cross, m is the normal of B's triangle
    and all of A's core, or A's triangle, is lifted over its plane; else m is from b to a.
    """
    i, j = int(close[LEAF_A]), int(close[LEAF_B])
    if close[CROSSES] == 0.0:
        return scale(-1.0, vector_at(close, ALONG)), pair.radius - close[APART]
    m = normal_of(pair.B.shape, pair.B.tree, j)
    a, b = support_points(leaf_pair(pair.A, i, pair.B, j, pair.p), scale(-1.0, m), 0.0)
    return m, dot(sub(b, a), m) + pair.radius


@allocating
def close_pairs(pair: SolidPair, n: Vector, cutoff: float, close: Floats) -> int:
    """Fill ``close`` (k, CLOSE_WIDTH) with leaves of A and B within ``cutoff``; return how many.

    What exceeds the caller's array is left out: the rows are where searches begin, and no answer
    depends on their being complete.
    """
    A, B, p = blocks_of(pair)
    limit, is_core = cutoff + noise_of(pair), A.kind != SOLID
    path, top, scratch = walk(A, B, p), 1, scratch_for_blocks()
    count = 0
    while True:
        top, i, j, _ = next_leaves(A, B, p, path, top, cutoff)
        if i < 0:
            return count
        if gap_of_blocks(pair, i, j, scratch) > limit:
            continue
        first, start = first_of_leaf(A.tree, i), first_of_leaf(B.tree, j)
        for k in range(first, first_of_leaf(A.tree, i + 1)):
            leaf_A = leaf_in_block(pair, k, first, scratch)
            for t in range(start, first_of_leaf(B.tree, j + 1)):
                if scratch[t - start, BEGIN] - scratch[k - first, END] > limit:
                    continue
                if gap_of_leaves(leaf_A, leaf_of_B(B, t), is_core) > limit:
                    continue
                separation = separation_within(pair, k, t, n, limit)
                crosses = separation.end == OVERLAP
                if crosses or (separation.end == CLOSED and separation.upper <= cutoff):
                    close[count, LEAF_A], close[count, LEAF_B] = k, t
                    close[count, CROSSES] = 1.0 if crosses else 0.0
                    close[count, APART] = separation.upper
                    for c in range(3):
                        close[count, ALONG + c] = separation.n[c]
                    count += 1
                    if count == close.shape[0]:
                        return count


@allocating
def contacts(pair: SolidPair, n: Vector, reach: float, slots: Floats, most: int) -> int:
    """Fill ``slots`` (k, PUSH_WIDTH) with pushes of distinct directions; return how many.

    At most ``most`` pairs of leaves are examined, no farther apart than ``reach`` [m] beside the
    radius; a slot keeps the longest push along its direction.
    """
    close, count = np.empty((most, CLOSE_WIDTH)), 0
    for k in range(close_pairs(pair, n, pair.radius + reach, close)):
        m, s = push_out(pair, close[k])
        if s > -reach and dot(m, m) > 0.5:
            count = add_slot(slots, count, m, s)
    return count


@compiled
def add_slot(slots: Floats, count: int, m: Vector, s: float) -> int:
    """Put a push into the slot of its direction, or into a new one while there is room."""
    for k in range(count):
        if dot(vector_at(slots[k], PUSH_WAY), m) >= SAME_DIRECTION:
            slots[k, PUSH_LENGTH] = max(slots[k, PUSH_LENGTH], s)
            return count
    if count < slots.shape[0]:
        for c in range(3):
            slots[count, PUSH_WAY + c] = m[c]
        slots[count, PUSH_LENGTH] = s
        count += 1
    return count


@compiled
def aside_of(slots: Floats, count: int, length: float) -> tuple[bool, Vector]:
    """Return (is_found, t): a step that goes at least ``length`` [m] along the way of each slot.

    A sum of ways, to which the one that is the least along it is added, turn after turn (the
    perceptron). Where they surround A, as the walls of a slot do, there is none.
    """
    v = (0.0, 0.0, 0.0)
    for k in range(count):
        v = add_scaled(v, 1.0, vector_at(slots[k], PUSH_WAY))
    for _ in range(MOST_TURNS):
        least, worst = 2.0 * norm(v) + 1.0, 0
        for k in range(count):
            along = dot(v, vector_at(slots[k], PUSH_WAY))
            if along < least:
                least, worst = along, k
        if least > STEEPEST_ASIDE * norm(v):
            return count > 0, scale(length / least, v)
        v = add_scaled(v, 1.0, vector_at(slots[worst], PUSH_WAY))
    return False, v
