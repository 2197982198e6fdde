"""Branch and bound over the tree of a map, or over those of two: the nearest, or deepest, cells.

Leaves that may hold the best ones are looked at, see ``leaves``. What was asked before, and the
order of the walk, are in no answer.
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
    Room,
    look_at_leaves,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import MOST_IN_LEAF, is_leaf
from drake_geom_ros.geometry._proximity.kernels.vectors import norm
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined

# Of a walk: each step takes one pair of nodes away and puts two back, and trees of 2^40 leaves do
# not fit into memory.
DEEPEST = 96


class Path(NamedTuple):
    """The stack of a walk: pairs of nodes (k, 2), and lower bounds of their distances [m]."""

    stack: Indices
    least: Floats


@inlined
def _cuts_B(A: MapBody, B: MapBody, i: int, j: int) -> bool:
    """Tell whether it is B's node j that is cut in two, and not A's node i."""
    if is_leaf(A.tree, i) or is_leaf(B.tree, j):
        return is_leaf(A.tree, i)
    return norm(box_of_node(B, j).half) >= norm(box_of_node(A, i).half)


@inlined
def _push_children(
    pair: MapPair, at: Between, nodes: tuple[int, int], path: Path, top: int, limit: float
) -> int:
    """Push the two pairs that a pair of nodes, not both leaves, is cut into, the nearer last."""
    A, B = pair.A, pair.B
    i, j = nodes
    cut_B = _cuts_B(A, B, i, j)
    for turn in range(2):
        mine = i if cut_B else 2 * i + 1 + turn
        its = 2 * j + 1 + turn if cut_B else j
        path.stack[top + turn, 0], path.stack[top + turn, 1] = mine, its
        boxes = box_of_node(A, mine), box_of_node(B, its)
        path.least[top + turn] = least_apart(at, boxes[0], boxes[1], limit)
    if path.least[top] < path.least[top + 1]:
        for k in range(2):
            path.stack[top, k], path.stack[top + 1, k] = path.stack[top + 1, k], path.stack[top, k]
        path.least[top], path.least[top + 1] = path.least[top + 1], path.least[top]
    return top + 2


@allocating
def find_nearest(pair: MapPair, p: Vector, cutoff: float, found: Floats) -> None:
    """Write into ``found`` (FOUND_WIDTH,) which leaves are nearest, or deepest.

    ``p`` [m] is Bo from Ao in World axes. Of leaves beyond the cutoff [m] it is only told what
    they are apart at least; its DISTANCE is infinite where there are no others.

    No leaves that are better are left out: a pair of nodes is put aside only if a lower bound of
    all leaves below is beyond the best one, and otherwise both its halves take its place.
    """
    found[:] = 0.0
    found[DISTANCE] = found[OTHER] = found[LEAST] = found[SKIPPED] = math.inf
    found[PLANE + 3] = math.inf
    path = Path(np.zeros((DEEPEST, 2), np.int64), np.empty(DEEPEST))
    room = Room(np.zeros((2, PAIR_WIDTH)), np.empty(MOST_IN_LEAF * MOST_IN_LEAF))
    noise, at = noise_of(pair), between(pair, p)
    path.least[0], top = -math.inf, 1
    while top > 0:
        top -= 1
        nodes = path.stack[top, 0], path.stack[top, 1]
        limit = min(cutoff, found[DISTANCE]) + noise
        if path.least[top] > limit:
            found[SKIPPED] = min(found[SKIPPED], path.least[top] - noise)
        elif is_leaf(pair.A.tree, nodes[0]) and is_leaf(pair.B.tree, nodes[1]):
            look_at_leaves(pair, at, nodes, p, cutoff, found, room)
        else:
            top = _push_children(pair, at, nodes, path, top, limit)
