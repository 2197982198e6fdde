"""The distance of a leaf of A from a leaf of B, and whether they cross.

GJK answers a pair of leaves, with a certificate; a closed form answers the centre of a sphere.
Slabs between the leaves distinguish leaves that touch to rounding from leaves that cross: a face
that lies flush on another crosses nothing. Boxes, or one slab, exclude most pairs before, as too
far apart.
"""

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import (
    BEYOND_CUTOFF,
    CLOSED,
    OVERLAP,
    distance_of_cores,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Separation
from drake_geom_ros.geometry._proximity.kernels.cores.simplices import (
    closest_on_triangle,
    weighted,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import support
from drake_geom_ros.geometry._proximity.kernels.solids.separating_axes import widest_slab
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    Solid,
    SolidPair,
    TreeBody,
    noise_of,
    normal_of,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import outside
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    cross,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID, SPHERE, TRIANGLE
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import NEAR_TOUCH, SHARPER


class Leaf(NamedTuple):
    """A leaf in B's axes: the corners of a triangle, and the box around it; of a core its box."""

    a: Vector
    b: Vector
    c: Vector
    middle: Vector
    half: Vector


@inlined
def around(a: Vector, b: Vector, c: Vector) -> Leaf:
    """Return the leaf of a triangle."""
    low = min(a[0], b[0], c[0]), min(a[1], b[1], c[1]), min(a[2], b[2], c[2])
    high = max(a[0], b[0], c[0]), max(a[1], b[1], c[1]), max(a[2], b[2], c[2])
    middle = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])
    half = 0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2])
    return Leaf(a, b, c, middle, half)


@compiled
def leaf_of_A(pair: SolidPair, i: int) -> Leaf:
    """Return A's core, or its triangle i, as a leaf."""
    A, R = pair.A, pair.A.R
    if A.kind == SOLID:
        at = A.tree.corners + CORNERS * i
        a = add(rotate(R, vector_at(A.shape, at)), pair.p)
        b = add(rotate(R, vector_at(A.shape, at + 3)), pair.p)
        return around(a, b, add(rotate(R, vector_at(A.shape, at + 6)), pair.p))
    h, middle = A.box.half, add(rotate(R, A.box.middle), pair.p)
    half = (
        abs(R[0, 0]) * h[0] + abs(R[0, 1]) * h[1] + abs(R[0, 2]) * h[2],
        abs(R[1, 0]) * h[0] + abs(R[1, 1]) * h[1] + abs(R[1, 2]) * h[2],
        abs(R[2, 0]) * h[0] + abs(R[2, 1]) * h[1] + abs(R[2, 2]) * h[2],
    )
    return Leaf(middle, middle, middle, middle, half)


@compiled
def leaf_of_B(B: Solid, j: int) -> Leaf:
    """Return B's triangle j as a leaf."""
    at = B.tree.corners + CORNERS * j
    return around(vector_at(B.shape, at), vector_at(B.shape, at + 3), vector_at(B.shape, at + 6))


@inlined
def gap_of_leaves(leaf_A: Leaf, leaf_B: Leaf, is_core: bool) -> float:
    """Return a lower bound of the distance of two leaves, by their boxes and one slab.

    It is right to some roundings of the pair's size, less than ``noise_of``.
    """
    between = sub(leaf_B.middle, leaf_A.middle)
    boxes = norm(
        (
            outside(between[0], leaf_A.half[0] + leaf_B.half[0]),
            outside(between[1], leaf_A.half[1] + leaf_B.half[1]),
            outside(between[2], leaf_A.half[2] + leaf_B.half[2]),
        )
    )
    if is_core or dot(between, between) == 0.0:
        return boxes
    u = between
    begin = min(dot(leaf_B.a, u), dot(leaf_B.b, u), dot(leaf_B.c, u))
    end = max(dot(leaf_A.a, u), dot(leaf_A.b, u), dot(leaf_A.c, u))
    return max(boxes, (begin - end) / norm(u))


@inlined
def least_over(u: Vector, a: Vector, b: Vector, c: Vector) -> float:
    """Return the least of three points along u."""
    return min(dot(a, u), dot(b, u), dot(c, u))


@compiled
def normal_of_leaf(leaf: Leaf) -> Vector:
    """Return the outward unit normal of a triangle, or the zero vector if it has no area."""
    return unit(cross(sub(leaf.b, leaf.a), sub(leaf.c, leaf.a)))


