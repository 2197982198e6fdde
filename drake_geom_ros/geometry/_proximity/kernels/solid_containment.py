"""Whether a core or a solid is in a solid, or the reverse, where their surfaces do not cross.

Bodies are given as in ``solid_distance``.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.gjk import BEYOND_CUTOFF
from drake_geom_ros.geometry._proximity.kernels.solid_distance import leaf_gap, nearest
from drake_geom_ros.geometry._proximity.kernels.solid_hulls import middle_of
from drake_geom_ros.geometry._proximity.kernels.solid_points import is_inside
from drake_geom_ros.geometry._proximity.kernels.solid_tree import (
    NO_TREE,
    first_of_leaf,
    middle_of_triangle,
    next_leaves,
    normal_of,
    vector_at,
    walk,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    rotate,
    scale,
    sub,
    unrotate,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID, SPHERE
from drake_geom_ros.geometry._proximity.tolerances import BENEATH, EPS, ROUNDING

FLUSH = 16.0  # roundings that leaves which touch may be apart
FIRST_NORMAL = (1.0, 0.0, 0.0)  # where GJK begins when nothing is known


@compiled
def depth_of_point(B, q, size):
    """Return how deep q lies in B [m], negative outside."""
    point = (SPHERE, np.zeros(1), B[2], NO_TREE, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    distance = nearest(point, B, q, FIRST_NORMAL, size, 0.0, math.inf)[1]
    return distance if is_inside(B[0], B[1], q) else -distance


@compiled
def is_leaf_within(A, i, B, j, p, size, reach):
    """Tell whether, of leaves of A and B, triangles that touch lie in the other body.

    Those touch that are not proven to be farther apart than ``reach``. Walls in line may hide that
    a triangle is in the other body: what lies just beneath its middle tells.
    """
    beneath, touching = BENEATH * size, 0
    first, last = first_of_leaf(B[1], j), first_of_leaf(B[1], j + 1)
    for k in range(first_of_leaf(A[3], i), first_of_leaf(A[3], i + 1)):
        mine = 0
        for m in range(first, last):
            if leaf_gap(A, k, B, m, p, FIRST_NORMAL, size, 0.0, reach)[0] != BEYOND_CUTOFF:
                mine |= 1 << (m - first)
        touching |= mine
        if mine != 0:
            x = add_scaled(middle_of_triangle(A[1], A[3], k), -beneath, normal_of(A[1], A[3], k))
            if is_inside(B[0], B[1], add(p, rotate(A[2], x))):
                return True
    for m in range(first, last):
        if touching & (1 << (m - first)) != 0:
            y = add_scaled(middle_of_triangle(B[0], B[1], m), -beneath, normal_of(B[0], B[1], m))
            if is_inside(A[1], A[3], unrotate(A[2], sub(y, p))):
                return True
    return False


@compiled
def are_flush(A, B, p, size):
    """Tell whether a triangle of solids that touch, none of which cross, lies in the other body.

    All that touch are asked, however many they are: a bump may hide in a thousand that lie flush.
    """
    reach = FLUSH * ROUNDING * EPS * size
    path, top = walk(A, B, p), 1
    while True:
        top, i, j, _ = next_leaves(A, B, p, path, top, reach)
        if i < 0:
            return False
        if is_leaf_within(A, i, B, j, p, size, reach):
            return True


@compiled
def is_piece_within(shape, tree, B, R, p, size, least):
    """Tell whether a piece of a solid's surface, turned by R and moved by p, lies in B.

    Its point is asked, which has to be deeper than ``least``.
    """
    for k in range(tree[5]):
        q = add(p, rotate(R, vector_at(shape, tree[4] + 3 * k)))
        if is_inside(B[0], B[1], q) and depth_of_point(B, q, size) > least:
            return True
    return False


@compiled
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
    kind, shape, R, tree, _ = A
    if kind != SOLID:
        on_surface = touches and kind == SPHERE
        return not on_surface and is_inside(B[0], B[1], middle_of(A, p))
    if touches and are_flush(A, B, p, size):
        return True
    least = ROUNDING * EPS * size if touches else 0.0
    if is_piece_within(shape, tree, B, R, p, size, least):
        return True
    there, back = (shape, tree, B[2]), scale(-1.0, unrotate(R, p))
    return is_piece_within(B[0], B[1], there, R.T.copy(), back, size, least)
