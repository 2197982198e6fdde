"""A solid's triangles under a tree of boxes: the layout of its parameters, and its records.

Parameters of SOLID: those of CONVEX for its hull; a header; the nodes of a heap (node k has the
children 2 k + 1 and 2 k + 2); corners of the triangles, leaf by leaf; the number of a triangle of
each connected piece of the surface; the planes of the hull's largest faces; boxes in it; the tree
for points (``lane_tree``); coins of the nodes (``coins``); last the place of the header.
Everything is in the solid's frame, and all is computed in B's frame: A, its origin at p, is turned
into it. A may be a core of ``supports`` or a solid: a core is a tree of one leaf.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.trees.boxes import (
    NO_BOX,
    NODE_WIDTH,
    NodeBox,
)
from drake_geom_ros.geometry._proximity.kernels.trees.core_boxes import box_of_core
from drake_geom_ros.geometry._proximity.kernels.trees.walks import Floats
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    cross,
    norm,
    scale,
    sub,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING

MOST_IN_LEAF = 4  # triangles; a triangle costs about as much as a box

HEADER = 5  # numbers: triangles, leaves, pieces, planes, boxes
AREA_VECTOR = 6  # 3: sum of the triangles' normals times areas [m^2]
AREA = 9  # sum of the areas [m^2]
CENTRE = 10  # 3: mean of the triangles' points
RADIUS = 13  # of a ball around the centre that holds the triangles [m]
MOMENT = 14  # norm of the sum of normals times areas times middles, from the centre [m^3]
CORNERS = 9  # numbers a triangle
PLANE = 4  # numbers a plane: outward normal, offset
INNER_BOX = 6  # numbers a box: its lower and its upper corner


class Tree(NamedTuple):
    """The offsets of a solid's parts in its parameters, and their numbers; all 0 for a core."""

    nodes: int
    leaves: int
    corners: int
    triangles: int
    pieces_at: int
    pieces: int
    planes_at: int
    planes: int
    boxes_at: int
    boxes: int


NO_TREE = Tree(0, 0, 0, 0, 0, 0, 0, 0, 0, 0)  # of a core


class TreeBody(NamedTuple):
    """A, a core or a solid: its orientation R in B, its tree, and the box of its core, in A."""

    kind: int
    shape: Floats
    R: Floats
    tree: Tree
    box: NodeBox


class Solid(NamedTuple):
    """B, the solid in whose frame all is computed, and so its orientation is the identity."""

    shape: Floats
    tree: Tree
    identity: Floats


class SolidPair(NamedTuple):
    """A and B in their relative pose: A's origin is at p, and A is its core grown by a ball."""

    A: TreeBody
    B: Solid
    p: Vector
    size: float  # [m] to which rounding is relative
    tolerance: float  # [m] that bounds may be apart
    radius: float  # [m] of the ball


@inlined
def noise_of(pair: SolidPair) -> float:
    """Return how far off rounding may put a distance [m]."""
    return ROUNDING * EPS * pair.size


@allocating
def moved(pair: SolidPair, t: Vector) -> SolidPair:
    """Return the pair with A moved by t."""
    A, B, p, size, tolerance, radius = pair
    return SolidPair(A, B, add(p, t), size, tolerance, radius)


@compiled
def tree_of(kind: int, shape: Floats) -> Tree:
    """Return the tree of a solid, or the empty one of a core."""
    if kind != SOLID:
        return NO_TREE
    header = int(shape[shape.size - 1])
    triangles, leaves = int(shape[header]), int(shape[header + 1])
    pieces, planes = int(shape[header + 2]), int(shape[header + 3])
    nodes = header + HEADER
    corners = nodes + NODE_WIDTH * (2 * leaves - 1)
    pieces_at = corners + CORNERS * triangles
    planes_at = pieces_at + pieces
    boxes, boxes_at = int(shape[header + 4]), planes_at + PLANE * planes
    return Tree(
        nodes, leaves, corners, triangles, pieces_at, pieces, planes_at, planes, boxes_at, boxes
    )


@inlined
def first_of_leaf(tree: Tree, i: int) -> int:
    """Return the first triangle of leaf i; that of the next one ends it. A core is one leaf."""
    if tree.leaves == 0:
        return i
    return i * tree.triangles // tree.leaves


@compiled
def normal_of(shape: Floats, tree: Tree, j: int) -> Vector:
    """Return the outward unit normal of triangle j, or the zero vector if it has no area."""
    at = tree.corners + CORNERS * j
    a = vector_at(shape, at)
    return unit(cross(sub(vector_at(shape, at + 3), a), sub(vector_at(shape, at + 6), a)))


@inlined
def edge_of(shape: Floats, tree: Tree, j: int, k: int) -> Vector:
    """Return edge k, 0 to 2, of triangle j."""
    at = tree.corners + CORNERS * j
    return sub(vector_at(shape, at + 3 * ((k + 1) % 3)), vector_at(shape, at + 3 * k))


@inlined
def middle_of_triangle(shape: Floats, tree: Tree, j: int) -> Vector:
    """Return the mean of the corners of triangle j."""
    at = tree.corners + CORNERS * j
    ab = add(vector_at(shape, at), vector_at(shape, at + 3))
    return scale(1.0 / 3.0, add(ab, vector_at(shape, at + 6)))


@allocating
def body_of(kind: int, shape: Floats, R: Floats) -> TreeBody:
    """Return a core or a solid of orientation R in B as A."""
    box = NO_BOX if kind == SOLID else box_of_core(kind, shape)
    return TreeBody(kind, shape, R, tree_of(kind, shape), box)


@allocating
def solid_of(shape: Floats) -> Solid:
    """Return a solid as B."""
    return Solid(shape, tree_of(SOLID, shape), np.eye(3))


@inlined
def parts_of_angle(a: Vector, b: Vector, c: Vector) -> tuple[float, float, float]:
    """Return (y, x, |a| |b| |c|): atan2(y, x) is half the solid angle of a triangle."""
    la, lb, lc = norm(a), norm(b), norm(c)
    n = cross(b, c)
    volume = a[0] * n[0] + a[1] * n[1] + a[2] * n[2]
    ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    bc = b[0] * c[0] + b[1] * c[1] + b[2] * c[2]
    ca = c[0] * a[0] + c[1] * a[1] + c[2] * a[2]
    return volume, la * lb * lc + ab * lc + bc * la + ca * lb, la * lb * lc


@compiled
def solid_angle(a: Vector, b: Vector, c: Vector) -> float:
    """Return half the solid angle [sr] of a triangle seen from the origin, signed.

    Van Oosterom & Strackee, IEEE Transactions on Biomedical Engineering 30 (2), 1983. Negative
    where the corners turn counter-clockwise as seen from the origin, that is from outside.
    """
    y, x, _ = parts_of_angle(a, b, c)
    return math.atan2(y, x)


@compiled
def rounding_of_angle(a: Vector, b: Vector, c: Vector) -> float:
    """Return how far off ``solid_angle`` may be [sr], by both its parts: sums of triple products.

    Beside a needle both may vanish in rounding, and the angle is arbitrary.
    """
    y, x, product = parts_of_angle(a, b, c)
    left = max(abs(y), abs(x))
    noise = ROUNDING * EPS * product
    return noise / left if noise < math.pi * left else math.pi
