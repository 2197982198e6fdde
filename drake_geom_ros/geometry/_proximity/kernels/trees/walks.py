"""Walks over two trees at once, the nearest pair of nodes first."""

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


# Of a walk: each step takes one pair of nodes away and puts two back, and trees of 2^40 leaves do
# not fit into memory.
DEEPEST = 96


@inlined
def is_leaf(tree: NodeTree, k: int) -> bool:
    """Tell whether node k is a leaf; leaf number k - (leaves - 1)."""
    return k >= tree.leaves - 1


@compiled
def push_children(
    A: TurnedTreeOwner, B: TreeOwner, p: Vector, i: int, j: int, path: Walk, top: int
) -> int:
    """Push the two pairs that a pair of nodes, not both leaves, is cut into, the nearer last."""
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
        # The second first, if it is the farther one.
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
    """Go on to the next pair of leaves within ``limit``; return (top, i, j, skipped).

    ``top`` pairs are left on the stack. i and j number the leaves, and are -1 when none are left;
    ``skipped`` is the least separation [m] of what was left out, which is beyond the limit.

    No leaves within the limit are left out: a pair of nodes is put aside only if its separation, a
    lower bound of that of all leaves below, is beyond it, and otherwise it is one of leaves, and
    handed out, or both its halves take its place. The limit may shrink from call to call.
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
