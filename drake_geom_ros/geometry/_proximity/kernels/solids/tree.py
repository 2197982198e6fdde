"""A solid's triangles under a tree of boxes: where things stand, and how trees are walked.

Parameters of SOLID: those of CONVEX for its hull; a header; the nodes of a heap (node k has the
children 2 k + 1 and 2 k + 2); corners of the triangles, leaf by leaf; a point on each connected
piece of the surface, the middle of a triangle; the planes of the hull's largest faces; last the
place of the header. Everything is in the solid's frame, and here B's frame is where all is
computed: A, its origin at p, is turned into it. A may be a core of ``supports`` or a solid: a core
is a tree of one leaf.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.cores.supports import local_support
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    Vector,
    add,
    cross,
    norm,
    rotate,
    scale,
    sub,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST_IN_LEAF = 4  # triangles; a triangle costs about as much as a box

HEADER = 4  # numbers: triangles, leaves, pieces, planes
NODE_WIDTH = 15
LOWER = 0  # 3: corner of the box
UPPER = 3  # 3
AREA_VECTOR = 6  # 3: sum of the triangles' normals times areas [m^2]
AREA = 9  # sum of the areas [m^2]
CENTRE = 10  # 3: mean of the triangles' points
RADIUS = 13  # of a ball around the centre that holds the triangles [m]
MOMENT = 14  # norm of the sum of normals times areas times middles, from the centre [m^3]
CORNERS = 9  # numbers a triangle
PLANE = 4  # numbers a plane: outward normal, offset


class Tree(NamedTuple):
    """Where the parts of a solid begin in its parameters, and how many there are; 0 of a core."""

    nodes: int
    leaves: int
    corners: int
    triangles: int
    pieces_at: int
    pieces: int
    planes_at: int
    planes: int


NO_TREE = Tree(0, 0, 0, 0, 0, 0, 0, 0)  # of a core


class Box(NamedTuple):
    """A box along the axes: its middle and half its size [m]."""

    middle: Vector
    half: Vector


NO_BOX = Box((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # of a point


class Body(NamedTuple):
    """A, a core or a solid: its orientation R in B, its tree, and the box of its core, in A."""

    kind: int
    shape: Floats
    R: Floats
    tree: Tree
    box: Box


class Solid(NamedTuple):
    """B, the solid in whose frame all is computed, and so its orientation is the identity."""

    shape: Floats
    tree: Tree
    identity: Floats


class Walk(NamedTuple):
    """The stack of a walk over two trees: pairs of nodes (k, 2), and the gap [m] of each."""

    stack: Indices
    gaps: Floats


# Of a walk: each step takes one pair of nodes away and puts two back, and trees of 2^40 leaves do
# not fit into memory.
DEEPEST = 96


@compiled
def tree_of(kind, shape):
    """Return the tree of a solid, or the empty one of a core."""
    if kind != SOLID:
        return NO_TREE
    header = int(shape[shape.size - 1])
    triangles, leaves = int(shape[header]), int(shape[header + 1])
    pieces, planes = int(shape[header + 2]), int(shape[header + 3])
    nodes = header + HEADER
    corners = nodes + NODE_WIDTH * (2 * leaves - 1)
    pieces_at = corners + CORNERS * triangles
    planes_at = pieces_at + 3 * pieces
    return Tree(nodes, leaves, corners, triangles, pieces_at, pieces, planes_at, planes)


@inlined
def first_of_leaf(tree, i):
    """Return the first triangle of leaf i; that of the next one ends it. A core is one leaf."""
    if tree.leaves == 0:
        return i
    return i * tree.triangles // tree.leaves


@compiled
def normal_of(shape, tree, j):
    """Return the outward unit normal of triangle j, or the zero vector if it has no area."""
    at = tree.corners + CORNERS * j
    a = vector_at(shape, at)
    return unit(cross(sub(vector_at(shape, at + 3), a), sub(vector_at(shape, at + 6), a)))


@inlined
def edge_of(shape, tree, j, k):
    """Return edge k, 0 to 2, of triangle j."""
    at = tree.corners + CORNERS * j
    return sub(vector_at(shape, at + 3 * ((k + 1) % 3)), vector_at(shape, at + 3 * k))


@inlined
def middle_of_triangle(shape, tree, j):
    """Return the mean of the corners of triangle j."""
    at = tree.corners + CORNERS * j
    ab = add(vector_at(shape, at), vector_at(shape, at + 3))
    return scale(1.0 / 3.0, add(ab, vector_at(shape, at + 6)))


@compiled
def box_of_core(kind, shape):
    """Return the box of a core, in its frame; of a solid nothing is asked."""
    if kind == SOLID:
        return NO_BOX
    above = (
        local_support(kind, shape, (1.0, 0.0, 0.0), 0.0)[0],
        local_support(kind, shape, (0.0, 1.0, 0.0), 0.0)[1],
        local_support(kind, shape, (0.0, 0.0, 1.0), 0.0)[2],
    )
    below = (
        local_support(kind, shape, (-1.0, 0.0, 0.0), 0.0)[0],
        local_support(kind, shape, (0.0, -1.0, 0.0), 0.0)[1],
        local_support(kind, shape, (0.0, 0.0, -1.0), 0.0)[2],
    )
    return box_between(below, above)


@inlined
def box_between(below, above):
    """Return the box with these corners."""
    return Box(
        (0.5 * (below[0] + above[0]), 0.5 * (below[1] + above[1]), 0.5 * (below[2] + above[2])),
        (0.5 * (above[0] - below[0]), 0.5 * (above[1] - below[1]), 0.5 * (above[2] - below[2])),
    )


@inlined
def box_of_node(shape, tree, k):
    """Return the box of node k."""
    at = tree.nodes + NODE_WIDTH * k
    return box_between(vector_at(shape, at + LOWER), vector_at(shape, at + UPPER))


@allocating
def body_of(kind, shape, R):
    """Return a core or a solid of orientation R in B as A."""
    return Body(kind, shape, R, tree_of(kind, shape), box_of_core(kind, shape))


@allocating
def solid_of(shape):
    """Return a solid as B."""
    return Solid(shape, tree_of(SOLID, shape), np.eye(3))


@inlined
def outside(distance, reach):
    """Return how far a coordinate is beyond a reach; 0 within."""
    return max(abs(distance) - reach, 0.0)


@compiled
def gap_of_boxes(box_A, R, p, box_B):
    """Return a lower bound [m] of the distance of two boxes, the first turned by R and moved by p.

    Each is put into a box along the axes of the other: the larger of both distances. Nothing here
    is farther from Bo than the pair's size, so a dozen roundings of EPS each make it less than
    ROUNDING EPS size too large; whoever leaves out what is beyond a limit has added that.
    """
    h, k = box_A.half, box_B.half
    d = sub(add(rotate(R, box_A.middle), p), box_B.middle)
    in_B = (
        outside(d[0], k[0] + abs(R[0, 0]) * h[0] + abs(R[0, 1]) * h[1] + abs(R[0, 2]) * h[2]),
        outside(d[1], k[1] + abs(R[1, 0]) * h[0] + abs(R[1, 1]) * h[1] + abs(R[1, 2]) * h[2]),
        outside(d[2], k[2] + abs(R[2, 0]) * h[0] + abs(R[2, 1]) * h[1] + abs(R[2, 2]) * h[2]),
    )
    x = R[0, 0] * d[0] + R[1, 0] * d[1] + R[2, 0] * d[2]
    y = R[0, 1] * d[0] + R[1, 1] * d[1] + R[2, 1] * d[2]
    z = R[0, 2] * d[0] + R[1, 2] * d[1] + R[2, 2] * d[2]
    in_A = (
        outside(x, h[0] + abs(R[0, 0]) * k[0] + abs(R[1, 0]) * k[1] + abs(R[2, 0]) * k[2]),
        outside(y, h[1] + abs(R[0, 1]) * k[0] + abs(R[1, 1]) * k[1] + abs(R[2, 1]) * k[2]),
        outside(z, h[2] + abs(R[0, 2]) * k[0] + abs(R[1, 2]) * k[1] + abs(R[2, 2]) * k[2]),
    )
    return max(norm(in_A), norm(in_B))


@inlined
def box_at(A, i):
    """Return the box of node i of A, in A's frame."""
    return box_of_node(A.shape, A.tree, i) if A.kind == SOLID else A.box


