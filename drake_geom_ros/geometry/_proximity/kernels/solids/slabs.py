"""Slabs between blocks of triangles of two solids, which exclude most pairs of triangles.

A *block* is the triangles of two leaves of a tree. The ends of each triangle along one axis are
computed once and serve every pair, where a pair for itself costs as much as both blocks: in solids
that are linked, or fit each other, hundreds of leaves are as near as the nearest, and nearly all
pairs of their triangles are not. Bodies are given as in ``distance``.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.solids.leaves import (
    Leaf,
    around,
    leaf_of_A,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    MOST_IN_LEAF,
    Solid,
    SolidPair,
    Tree,
    TreeBody,
    first_of_leaf,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import box_of_node
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    rotate,
    sub,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined

MOST_IN_BLOCK = 2 * MOST_IN_LEAF

# Columns of the scratch for two blocks: a row for each triangle, from the first of its block on.
PLACED = 0  # 9: corners of A's, in B
END = 9  # of A's along the axis
BEGIN = 10  # of B's
FIRST = 11  # in row 0: the number of A's first triangle, of which corners are there
SCRATCH_WIDTH = 12


@allocating
def scratch_for_blocks() -> Floats:
    """Return scratch (MOST_IN_BLOCK, SCRATCH_WIDTH) for two blocks."""
    scratch = np.zeros((MOST_IN_BLOCK, SCRATCH_WIDTH))
    scratch[0, FIRST] = -1.0
    return scratch


@inlined
def in_blocks(tree: Tree) -> Tree:
    """Return the tree whose leaves are blocks: the same one for one leaf and for a core."""
    if tree.leaves < 2:
        return tree
    nodes, leaves, corners, triangles, pieces_at, pieces, planes_at, planes, boxes_at, boxes = tree
    return Tree(
        nodes,
        leaves // 2,
        corners,
        triangles,
        pieces_at,
        pieces,
        planes_at,
        planes,
        boxes_at,
        boxes,
    )


@allocating
def blocks_of(pair: SolidPair) -> tuple[TreeBody, Solid, Vector]:
    """Return (A, B, p) with blocks as leaves where both are solids."""
    A, B, p = pair.A, pair.B, pair.p
    if A.kind != SOLID:
        return A, B, p
    A = TreeBody(A.kind, A.shape, A.R, in_blocks(A.tree), A.box)
    return A, Solid(B.shape, in_blocks(B.tree), B.identity), p


@inlined
def put_corners(pair: SolidPair, first: int, count: int, scratch: Floats) -> None:
    """Put the corners of A's block into the scratch, unless they are there from the last time."""
    A, R = pair.A, pair.A.R
    if scratch[0, FIRST] == first:
        return
    scratch[0, FIRST] = first
    at = A.tree.corners + CORNERS * first
    for k in range(count):
        for c in range(0, CORNERS, 3):
            corner = add(rotate(R, vector_at(A.shape, at + CORNERS * k + c)), pair.p)
            scratch[k, c], scratch[k, c + 1], scratch[k, c + 2] = corner


@compiled
def _gap_of_blocks(pair: SolidPair, i: int, j: int, scratch: Floats) -> float:
    """Return what ``gap_of_blocks`` does for two solids."""
    A, B = pair.A, pair.B
    tree_A, tree_B = in_blocks(A.tree), in_blocks(B.tree)
    first, start = first_of_leaf(tree_A, i), first_of_leaf(tree_B, j)
    many, more = first_of_leaf(tree_A, i + 1) - first, first_of_leaf(tree_B, j + 1) - start
    put_corners(pair, first, many, scratch)
    middle = add(rotate(A.R, box_of_node(A.shape, tree_A, i + tree_A.leaves - 1).middle), pair.p)
    n = unit(sub(box_of_node(B.shape, tree_B, j + tree_B.leaves - 1).middle, middle))
    end, begin = -math.inf, math.inf
    for k in range(many):
        a, b = vector_at(scratch[k], PLACED), vector_at(scratch[k], PLACED + 3)
        scratch[k, END] = max(dot(a, n), dot(b, n), dot(vector_at(scratch[k], PLACED + 6), n))
        end = max(end, scratch[k, END])
    for m in range(more):
        at = tree_B.corners + CORNERS * (start + m)
        a, b = vector_at(B.shape, at), vector_at(B.shape, at + 3)
        scratch[m, BEGIN] = min(dot(a, n), dot(b, n), dot(vector_at(B.shape, at + 6), n))
        begin = min(begin, scratch[m, BEGIN])
    return begin - end


@inlined
def gap_of_blocks(pair: SolidPair, i: int, j: int, scratch: Floats) -> float:
    """Return a lower bound [m] of the distance of two blocks, and put their ends in ``scratch``.

    Triangle m of B is farther from k of A than BEGIN of row m less END of row k, along the line
    between the middles of their boxes. For a core and a leaf all are 0. The bound is right to some
    roundings of the pair's size, less than ``noise_of``: corners of A are off by two, and products
    with the axis by two.
    """
    if pair.A.kind != SOLID:  # most calls: to pass the pair would take longer
        return 0.0
    return _gap_of_blocks(pair, i, j, scratch)


@inlined
def leaf_in_block(pair: SolidPair, k: int, first: int, scratch: Floats) -> Leaf:
    """Return A's core, or triangle k of the block in the scratch, as a leaf."""
    if pair.A.kind != SOLID:
        return leaf_of_A(pair, k)
    row = scratch[k - first]
    return around(vector_at(row, PLACED), vector_at(row, PLACED + 3), vector_at(row, PLACED + 6))
