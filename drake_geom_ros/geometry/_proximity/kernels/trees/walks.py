"""Simultaneous walks over two trees, the nearest pair of nodes first."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.trees.boxes import (
    NodeTree,
    TreeOwner,
    TurnedTreeOwner,
    box_at,
    box_of_node,
    separation_of_turned_boxes,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import norm
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Walk(NamedTuple):
    """The stack of a walk over two trees: pairs of nodes (k, 2), and their separations [m]."""

    stack: Indices
    separations: Floats


# Depth of a walk's stack: each step replaces one pair of nodes by two, and trees of 2^40 leaves do
# not fit into memory.
DEEPEST = 96


@inlined
def is_leaf(tree: NodeTree, k: int) -> bool:
    """Return whether node k is a leaf; its leaf number is k - (leaves - 1)."""
    return k >= tree.leaves - 1


@compiled
def push_children(
    A: TurnedTreeOwner, B: TreeOwner, p: Vector, i: int, j: int, path: Walk, top: int
) -> int:
    """Split a pair of nodes, not both leaves, and push the two pairs, the nearer one last."""
    cut_B = is_leaf(A.tree, i)
    if not cut_B and not is_leaf(B.tree, j):
        cut_B = norm(box_of_node(B.shape, B.tree, j).half) >= norm(box_at(A, i).half)
    if cut_B:
        box = box_at(A, i)
        first = separation_of_turned_boxes(box, A.R, p, box_of_node(B.shape, B.tree, 2 * j + 1))
        second = separation_of_turned_boxes(box, A.R, p, box_of_node(B.shape, B.tree, 2 * j + 2))
    else:
        box = box_of_node(B.shape, B.tree, j)
        first = separation_of_turned_boxes(box_at(A, 2 * i + 1), A.R, p, box)
        second = separation_of_turned_boxes(box_at(A, 2 * i + 2), A.R, p, box)
    for turn in range(2):
        # The farther pair is pushed first.
        k = 1 - turn if second >= first else turn
        path.stack[top, 0] = i if cut_B else 2 * i + 1 + k
        path.stack[top, 1] = 2 * j + 1 + k if cut_B else j
        path.separations[top] = second if k == 1 else first
        top += 1
    return top


@allocating
def walk(A: TurnedTreeOwner, B: TreeOwner, p: Vector) -> Walk:
    """Return the walk that begins at the pair of roots."""
    stack, separations = np.zeros((DEEPEST, 2), dtype=np.int64), np.empty(DEEPEST)
    separations[0] = separation_of_turned_boxes(
        box_at(A, 0), A.R, p, box_of_node(B.shape, B.tree, 0)
    )
    return Walk(stack, separations)


@compiled
def next_leaves(
    A: TurnedTreeOwner, B: TreeOwner, p: Vector, path: Walk, top: int, limit: float
) -> tuple[int, int, int, float]:
    """Advance to the next pair of leaves within ``limit``; return (top, i, j, skipped).

    ``top`` pairs remain on the stack. i and j are leaf numbers, or -1 when none remain.
    ``skipped`` is the least separation [m] of pruned pairs, which is beyond the limit.

    No leaves within the limit are pruned: a pair of nodes is pruned only if its separation, a
    lower bound of that of all leaves below, is beyond the limit. Otherwise it is a pair of leaves,
    which is returned, or it is replaced by its two halves. The limit may shrink from call to call.
    """
    skipped = math.inf
    while top > 0:
        top -= 1
        i, j = path.stack[top, 0], path.stack[top, 1]
        if path.separations[top] > limit:
            skipped = min(skipped, path.separations[top])
        elif is_leaf(A.tree, i) and is_leaf(B.tree, j):
            return top, i - (A.tree.leaves - 1), j - (B.tree.leaves - 1), skipped
        else:
            top = push_children(A, B, p, i, j, path, top)
    return top, -1, -1, skipped