@inlined
def is_leaf(tree, k):
    """Tell whether node k is a leaf; leaf number k - (leaves - 1)."""
    return k >= tree.leaves - 1


@compiled
def push_children(A, B, p, i, j, path, top):
    """Push the two pairs that a pair of nodes, not both leaves, is cut into, the nearer last."""
    cut_B = is_leaf(A.tree, i)
    if not cut_B and not is_leaf(B.tree, j):
        cut_B = norm(box_of_node(B.shape, B.tree, j).half) >= norm(box_at(A, i).half)
    if cut_B:
        box = box_at(A, i)
        first = gap_of_boxes(box, A.R, p, box_of_node(B.shape, B.tree, 2 * j + 1))
        second = gap_of_boxes(box, A.R, p, box_of_node(B.shape, B.tree, 2 * j + 2))
    else:
        box = box_of_node(B.shape, B.tree, j)
        first = gap_of_boxes(box_at(A, 2 * i + 1), A.R, p, box)
        second = gap_of_boxes(box_at(A, 2 * i + 2), A.R, p, box)
    for turn in range(2):
        # The second first, if it is the farther one.
        k = 1 - turn if second >= first else turn
        path.stack[top, 0] = i if cut_B else 2 * i + 1 + k
        path.stack[top, 1] = 2 * j + 1 + k if cut_B else j
        path.gaps[top] = second if k == 1 else first
        top += 1
    return top


