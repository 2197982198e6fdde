"""Branch and bound over the trees of one or two maps, for the nearest or deepest cells.

Leaves that may contain the best cells are examined, see ``leaves``. Answers do not depend on
earlier queries or on the order of the walk.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import DISTANCE, PAIR_WIDTH
from drake_geom_ros.geometry._proximity.kernels.sensed.bodies import (
    Between,
    MapBody,
    MapPair,
    between,
    box_of_node,
    least_apart,
    noise_of,
)
from drake_geom_ros.geometry._proximity.kernels.sensed.leaves import (
    LEAST,
    OTHER,
    PLANE,
    SKIPPED,
    LeafScratch,
    look_at_leaves,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import MOST_IN_LEAF, is_leaf
from drake_geom_ros.geometry._proximity.kernels.vectors import norm
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined

# Depth of a walk's stack: each step replaces one pair of nodes by two, and trees of 2^40 leaves do
# not fit into memory.
DEEPEST = 96


class Path(NamedTuple):
    """The stack of a walk: pairs of nodes (k, 2), and lower bounds of their distances [m]."""

    stack: Indices
    least: Floats


@inlined
def _cuts_B(A: MapBody, B: MapBody, i: int, j: int) -> bool:
    """Return whether B's node j is split instead of A's node i."""
    if is_leaf(A.tree, i) or is_leaf(B.tree, j):
        return is_leaf(A.tree, i)
    return norm(box_of_node(B, j).half) >= norm(box_of_node(A, i).half)


@inlined
def _push_children(
    pair: MapPair, at: Between, nodes: tuple[int, int], path: Path, top: int, limit: float
) -> int:
    """Split a pair of nodes, not both leaves, and push the two pairs, the nearer one last."""
    A, B = pair.A, pair.B
    i, j = nodes
    cut_B = _cuts_B(A, B, i, j)
    for turn in range(2):
        child_A = i if cut_B else 2 * i + 1 + turn
        child_B = 2 * j + 1 + turn if cut_B else j
        path.stack[top + turn, 0], path.stack[top + turn, 1] = child_A, child_B
        boxes = box_of_node(A, child_A), box_of_node(B, child_B)
        path.least[top + turn] = least_apart(at, boxes[0], boxes[1], limit)
    if path.least[top] < path.least[top + 1]:
        for k in range(2):
            path.stack[top, k], path.stack[top + 1, k] = path.stack[top + 1, k], path.stack[top, k]
        path.least[top], path.least[top + 1] = path.least[top + 1], path.least[top]
    return top + 2


@allocating
def find_nearest(pair: MapPair, p: Vector, cutoff: float, nearest: Floats) -> None:
    """Write the nearest, or deepest, leaves into ``nearest`` (NEAREST_WIDTH,).

    ``p`` [m] is Bo from Ao in World axes. For leaves beyond the cutoff [m] only a lower bound is
    written; DISTANCE is infinite if there are no others.

    No better leaves are pruned: a pair of nodes is pruned only if a lower bound of all leaves
    below is beyond the best one. Otherwise it is replaced by its two halves.
    """
    nearest[:] = 0.0
    nearest[DISTANCE] = nearest[OTHER] = nearest[LEAST] = nearest[SKIPPED] = math.inf
    nearest[PLANE + 3] = math.inf
    path = Path(np.zeros((DEEPEST, 2), np.int64), np.empty(DEEPEST))
    scratch = LeafScratch(np.zeros((2, PAIR_WIDTH)), np.empty(MOST_IN_LEAF * MOST_IN_LEAF))
    noise, at = noise_of(pair), between(pair, p)
    path.least[0], top = -math.inf, 1
    while top > 0:
        top -= 1
        nodes = path.stack[top, 0], path.stack[top, 1]
        limit = min(cutoff, nearest[DISTANCE]) + noise
        if path.least[top] > limit:
            nearest[SKIPPED] = min(nearest[SKIPPED], path.least[top] - noise)
        elif is_leaf(pair.A.tree, nodes[0]) and is_leaf(pair.B.tree, nodes[1]):
            look_at_leaves(pair, at, nodes, p, cutoff, nearest, scratch)
        else:
            top = _push_children(pair, at, nodes, path, top, limit)