@compiled
def gap_over_planes(pair: SolidPair, leaf_A: Leaf, leaf_B: Leaf) -> tuple[float, Vector]:
    """Return (gap, n): a lower bound of the distance of leaves, by the planes of their triangles.

    It is the height of one leaf over the plane of the other, along the unit n from A to B. For
    parallel faces opposite each other it is the distance. Negative if no plane separates them.
    """
    up = normal_of_leaf(leaf_B)
    down = scale(-1.0, up)
    if pair.A.kind != SOLID:
        lowest = add(pair.p, support(pair.A.kind, pair.A.shape, pair.A.R, down, 0.0))
        return dot(sub(lowest, leaf_B.a), up), down
    gap = least_over(up, sub(leaf_A.a, leaf_B.a), sub(leaf_A.b, leaf_B.a), sub(leaf_A.c, leaf_B.a))
    out = normal_of_leaf(leaf_A)
    other = least_over(
        out, sub(leaf_B.a, leaf_A.a), sub(leaf_B.b, leaf_A.a), sub(leaf_B.c, leaf_A.a)
    )
    return (gap, down) if gap >= other else (other, out)


@compiled
def leaf_pair(A: TreeBody, i: int, B: Solid, j: int, p: Vector) -> CorePair:
    """Return the pair, as GJK takes it, of A's core or triangle i and of B's triangle j."""
    kind, shape = A.kind, A.shape
    if kind == SOLID:
        at = A.tree.corners + CORNERS * i
        kind, shape = TRIANGLE, shape[at : at + CORNERS]
    at = B.tree.corners + CORNERS * j
    corners = B.shape[at : at + CORNERS]
    return CorePair(kind, shape, A.R, TRIANGLE, corners, B.identity, scale(-1.0, p))


@compiled
def separation_of_point(q: Vector, B: Solid, j: int, noise: float) -> tuple[float, Vector, Vector]:
    """Return (d, n, b) for the point b of triangle j nearest to q, at d along the unit n."""
    at = B.tree.corners + CORNERS * j
    x = sub(vector_at(B.shape, at), q)
    y, z = sub(vector_at(B.shape, at + 3), q), sub(vector_at(B.shape, at + 6), q)
    v = weighted(x, y, z, closest_on_triangle(x, y, z))
    d = norm(v)
    if d > noise:
        return d, unit(v), add(q, v)
    n = scale(-1.0, normal_of(B.shape, B.tree, j))
    if dot(n, n) < 0.5:
        n = (-1.0, 0.0, 0.0)
    return d, n, add(q, v)


@compiled
def separation_of_leaves(
    together: SolidPair, i: int, j: int, n: Vector, limit: float
) -> Separation:
    """Return the separation of leaf i of A and leaf j of B as GJK does, with a and b from Bo.

    GJK begins with the direction n; it may end early if they are farther apart than ``limit`` [m].
    """
    A, B, p, size, tolerance, _ = together
    noise = noise_of(together)
    if A.kind == SPHERE:
        d, n, b = separation_of_point(p, B, j, noise)
        return Separation(CLOSED if d <= limit else BEYOND_CUTOFF, d, d, n, p, b, n)
    pair = leaf_pair(A, i, B, j, p)
    end, upper, lower, n, a, b, n_lower = distance_of_cores(
        pair, n, size, SHARPER * tolerance, limit
    )
    apart = end != OVERLAP and end != BEYOND_CUTOFF
    if apart and upper - lower > max(tolerance, noise):
        # A thin simplex lost its last digits (curved cores, triangles of km): with a new one the
        # walk goes on.
        again = distance_of_cores(pair, n, size, SHARPER * tolerance, limit)
        closed = again.end != OVERLAP and again.end != BEYOND_CUTOFF
        if closed and again.upper - again.lower < upper - lower:
            end, upper, lower, n, a, b, n_lower = again
    if end == OVERLAP or (apart and upper <= NEAR_TOUCH * size):
        width, m = widest_slab(A, i, B, j, p, noise, math.inf)
        if end == OVERLAP or width > lower:
            n, n_lower, lower = m, m, width
        apart = apart or lower >= -noise
    if apart:
        end = CLOSED
    return Separation(end, upper, lower, n, add(p, a), add(p, b), n_lower)


@compiled
def separation_within(pair: SolidPair, i: int, j: int, n: Vector, limit: float) -> Separation:
    """Return what ``separation_of_leaves`` does, for a limit [m] about 0.

    Most triangles are beyond it, or cross, which their axes decide faster than GJK; of those that
    cross the rest of the record is meaningless.
    """
    A, B, p, noise = pair.A, pair.B, pair.p, noise_of(pair)
    if A.kind == SOLID:
        width, m = widest_slab(A, i, B, j, p, noise, limit)
        if width > limit:
            return Separation(BEYOND_CUTOFF, math.inf, width, m, p, p, m)
        if width < -noise:
            return Separation(OVERLAP, 0.0, width, m, p, p, m)
    return separation_of_leaves(pair, i, j, n, limit)
