"""Crossings of a solid's surface with itself, of which there must be none.

Triangles that go through each other are found by pairs. Where surfaces cross along an edge of a
triangle none goes through another, and triangles that touch look alike: winding numbers decide
(``winding.find_astray``), and this module finds the triangles to decide about.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import (
    BEYOND_CUTOFF,
    distance_of_cores,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.cores.simplices import (
    closest_on_triangle,
    weighted,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    Tree,
    first_of_leaf,
    tree_of,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import LOWER, NODE_WIDTH, UPPER
from drake_geom_ros.geometry._proximity.kernels.trees.walks import DEEPEST, is_leaf
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    cross,
    dot,
    norm,
    sub,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID, TRIANGLE
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import CROSSING, EPS, ROUNDING

# How two triangles meet.
APART = 0
TOUCHING = 1
CROSSED = 2


class TrianglePlane(NamedTuple):
    """The plane of a triangle through its corner p, with the unit normal n.

    Heights over it count from ``near`` [m] on, for vertices may be in single precision, and
    ``noise`` [m] is what rounding makes of them.
    """

    p: Vector
    n: Vector
    near: float
    noise: float


@compiled
def rounding_of_corners(shape: Floats, tree: Tree) -> float:
    """Return how far rounding may move equal corners apart [m]: some of their spacings."""
    largest = 0.0
    for c in range(3):
        at = tree.nodes + c
        largest = max(largest, abs(shape[at + LOWER]), abs(shape[at + UPPER]))
    return ROUNDING * EPS * largest


@compiled
def boxes_meet(shape: Floats, tree: Tree, i: int, j: int, apart: float) -> bool:
    """Return whether the boxes of two nodes are no more than ``apart`` from each other.

    No crossing is lost by what this leaves out. A point that two triangles have in common is in
    both boxes, whose ends are coordinates of corners, compared and not computed with; and faces
    that lie on each other to rounding are not farther apart than that.
    """
    a, b = tree.nodes + NODE_WIDTH * i, tree.nodes + NODE_WIDTH * j
    for c in range(3):
        if shape[a + LOWER + c] - shape[b + UPPER + c] > apart:
            return False
        if shape[b + LOWER + c] - shape[a + UPPER + c] > apart:
            return False
    return True


@compiled
def triangles_may_meet(shape: Floats, at: int, other: int, apart: float) -> bool:
    """Return whether the boxes of two triangles are no more than ``apart`` from each other."""
    for c in range(3):
        a, b = at + c, other + c
        low_a, high_a = least_and_largest(shape[a], shape[a + 3], shape[a + 6])
        low_b, high_b = least_and_largest(shape[b], shape[b + 3], shape[b + 6])
        if low_a - high_b > apart or low_b - high_a > apart:
            return False
    return True


@inlined
def least_and_largest(x: float, y: float, z: float) -> tuple[float, float]:
    """Return the least and the largest of three numbers."""
    return min(x, y, z), max(x, y, z)


@compiled
def bluntest_corner(shape: Floats, at: int) -> int:
    """Return which corner of a triangle, 0 to 2, lies opposite its longest edge."""
    best, longest = 0, -1.0
    for k in range(3):
        p = vector_at(shape, at + 3 * ((k + 1) % 3))
        length = norm(sub(vector_at(shape, at + 3 * ((k + 2) % 3)), p))
        if length > longest:
            best, longest = k, length
    return best


@compiled
def plane_of(shape: Floats, at: int, other: int, apart: float) -> TrianglePlane:
    """Return the plane of a triangle, with the rounding of heights of the corners at ``other``.

    All corners are as much as ``apart`` off, and the edges u and v at a corner leave an error of
    EPS |u| |v| in their product. So from its bluntest corner even a needle has a sharp normal.
    """
    k = bluntest_corner(shape, at)
    a = vector_at(shape, at + 3 * k)
    u = sub(vector_at(shape, at + 3 * ((k + 1) % 3)), a)
    v = sub(vector_at(shape, at + 3 * ((k + 2) % 3)), a)
    product, reach, noise = cross(u, v), 0.0, apart
    for c in range(3):
        reach = max(reach, norm(sub(vector_at(shape, other + 3 * c), a)))
    if norm(product) > 0.0:
        noise += ROUNDING * EPS * reach * (norm(u) * (norm(v) / norm(product)))
    return TrianglePlane(a, unit(product), CROSSING * (norm(u) + norm(v)), noise)


@compiled
def heights_over(shape: Floats, at: int, plane: TrianglePlane) -> Vector:
    """Return the heights of a triangle's corners over a plane."""
    return (
        dot(sub(vector_at(shape, at), plane.p), plane.n),
        dot(sub(vector_at(shape, at + 3), plane.p), plane.n),
        dot(sub(vector_at(shape, at + 6), plane.p), plane.n),
    )


