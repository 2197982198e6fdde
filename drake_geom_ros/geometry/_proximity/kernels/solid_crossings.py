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
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    cross,
    dot,
    norm,
    sub,
    unit,
)
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
def straddles(heights, enough):
    """Tell whether a triangle has corners on both sides of a plane, by their heights over it."""
    x, y, z = heights
    return min(x, y, z) < -enough and max(x, y, z) > enough


@compiled
def part_of_line(shape, at, heights, along):
    """Return where the line in which a triangle meets a plane enters and leaves the triangle.

    ``heights`` are those of its corners over the plane; ``along`` is the line's direction.
    """
    first, last = math.inf, -math.inf
    for k in range(3):
        h, g = heights[k], heights[(k + 1) % 3]
        if h * g <= 0.0 and h != g:
            p = vector_at(shape, at + 3 * k)
            q = vector_at(shape, at + 3 * ((k + 1) % 3))
            place = dot(add_scaled(p, h / (h - g), sub(q, p)), along)
            first, last = min(first, place), max(last, place)
    return first, last


@compiled
def cross_in_line(shape, at, other):
    """Tell whether two triangles go through each other along a line of some length.

    Each has corners on both sides of the other's plane, and the parts of the common line in them
    overlap (Moeller, Journal of Graphics Tools 2 (2), 1997). So it is told of two that meet where
    each has an edge, or a corner, too.
    """
    a, b = vector_at(shape, at), vector_at(shape, other)
    ab, ac = sub(vector_at(shape, at + 3), a), sub(vector_at(shape, at + 6), a)
    n, near_a = unit(cross(ab, ac)), CROSSING * (norm(ab) + norm(ac))
    bc, bd = sub(vector_at(shape, other + 3), b), sub(vector_at(shape, other + 6), b)
    m, near_b = unit(cross(bc, bd)), CROSSING * (norm(bc) + norm(bd))
    over_b = heights_over(shape, at, b, m)
    if not straddles(over_b, near_b):
        return False
    over_a = heights_over(shape, other, a, n)
    if not straddles(over_a, near_a):
        return False
    along = unit(cross(n, m))
    first, last = part_of_line(shape, at, over_b, along)
    begin, end = part_of_line(shape, other, over_a, along)
    return min(last, end) - max(first, begin) > min(near_a, near_b)


@compiled
def heights_over(shape, at, a, n):
    """Return the heights of a triangle's corners over the plane through a with unit normal n."""
    return (
        dot(sub(vector_at(shape, at), a), n),
        dot(sub(vector_at(shape, at + 3), a), n),
        dot(sub(vector_at(shape, at + 6), a), n),
    )


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
                if s >= t and a == b:
                    continue
                if cross_in_line(shape, at, other) or overlap_in_plane(shape, at, other):
                    for c in range(CORNERS):
                        found[0, c // 3, c % 3] = shape[at + c]
                        found[1, c // 3, c % 3] = shape[other + c]
                    return True
    return False