@allocating
def walk(A, B, p):
    """Return the walk that begins at the pair of roots."""
    stack, gaps = np.zeros((DEEPEST, 2), dtype=np.int64), np.empty(DEEPEST)
    gaps[0] = gap_of_boxes(box_at(A, 0), A.R, p, box_of_node(B.shape, B.tree, 0))
    return Walk(stack, gaps)


@compiled
def next_leaves(A, B, p, path, top, limit):
    """Go on to the next pair of leaves within ``limit``; return (top, i, j, skipped).

    ``top`` pairs are left on the stack. i and j number the leaves, and are -1 when none are left;
    ``skipped`` is the least gap [m] of what was left out, which is beyond the limit.

    No leaves within the limit are left out: a pair of nodes is put aside only if its gap, a lower
    bound of that of all leaves below, is beyond it, and otherwise it is one of leaves, and handed
    out, or both its halves take its place. The limit may shrink from call to call.
    """
    skipped = math.inf
    while top > 0:
        top -= 1
        i, j = path.stack[top, 0], path.stack[top, 1]
        if path.gaps[top] > limit:
            skipped = min(skipped, path.gaps[top])
        elif is_leaf(A.tree, i) and is_leaf(B.tree, j):
            return top, i - (A.tree.leaves - 1), j - (B.tree.leaves - 1), skipped
        else:
            top = push_children(A, B, p, i, j, path, top)
    return top, -1, -1, skipped


@inlined
def parts_of_angle(a, b, c):
    """Return (y, x, |a| |b| |c|): atan2(y, x) is half the solid angle of a triangle."""
    la, lb, lc = norm(a), norm(b), norm(c)
    n = cross(b, c)
    volume = a[0] * n[0] + a[1] * n[1] + a[2] * n[2]
    ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    bc = b[0] * c[0] + b[1] * c[1] + b[2] * c[2]
    ca = c[0] * a[0] + c[1] * a[1] + c[2] * a[2]
    return volume, la * lb * lc + ab * lc + bc * la + ca * lb, la * lb * lc


@compiled
def solid_angle(a, b, c):
    """Return half the solid angle [sr] of a triangle seen from the origin, signed.

    Van Oosterom & Strackee, IEEE Transactions on Biomedical Engineering 30 (2), 1983. Negative
    where the corners turn counter-clockwise as seen from the origin, that is from outside.
    """
    y, x, _ = parts_of_angle(a, b, c)
    return math.atan2(y, x)


@compiled
def rounding_of_angle(a, b, c):
    """Return how far off ``solid_angle`` may be [sr]: both its parts, sums of products of three.

    Beside a needle nothing may be left of them, and the angle is anything.
    """
    y, x, product = parts_of_angle(a, b, c)
    left = max(abs(y), abs(x))
    noise = ROUNDING * EPS * product
    return noise / left if noise < math.pi * left else math.pi