@compiled
def straddles(heights: Vector, enough: float) -> bool:
    """Return whether a triangle has corners on both sides of a plane, by their heights over it."""
    return min(heights) < -enough and max(heights) > enough


@compiled
def is_beyond(heights: Vector, enough: float) -> bool:
    """Return whether a triangle is on one side of a plane, by their heights over it."""
    return min(heights) > enough or max(heights) < -enough


@compiled
def part_of_line(
    corners: tuple[Vector, Vector, Vector], heights: Vector, origin: Vector, along: Vector
) -> tuple[float, float]:
    """Return where the line in which a triangle meets a plane enters and leaves the triangle.

    ``heights`` are those of its corners over the plane; ``along`` is the line's direction.
    """
    first, last = math.inf, -math.inf
    for k in range(3):
        h, g = heights[k], heights[(k + 1) % 3]
        if h * g <= 0.0 and h != g:
            p, q = sub(corners[k], origin), sub(corners[(k + 1) % 3], origin)
            place = dot(add_scaled(p, h / (h - g), sub(q, p)), along)
            first, last = min(first, place), max(last, place)
    return first, last


@inlined
def corners_at(shape: Floats, at: int) -> tuple[Vector, Vector, Vector]:
    """Return the corners of the triangle that is at ``at``."""
    return vector_at(shape, at), vector_at(shape, at + 3), vector_at(shape, at + 6)


@compiled
def cross_in_line(
    shape: Floats,
    at: int,
    other: int,
    planes: tuple[TrianglePlane, TrianglePlane],
    heights: tuple[Vector, Vector],
) -> bool:
    """Return whether two triangles go through each other along a line of some length.

    Each has corners on both sides of the other's plane, and the parts of the common line in them
    overlap (Moeller, Journal of Graphics Tools 2 (2), 1997). This also holds for two that meet
    where each has an edge or a corner. ``heights`` are those of the second triangle's corners over
    the plane of the first, and the reverse.
    """
    (plane_A, plane_B), (over_A, over_B) = planes, heights
    if not straddles(over_B, max(plane_B.near, plane_B.noise)):
        return False
    if not straddles(over_A, max(plane_A.near, plane_A.noise)):
        return False
    along = unit(cross(plane_A.n, plane_B.n))
    first, last = part_of_line(corners_at(shape, at), over_B, plane_A.p, along)
    begin, end = part_of_line(corners_at(shape, other), over_A, plane_A.p, along)
    return min(last, end) - max(first, begin) > min(plane_A.near, plane_B.near)


@compiled
def overlap_in_plane(shape: Floats, at: int, other: int, n: Vector, enough: float) -> bool:
    """Return whether two triangles of one plane with the normal n have an area in common.

    They have none if all of one is beyond an edge of the other, to ``enough``: where two convex
    polygons are apart, a line along an edge of one of them separates them.
    """
    for turn in range(2):
        at_A, at_B = (at, other) if turn == 0 else (other, at)
        for k in range(3):
            p = vector_at(shape, at_A + 3 * k)
            edge = sub(vector_at(shape, at_A + 3 * ((k + 1) % 3)), p)
            side = unit(cross(edge, n))
            third = dot(sub(vector_at(shape, at_A + 3 * ((k + 2) % 3)), p), side)
            out = 1.0 if third <= 0.0 else -1.0
            nearest = math.inf
            for c in range(3):
                nearest = min(nearest, out * dot(sub(vector_at(shape, at_B + 3 * c), p), side))
            if nearest >= -enough:
                return False
    return True


@compiled
def is_corner(shape: Floats, p: Vector, at: int) -> bool:
    """Return whether a point is a corner of a triangle."""
    for k in range(3):
        if p == vector_at(shape, at + 3 * k):
            return True
    return False


