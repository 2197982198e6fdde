"""A second tree over a solid's triangles, for points: eight boxes a node, eight triangles a leaf.

Its leaves, *blocks*, are pairs of leaves of the first one, and its boxes are some of that one's.
Parameters: level after level, the top first, the boxes of a level by groups of LANES; then the
blocks. Box k of a level has group k of the next one beneath it, of the last level block k. Lanes
without a box or triangle of their own repeat one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.solids.lanes import (
    BOX_LANES,
    LANES,
)
from drake_geom_ros.geometry._proximity.kernels.solids.pieces import slices_of
from drake_geom_ros.geometry._proximity.kernels.solids.solid import CORNERS, INNER_BOX, Tree
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined

Floats = NDArray[np.float64]

BITS = 3  # LANES is 2 to this
# One box of the last level is taken away where eight of the next are put, level by level.
MOST_WAITING = 16 * LANES


class LaneTree(NamedTuple):
    """The offsets of the boxes and blocks in a solid's parameters, and the number of blocks."""

    boxes: int
    blocks_at: int
    blocks: int
    levels: int
    halvings: int  # of the triangles, down to blocks


@inlined
def blocks_of(leaves: int) -> tuple[int, int]:
    """Return (blocks, levels of boxes above them) over a power of two of leaves."""
    blocks, levels = max(leaves // 2, 1), 1
    while blocks > 1 << BITS * levels:
        levels += 1
    return blocks, levels


@inlined
def boxes_in(blocks: int, levels: int, level: int) -> int:
    """Return how many boxes there are at a level, the top one 0."""
    return max(blocks >> BITS * (levels - 1 - level), 1)


@inlined
def groups_in(blocks: int, levels: int, level: int) -> int:
    """Return how many groups the boxes of a level are in."""
    return (boxes_in(blocks, levels, level) + LANES - 1) // LANES


@compiled
def lane_tree_of(tree: Tree) -> LaneTree:
    """Return the tree for points of a solid with this ``Tree``."""
    blocks, levels = blocks_of(tree.leaves)
    boxes = tree.boxes_at + INNER_BOX * tree.boxes
    groups = halvings = 0
    while 1 << halvings < blocks:
        halvings += 1
    for level in range(levels):
        groups += groups_in(blocks, levels, level)
    return LaneTree(boxes, boxes + BOX_LANES * groups, blocks, levels, halvings)


@inlined
def first_of_block(tree: Tree, lanes: LaneTree, k: int) -> int:
    """Return the first triangle of block k, the first of a leaf; that of the next one ends it."""
    return k * tree.triangles >> lanes.halvings


def lane_count(leaves: int) -> int:
    """Return how many numbers ``put_lanes`` writes for a tree with so many leaves."""
    blocks, levels = blocks_of(leaves)
    groups = sum(groups_in(blocks, levels, level) for level in range(levels))
    return BOX_LANES * groups + CORNERS * LANES * blocks


def put_lanes(out: Floats, corners: Floats, boxes: Floats, starts: NDArray[np.int64]) -> None:
    """Write the parameters over triangles (n, 3, 3) in the order of the leaves.

    ``boxes`` (2 L - 1, 6) are those of the first tree's nodes, ``starts`` (L + 1,) where the
    triangles of its leaves begin.
    """
    leaves = len(starts) - 1
    blocks, levels = blocks_of(leaves)
    at = 0
    for level in range(levels):
        count = boxes_in(blocks, levels, level)
        lanes = np.arange(-(-count // LANES) * LANES)
        of_level = boxes[count - 1 + np.minimum(lanes, count - 1)]
        groups = out[at : at + of_level.size].reshape(-1, 6, LANES)
        groups[:] = of_level.reshape(-1, LANES, 6).transpose(0, 2, 1)
        at += of_level.size
    ends = starts[:: leaves // blocks]
    of_blocks = out[at:].reshape(blocks, CORNERS, LANES)
    for some in slices_of(blocks):
        firsts, lasts = ends[some, None], ends[some.start + 1 : some.stop + 1, None] - 1
        numbers = np.minimum(firsts + np.arange(LANES), lasts)
        of_blocks[some] = corners[numbers].reshape(-1, LANES, CORNERS).transpose(0, 2, 1)
