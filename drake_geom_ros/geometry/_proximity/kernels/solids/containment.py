"""Whether a core or a solid is in a solid, or the reverse, where their surfaces do not cross.

Bodies are given as in ``distance``.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF
from drake_geom_ros.geometry._proximity.kernels.solids.distance import (
    nearest,
    separation_of_leaves,
)
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import middle_of
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    NO_TREE,
    Solid,
    TreeBody,
    first_of_leaf,
    middle_of_triangle,
    normal_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.winding import is_inside
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import NO_BOX
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    rotate,
    scale,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID, SPHERE
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import BENEATH, EPS, ROUNDING

FLUSH = 16.0  # roundings that leaves which touch may be apart
FIRST_NORMAL = (1.0, 0.0, 0.0)  # where GJK begins when nothing is known


@allocating
def depth_in_solid(B, q, size):
    """Return how deep q lies in B [m], negative outside."""
    point = TreeBody(SPHERE, np.zeros(1), B.identity, NO_TREE, NO_BOX)
    distance = nearest(point, B, q, FIRST_NORMAL, size, 0.0, math.inf).upper
    return distance if is_inside(B.shape, B.tree, q) else -distance


@inlined
def point_beneath(shape, tree, j, depth):
    """Return the point so deep [m] beneath the middle of triangle j."""
    return add_scaled(middle_of_triangle(shape, tree, j), -depth, normal_of(shape, tree, j))


@compiled
def is_leaf_within(A, i, B, j, p, size, cutoff):
    """Tell whether, of leaves of A and B, triangles that touch lie in the other body.

    Those touch that are not proven to be farther apart than ``cutoff``. Walls in line may hide
    that a triangle is in the other body: what lies just beneath its middle tells.
    """
    depth, touching = BENEATH * size, 0
    first, last = first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)
    for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
        mine = 0
        for m in range(first, last):
            if (
                separation_of_leaves(A, k, B, m, p, FIRST_NORMAL, size, 0.0, cutoff).end
                != BEYOND_CUTOFF
            ):
                mine |= 1 << (m - first)
        touching |= mine
        if mine != 0:
            x = point_beneath(A.shape, A.tree, k, depth)
            if is_inside(B.shape, B.tree, add(p, rotate(A.R, x))):
                return True
    for m in range(first, last):
        if touching & (1 << (m - first)) != 0:
            y = point_beneath(B.shape, B.tree, m, depth)
            if is_inside(A.shape, A.tree, unrotate(A.R, sub(y, p))):
                return True
    return False


@allocating
def are_flush(A, B, p, size):
    """Tell whether a triangle of solids that touch, none of which cross, lies in the other body.

    All that touch are asked, however many they are: a bump may hide in a thousand that lie flush.
    """
    cutoff = FLUSH * ROUNDING * EPS * size
    path, top = walk(A, B, p), 1
    while True:
        top, i, j, _ = next_leaves(A, B, p, path, top, cutoff)
        if i < 0:
            return False
        if is_leaf_within(A, i, B, j, p, size, cutoff):
            return True


@compiled
def is_piece_within(shape, tree, B, R, p, size, least):
    """Tell whether a piece of a solid's surface, turned by R and moved by p, lies in B.

    Its point is asked, which has to be deeper than ``least``.
    """
    for k in range(tree.pieces):
        q = add(p, rotate(R, vector_at(shape, tree.pieces_at + 3 * k)))
        if is_inside(B.shape, B.tree, q) and depth_in_solid(B, q, size) > least:
            return True
    return False


@allocating
def is_contained(A, B, p, touches, size):
    """Tell whether A and B overlap, where their surfaces do not cross.

    ``touches`` tells that these may have a point in common, to rounding.

    Why nothing is missed, for two solids. If their interiors have a point in common, all that they
    have in common is bounded, and a point of its boundary lies on the surface of one and in the
    other, or on its surface. A piece of surface that does not touch the other's lies wholly in the
    other body or not at all, and so does its point. One that touches may have its point on the
    other's surface, where nothing can be told, so this has to be deeper then; but such a piece has
    triangles that touch, and ``are_flush`` asks all of them, to FLUSH times that depth.

    A core with a volume crosses any triangle within it, as ``nearest`` sees it; it is left that
    the core is in B, and then its middle is. A core without is a point or a segment with a ball
    around it, which overlaps where the core touches, unless the ball is as small as rounding.
    """
    if A.kind != SOLID:
        on_surface = touches and A.kind == SPHERE
        return not on_surface and is_inside(B.shape, B.tree, middle_of(A, p))
    if touches and are_flush(A, B, p, size):
        return True
    least = ROUNDING * EPS * size if touches else 0.0
    if is_piece_within(A.shape, A.tree, B, A.R, p, size, least):
        return True
    there, back = Solid(A.shape, A.tree, B.identity), scale(-1.0, unrotate(A.R, p))
    return is_piece_within(B.shape, B.tree, there, A.R.T.copy(), back, size, least)
