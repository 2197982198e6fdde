"""Parameters of OCCUPIED_CELLS and POINT_CLOUD: a hull, then a tree of boxes and the centres.

The hull is the box around the whole map, as parameters of CONVEX, so code for hulls can bound a
map. From the index in the last number on follow: the size of a cell (half its edge, or its
radius), the number of cells, and the number L of leaves, a power of two; 2 L - 1 nodes, each the
corners of a box around centres; and the centres.

The tree is a heap: node k has the children 2 k + 1 and 2 k + 2, so it needs no links. Leaf i of L
has the centres ``i n // L`` up to ``(i + 1) n // L``, in the order of a space-filling curve.
"""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.vectors import vector_at
from drake_geom_ros.geometry._proximity.kinds import OCCUPIED_CELLS
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined

# Offsets after the hull.
SIZE, COUNT, LEAVES, HEADER = 0, 1, 2, 3
NODE = 6  # numbers of a node: the lower corner of its box, then the upper one
CENTRE = 3
MOST_IN_LEAF = 4


class MapTree(NamedTuple):
    """Layout of the tree of a map in its parameters."""

    size: float  # [m] half the edge of a cell, or its radius
    cells: int
    leaves: int  # 0: no map, treated as a single leaf
    nodes: int
    centres: int


NO_MAP = MapTree(0.0, 1, 0, 0, 0)


@inlined
def is_map(kind: int) -> bool:
    """Return whether a shape is a union of cells."""
    return kind >= OCCUPIED_CELLS


@inlined
def map_tree_of(kind: int, shape: Floats) -> MapTree:
    """Return the tree of a map, or NO_MAP for any other shape."""
    if not is_map(kind):
        return NO_MAP
    header = int(shape[shape.size - 1])
    leaves, nodes = int(shape[header + LEAVES]), header + HEADER
    centres = nodes + NODE * (2 * leaves - 1)
    return MapTree(shape[header + SIZE], int(shape[header + COUNT]), leaves, nodes, centres)


@inlined
def is_leaf(tree: MapTree, k: int) -> bool:
    """Return whether node k is a leaf."""
    return k >= tree.leaves - 1


@inlined
def first_in(tree: MapTree, node: int) -> int:
    """Return the first cell of a leaf, given its node; the first of the next node is its end."""
    if tree.leaves == 0:
        return node
    return (node - (tree.leaves - 1)) * tree.cells // tree.leaves


@inlined
def centre_at(shape: Floats, tree: MapTree, i: int) -> Vector:
    """Return the centre of cell i."""
    return vector_at(shape, tree.centres + CENTRE * i)
