"""Whether a core or a solid is in a solid, or the reverse, where their surfaces do not cross.

Two solids are decided by their triangles (``meetings``, ``rays``), without error where the pose
swaps axes at most, and so are a box and a solid. Bodies are given as in ``distance``.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import vertex_at
from drake_geom_ros.geometry._proximity.kernels.solids.distance import nearest
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import middle_of
from drake_geom_ros.geometry._proximity.kernels.solids.meetings import (
    A_IS_OUT,
    B_IS_OUT,
    OVERLAPPING,
    TOUCH,
    meeting,
)
from drake_geom_ros.geometry._proximity.kernels.solids.rays import (
    Posed,
    is_beneath_within,
    swaps_axes,
    triangle_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.signs import Triangle
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    NO_TREE,
    Solid,
    Tree,
    TreeBody,
    first_of_leaf,
)
from drake_geom_ros.geometry._proximity.kernels.solids.winding import is_inside
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import LOWER, NO_BOX, NODE_WIDTH, UPPER
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kernels.vectors import norm
from drake_geom_ros.geometry._proximity.kinds import BOX, CONVEX, SOLID, SPHERE, VERTEX_COUNT
from drake_geom_ros.geometry._proximity.runtime.arrays import Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING

FLUSH = 16.0  # roundings that leaves which touch may be apart
FIRST_NORMAL = (1.0, 0.0, 0.0)  # where GJK begins when nothing is known
TURNED = 8.0 * EPS  # of a corner that is turned and moved, over how far it is from either origin

# The faces of a box, two triangles each, counter-clockwise from outside: corner k is at the upper
# end of x, y, z where k has the bits 4, 2, 1.
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
BOX_TREE = Tree(0, 1, NODE_WIDTH, 12, NODE_WIDTH + 12 * CORNERS, 1, 0, 0, 0, 0)


@allocating
def depth_in_solid(B: Solid, q: Vector, size: float) -> float:
    """Return how deep q lies in B [m], negative outside."""
    point = TreeBody(SPHERE, np.zeros(1), B.identity, NO_TREE, NO_BOX)
    distance = nearest(point, B, q, FIRST_NORMAL, size, 0.0, math.inf).upper
    return distance if is_inside(B.shape, B.tree, q) else -distance


@compiled
def bounds_if_box(A: TreeBody) -> tuple[bool, Vector, Vector]:
    """Return (is_box, low, high): whether a core is a box along its axes, and its corners."""
    if A.kind == BOX:
        x, y, z = A.shape[0], A.shape[1], A.shape[2]
        return True, (-x, -y, -z), (x, y, z)
    nothing = (0.0, 0.0, 0.0)
    if A.kind != CONVEX or A.shape[VERTEX_COUNT] != 8.0:
        return False, nothing, nothing
    low = high = vertex_at(A.shape, 1)
    for k in range(2, 9):
        v = vertex_at(A.shape, k)
        low = min(low[0], v[0]), min(low[1], v[1]), min(low[2], v[2])
        high = max(high[0], v[0]), max(high[1], v[1]), max(high[2], v[2])
    for k in range(1, 9):
        v = vertex_at(A.shape, k)
        for c in range(3):
            if v[c] != low[c] and v[c] != high[c]:
                return False, nothing, nothing
    return True, low, high


@allocating
def box_as_solid(A: TreeBody, low: Vector, high: Vector) -> TreeBody:
    """Return a box as the solid of its twelve triangles."""
    shape = np.zeros(NODE_WIDTH + 12 * CORNERS + 1)
    for c in range(3):
        shape[LOWER + c], shape[UPPER + c] = low[c], high[c]
    for f in range(6):
        for t in range(2):
            for k in range(3):
                corner = QUADS[f][0] if k == 0 else QUADS[f][t + k]
                at = NODE_WIDTH + CORNERS * (2 * f + t) + 3 * k
                for c in range(3):
                    shape[at + c] = high[c] if corner & (4 >> c) else low[c]
    return TreeBody(SOLID, shape, A.R, BOX_TREE, NO_BOX)


@compiled
def beside(
    T: Triangle,
    S: Triangle,
    apart: float,
) -> bool:
    """Tell whether the boxes around two triangles are farther apart than that."""
    (a, b, c), (x, y, z) = T, S
    for k in range(3):
        if min(a[k], b[k], c[k]) - max(x[k], y[k], z[k]) > apart:
            return True
        if min(x[k], y[k], z[k]) - max(a[k], b[k], c[k]) > apart:
            return True
    return False


@allocating
def meet_anywhere(
    A: TreeBody,
    B: Solid,
    p: Vector,
    mine: Posed,
    its: Posed,
    reach: float,
    told: Indices,
    heard: Indices,
) -> bool:
    """Tell whether triangles of A and B that meet show that these overlap.

    ``told`` (n,) and ``heard`` (m,) get what is known of each triangle of A and of B. ``mine`` and
    ``its`` are A and B as ``Posed``; what is farther apart than ``reach`` does not meet.
    """
    path, top = walk(A, B, p), 1
    while True:
        top, i, j, _ = next_leaves(A, B, p, path, top, reach)
        if i < 0:
            return False
        for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
            T = triangle_of(mine, k)
            for m in range(first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)):
                S = triangle_of(its, m)
                if beside(T, S, reach):
                    continue
                bits = meeting(T, S, mine.off)
                if bits & OVERLAPPING != 0:
                    return True
                told[k] |= bits & (TOUCH | A_IS_OUT)
                heard[m] |= bits & (TOUCH | B_IS_OUT)


@compiled
def is_piece_within(posed: Posed, other: Posed) -> bool:
    """Tell whether what is just beneath a triangle of any piece of a solid is in the other."""
    tree = posed.tree
    for k in range(tree.pieces):
        j = int(posed.shape[tree.pieces_at + k])
        if is_beneath_within(triangle_of(posed, j), other):
            return True
    return False


@compiled
def is_touched_within(posed: Posed, other: Posed, told: Indices) -> bool:
    """Tell whether what is beneath a triangle, of which only a touch is known, is in the other."""
    for j in range(told.size):
        if told[j] == TOUCH and is_beneath_within(triangle_of(posed, j), other):
            return True
    return False


@compiled
def rounding_of_places(A: TreeBody, p: Vector) -> float:
    """Return how far off [m] the corners of a solid A may be in B; 0 where nothing is rounded."""
    if swaps_axes(A.R):
        return 0.0
    root, far = A.tree.nodes, norm(p)
    for c in range(3):
        far += max(abs(A.shape[root + LOWER + c]), abs(A.shape[root + UPPER + c]))
    return TURNED * far


@allocating
def have_inside_in_common(A: TreeBody, B: Solid, p: Vector, touches: bool, size: float) -> bool:
    """Tell whether two solids have an inside in common.

    If they have, a face of what they have in common lies on a triangle of one, and just beneath it
    is the inside of the other. Triangles that touch the other's surface are asked, and one of each
    piece for all of its that do not.
    """
    off = rounding_of_places(A, p)
    mine = Posed(A.shape, A.tree, A.R, p, off)
    its = Posed(B.shape, B.tree, B.identity, (0.0, 0.0, 0.0), off)
    if touches:
        told = np.zeros(A.tree.triangles, dtype=np.int64)
        heard = np.zeros(B.tree.triangles, dtype=np.int64)
        reach = FLUSH * ROUNDING * EPS * size
        if meet_anywhere(A, B, p, mine, its, reach, told, heard):
            return True
        if is_touched_within(mine, its, told) or is_touched_within(its, mine, heard):
            return True
    return is_piece_within(mine, its) or is_piece_within(its, mine)


@allocating
def is_contained(A: TreeBody, B: Solid, p: Vector, touches: bool, size: float) -> bool:
    """Tell whether A and B overlap, where their surfaces do not cross, as ``nearest`` sees it.

    ``touches`` tells that these may have a point in common, to rounding: solids and boxes are then
    decided by their triangles. A core with a volume crosses any triangle within it, as ``nearest``
    sees it; it is left that the core is in B, and then its middle is. A core without is a point or
    a segment with a ball around it, which overlaps where the core touches, unless the ball is as
    small as rounding.
    """
    if A.kind == SOLID:
        return have_inside_in_common(A, B, p, touches, size)
    if touches:
        is_box, low, high = bounds_if_box(A)
        if is_box:
            return have_inside_in_common(box_as_solid(A, low, high), B, p, True, size)
    on_surface = touches and A.kind == SPHERE
    return not on_surface and is_inside(B.shape, B.tree, middle_of(A, p))