@compiled
def corner_touches(shape: Floats, at: int, other: int, near: float) -> bool:
    """Return whether a corner of a triangle, but one of both, is within ``near`` of another."""
    for k in range(3):
        p = vector_at(shape, at + 3 * k)
        if is_corner(shape, p, other):
            continue
        a, b = sub(vector_at(shape, other), p), sub(vector_at(shape, other + 3), p)
        c = sub(vector_at(shape, other + 6), p)
        if norm(weighted(a, b, c, closest_on_triangle(a, b, c))) <= near:
            return True
    return False


@allocating
def touch(shape: Floats, at: int, other: int, near: float) -> bool:
    """Return whether two triangles are within ``near`` elsewhere than in a common corner or edge.

    Of two with a corner in common, edges may cross far from any corner of either: then the edge
    goes on into a neighbour that has none in common, or ends within it.
    """
    common = 0
    for k in range(3):
        common += is_corner(shape, vector_at(shape, at + 3 * k), other)
    if common == 1:
        return corner_touches(shape, at, other, near) or corner_touches(shape, other, at, near)
    if common > 1:
        return False
    identity, origin = np.eye(3), (0.0, 0.0, 0.0)
    first, second = shape[at : at + CORNERS], shape[other : other + CORNERS]
    pair = CorePair(TRIANGLE, first, identity, TRIANGLE, second, identity, origin)
    n = sub(vector_at(shape, other), vector_at(shape, at))
    size = max(norm(vector_at(shape, at)), norm(vector_at(shape, other)))
    return distance_of_cores(pair, unit(n), size, near, near).end != BEYOND_CUTOFF


@compiled
def meeting(shape: Floats, at: int, other: int, apart: float) -> int:
    """Return how two triangles meet: APART, TOUCHING (beyond what they share) or CROSSED.

    Only triangles that are proven apart, by a plane and more than rounding, are passed over.
    """
    plane_A, plane_B = plane_of(shape, at, other, apart), plane_of(shape, other, at, apart)
    above_A, above_B = heights_over(shape, other, plane_A), heights_over(shape, at, plane_B)
    if is_beyond(above_A, max(plane_A.near, plane_A.noise)):
        return APART
    if is_beyond(above_B, max(plane_B.near, plane_B.noise)):
        return APART
    if cross_in_line(shape, at, other, (plane_A, plane_B), (above_A, above_B)):
        return CROSSED
    flat = max(above_A) <= plane_A.noise and min(above_A) >= -plane_A.noise
    if flat and overlap_in_plane(shape, at, other, plane_A.n, plane_A.noise):
        return CROSSED
    return TOUCHING if touch(shape, at, other, max(plane_A.near, plane_B.near)) else APART


@allocating
def first_crossing(shape: Floats, crossing: Floats, touching: Booleans) -> bool:
    """Return whether triangles of a solid's surface cross; ``crossing`` (2, 3, 3) gets the first.

    ``touching`` (n,) gets which touch others, where they share neither edge nor corner.
    """
    tree = tree_of(SOLID, shape)
    apart = rounding_of_corners(shape, tree)
    stack = np.empty((2 * DEEPEST, 2), dtype=np.int64)
    stack[0, 0], stack[0, 1], top = 0, 0, 1
    while top > 0:
        top -= 1
        i, j = stack[top, 0], stack[top, 1]
        if not boxes_meet(shape, tree, i, j, apart):
            continue
        if not is_leaf(tree, i):  # both are on one level
            for turn in range(4):
                k, m = turn // 2, turn % 2
                if i != j or k <= m:
                    stack[top, 0], stack[top, 1] = 2 * i + 1 + k, 2 * j + 1 + m
                    top += 1
            continue
        a, b = i - (tree.leaves - 1), j - (tree.leaves - 1)
        for s in range(first_of_leaf(tree, a), first_of_leaf(tree, a + 1)):
            for t in range(first_of_leaf(tree, b), first_of_leaf(tree, b + 1)):
                at, other = tree.corners + CORNERS * s, tree.corners + CORNERS * t
                if (s >= t and a == b) or not triangles_may_meet(shape, at, other, apart):
                    continue
                how = meeting(shape, at, other, apart)
                if how != APART:
                    touching[s] = touching[t] = True
                if how == CROSSED:
                    for c in range(CORNERS):
                        crossing[0, c // 3, c % 3] = shape[at + c]
                        crossing[1, c // 3, c % 3] = shape[other + c]
                    return True
    return False
