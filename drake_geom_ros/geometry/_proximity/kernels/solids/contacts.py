"""Leaves of A and B in contact, and the ways out of B that they ask for.

Bodies are given as in ``distance``.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import CLOSED, OVERLAP, support_points
from drake_geom_ros.geometry._proximity.kernels.cores.records import Separation
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import (
    gap_of_leaves,
    leaf_of_A,
    leaf_of_B,
    leaf_pair,
    separation_of_leaves,
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
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

# Columns of a row of pushes: out along a unit vector, by how much [m].
PUSH_WAY = 0  # 3
PUSH_LENGTH = 3
PUSH_WIDTH = 4

MOST_TURNS = 24  # of ``aside_of``
STEEPEST_ASIDE = 0.05  # cosine of the step that it takes and a way that asks for one


@compiled
def push_out(pair: SolidPair, i: int, j: int, found: Separation) -> tuple[Vector, float]:
    """Return (m, s): moving A by s along the unit m takes it, as far as these leaves go, out of B.

    ``found`` is their ``separation_of_leaves``. Where the leaves cross, m is the normal of B's
    triangle and all of A's core, or A's triangle, is lifted over its plane; else m is from b to a.
    """
    if found.end != OVERLAP:
        return scale(-1.0, found.n), pair.radius - found.upper
    m = normal_of(pair.B.shape, pair.B.tree, j)
    a, b = support_points(leaf_pair(pair.A, i, pair.B, j, pair.p), scale(-1.0, m), 0.0)
    return m, dot(sub(b, a), m) + pair.radius


@allocating
def close_pairs(pair: SolidPair, n: Vector, cutoff: float, pairs: Indices) -> int:
    """Fill ``pairs`` (k, 2) with leaves of A and of B within ``cutoff``; return how many.

    Whoever asks has room for as many as matter; the rest is left out: they are where to begin, and
    no answer rests on there being no more.
    """
    A, B, p = pair.A, pair.B, pair.p
    limit, is_core = cutoff + noise_of(pair), A.kind != SOLID
    path, top = walk(A, B, p), 1
    count = 0
    while True:
        top, i, j, _ = next_leaves(A, B, p, path, top, cutoff)
        if i < 0:
            return count
        for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
            mine = leaf_of_A(pair, k)
            for t in range(first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)):
                if gap_of_leaves(mine, leaf_of_B(B, t), is_core) > limit:
                    continue
                found = separation_of_leaves(pair, k, t, n, limit)
                if found.end == OVERLAP or (found.end == CLOSED and found.upper <= cutoff):
                    pairs[count, 0], pairs[count, 1] = k, t
                    count += 1
                    if count == pairs.shape[0]:
                        return count


@allocating
def contacts(pair: SolidPair, n: Vector, reach: float, slots: Floats, most: int) -> int:
    """Fill ``slots`` (k, PUSH_WIDTH) with pushes of distinct directions; return how many.

    At most ``most`` pairs of leaves are looked at, no farther apart than ``reach`` [m] beside the
    radius; a slot keeps the longest push along its direction.
    """
    pairs = np.empty((most, 2), dtype=np.int64)
    count, limit = 0, pair.radius + reach
    for k in range(close_pairs(pair, n, limit, pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        found = separation_of_leaves(pair, i, j, n, limit + noise_of(pair))
        m, s = push_out(pair, i, j, found)
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
