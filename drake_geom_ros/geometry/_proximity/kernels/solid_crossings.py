"""Whether the surface of a solid crosses itself, which it must not."""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.solid_tree import (
    CORNERS,
    DEEPEST,
    LOWER,
    NODE_WIDTH,
    SOLID,
    UPPER,
    first_of_leaf,
    is_leaf,
    tree_of,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import cross, dot, norm, sub, unit
from drake_geom_ros.geometry._proximity.tolerances import CROSSING


@compiled
def boxes_meet(shape, tree, i, j):
    """Tell whether the boxes of two nodes have a point in common."""
    a, b = tree[0] + NODE_WIDTH * i, tree[0] + NODE_WIDTH * j
    for c in range(3):
        if shape[a + LOWER + c] > shape[b + UPPER + c]:
            return False
        if shape[b + LOWER + c] > shape[a + UPPER + c]:
            return False
    return True


@compiled
def pierces(p, q, a, b, c):
    """Tell whether the segment p q goes through the inside of the triangle a b c."""
    ab, ac = sub(b, a), sub(c, a)
    n = unit(cross(ab, ac))
    above, below = dot(sub(p, a), n), dot(sub(q, a), n)
    enough = CROSSING * (norm(ab) + norm(ac))
    if above * below >= 0.0 or min(abs(above), abs(below)) <= enough:
        return False
    # On which side of each edge the segment passes: three volumes of one sign.
    pq = sub(q, p)
    u = dot(pq, cross(sub(a, p), sub(b, p)))
    v = dot(pq, cross(sub(b, p), sub(c, p)))
    w = dot(pq, cross(sub(c, p), sub(a, p)))
    least = CROSSING * abs(u + v + w)
    return min(u, v, w) > least or max(u, v, w) < -least


@compiled
def overlap_in_plane(shape, at, other):
    """Tell whether two triangles lie in one plane and have an area in common."""
    a = vector_at(shape, at)
    ab, ac = sub(vector_at(shape, at + 3), a), sub(vector_at(shape, at + 6), a)
    n, enough = unit(cross(ab, ac)), CROSSING * (norm(ab) + norm(ac))
    for k in range(3):
        if abs(dot(sub(vector_at(shape, other + 3 * k), a), n)) > enough:
            return False
    # No edge of either has the other triangle beyond it.
    for turn in range(2):
        mine, its = (at, other) if turn == 0 else (other, at)
        for k in range(3):
            p = vector_at(shape, mine + 3 * k)
            edge = sub(vector_at(shape, mine + 3 * ((k + 1) % 3)), p)
            side = unit(cross(edge, n))
            third = dot(sub(vector_at(shape, mine + 3 * ((k + 2) % 3)), p), side)
            out = 1.0 if third <= 0.0 else -1.0
            nearest = math.inf
            for c in range(3):
                nearest = min(nearest, out * dot(sub(vector_at(shape, its + 3 * c), p), side))
            if nearest >= -enough:
                return False
    return True


@compiled
def cross_each_other(shape, at, other):
    """Tell whether two triangles cross; corners that they share do not count."""
    for turn in range(2):
        mine, its = (at, other) if turn == 0 else (other, at)
        a, b, c = vector_at(shape, its), vector_at(shape, its + 3), vector_at(shape, its + 6)
        for k in range(3):
            p = vector_at(shape, mine + 3 * k)
            q = vector_at(shape, mine + 3 * ((k + 1) % 3))
            if p == a or p == b or p == c or q == a or q == b or q == c:
                continue
            if pierces(p, q, a, b, c):
                return True
    return overlap_in_plane(shape, at, other)


@compiled
def first_crossing(shape, found):
    """Tell whether triangles of a solid's surface cross; ``found`` (2, 3, 3) gets the first."""
    tree = tree_of(SOLID, shape)
    stack = np.empty((2 * DEEPEST, 2), dtype=np.int64)
    stack[0, 0], stack[0, 1], top = 0, 0, 1
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        if not boxes_meet(shape, tree, i, j):
            continue
        if not is_leaf(tree, i):  # both are on one level
            for turn in range(4):
                k, m = turn // 2, turn % 2
                if i != j or k <= m:
                    stack[top, 0], stack[top, 1] = 2 * i + 1 + k, 2 * j + 1 + m
                    top += 1
            continue
        a, b = i - (tree[1] - 1), j - (tree[1] - 1)
        for s in range(first_of_leaf(tree, a), first_of_leaf(tree, a + 1)):
            for t in range(first_of_leaf(tree, b), first_of_leaf(tree, b + 1)):
                at, other = tree[2] + CORNERS * s, tree[2] + CORNERS * t
                if (s < t or a != b) and cross_each_other(shape, at, other):
                    for c in range(CORNERS):
                        found[0, c // 3, c % 3] = shape[at + c]
                        found[1, c // 3, c % 3] = shape[other + c]
                    return True
    return False
