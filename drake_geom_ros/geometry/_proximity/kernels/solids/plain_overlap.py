"""Plain overlaps of a core or a solid with a solid: a depth that is proved, and no translation.

A collision query needs one proof. The least separating translation of a solid, which a penetration
query returns, takes a hundred times as long to find (``overlap``). So first the same balls are
tried as there, about a few points: the middle of a core, points just beneath where surfaces cross,
and of bodies that do not cross a point of each; and boxes within both, where only walls touch.
What they leave open the pair's kernel decides.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    Aim,
    OrientedShape,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import inner_radius
from drake_geom_ros.geometry._proximity.kernels.solids.contacts import (
    APART,
    CLOSE_WIDTH,
    CROSSES,
    LEAF_A,
    LEAF_B,
    close_pairs,
)
from drake_geom_ros.geometry._proximity.kernels.solids.crossings import part_of_line
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import (
    middle_of,
    separating_move_of_hulls,
)
from drake_geom_ros.geometry._proximity.kernels.solids.inner_boxes import boxes_in, boxes_of
from drake_geom_ros.geometry._proximity.kernels.solids.inner_depths import (
    deepest_at,
    depth_in_solid,
)
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import (
    Leaf,
    leaf_of_A,
    leaf_of_B,
    normal_of_leaf,
    separation_of_point,
)
from drake_geom_ros.geometry._proximity.kernels.solids.pairs import posed_pair
from drake_geom_ros.geometry._proximity.kernels.solids.separations import least_parting
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    SolidPair,
    middle_of_triangle,
    noise_of,
    normal_of,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
)
from drake_geom_ros.geometry._proximity.kinds import BOX, SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined

# Roundings that a depth must exceed to be plain: more than those for which ``containment`` may
# take an overlap for a touch, and by which ``pairs`` separates bodies that touch.
PLAIN = 128.0
MOST_CROSSINGS = 4  # pairs of leaves that are examined
MOST_STEPS = 6  # inwards from where surfaces cross
SHORTER = 0.125  # each step over the one before


@inlined
def heights_over(corners: tuple[Vector, Vector, Vector], p: Vector, n: Vector) -> Vector:
    """Return the heights of points over the plane through p with the unit normal n."""
    a, b, c = corners
    return dot(sub(a, p), n), dot(sub(b, p), n), dot(sub(c, p), n)


@compiled
def middle_of_crossing(leaf_A: Leaf, leaf_B: Leaf) -> Vector:
    """Return the middle of the segment that two triangles which cross have in common.

    For others it is any point, or not finite.
    """
    n, m = normal_of_leaf(leaf_A), normal_of_leaf(leaf_B)
    T, S, along = (leaf_A.a, leaf_A.b, leaf_A.c), (leaf_B.a, leaf_B.b, leaf_B.c), unit(cross(n, m))
    first, last = part_of_line(T, heights_over(T, leaf_B.a, m), leaf_A.a, along)
    begin, end = part_of_line(S, heights_over(S, leaf_A.a, n), leaf_A.a, along)
    # The point of the line nearest to leaf_A.a: up leaf_A's own plane to that of the other.
    up = cross(n, along)
    steep = dot(up, m)
    if steep == 0.0:
        return math.nan, math.nan, math.nan
    rise = dot(sub(leaf_B.a, leaf_A.a), m) / steep
    middle = 0.5 * (max(first, begin) + min(last, end))
    return add_scaled(add_scaled(leaf_A.a, rise, up), middle, along)


@allocating
def beneath(pair: SolidPair, i: int, j: int) -> tuple[Vector, Vector, float]:
    """Return (x, m, s): a point where leaves i and j cross, the way inwards from it, a length."""
    A, B = pair.A, pair.B
    leaf_A, leaf_B = leaf_of_A(pair, i), leaf_of_B(B, j)
    size = norm(leaf_B.half)
    if A.kind != SOLID:
        q = middle_of(A, pair.p)
        _, _, b = separation_of_point(q, B, j, noise_of(pair))
        return b, scale(-1.0, normal_of(B.shape, B.tree, j)), size
    inwards = scale(-1.0, add(normal_of_leaf(leaf_A), normal_of_leaf(leaf_B)))
    return middle_of_crossing(leaf_A, leaf_B), unit(inwards), min(size, norm(leaf_A.half))


@allocating
def depth_at_crossing(pair: SolidPair, i: int, j: int, enough: float) -> float:
    """Return a depth [m] that is proved where leaves i of A and j of B cross, -inf without one."""
    x, m, s = beneath(pair, i, j)
    least = -math.inf
    if not math.isfinite(dot(x, x)):  # of parallel planes, or a triangle without area
        return least
    for _ in range(MOST_STEPS):
        least = max(least, deepest_at(pair, add_scaled(x, s, m)))
        if not least <= enough:
            break
        s *= SHORTER
    return least


@allocating
def depth_of_boxes(pair: SolidPair) -> float:
    """Return a depth [m] by boxes within the bodies, or 0: it finds overlaps of flush walls."""
    A, B = pair.A, pair.B
    if A.kind != SOLID and A.kind != BOX:
        return 0.0
    _, longest = separating_move_of_hulls(pair)
    boxes = boxes_of(A), boxes_in(B.shape, B.tree)
    parting = least_parting(boxes, A.R, pair.p, (longest, 0.0), noise_of(pair))
    return min(parting.lower, longest)


@allocating
def plain_depth(pair: SolidPair, enough: float) -> float:
    """Return a lower bound of the depth [m] of A and B, by the first proof of ``enough``."""
    A, B, p, radius = pair.A, pair.B, pair.p, pair.radius
    if A.kind != SOLID:
        ball = max(radius, inner_radius(A.kind, A.shape))
        least = ball + depth_in_solid(B, middle_of(A, p))
        if least > enough:
            return least
    n = unit(scale(-1.0, p)) if norm(p) > 0.0 else (1.0, 0.0, 0.0)
    close = np.empty((MOST_CROSSINGS, CLOSE_WIDTH))
    count = close_pairs(pair, n, radius, close)
    for k in range(count):
        i, j = int(close[k, LEAF_A]), int(close[k, LEAF_B])
        if close[k, CROSSES] == 0.0:  # of A's core, and its ball is deeper
            least = radius - close[k, APART]
        else:
            least = depth_at_crossing(pair, i, j, enough)
        if least > enough:
            return least
    if A.kind == SOLID and count == 0:
        least = depth_in_solid(B, add(p, rotate(A.R, middle_of_triangle(A.shape, A.tree, 0))))
        if least > enough:
            return least
        return deepest_at(pair, middle_of_triangle(B.shape, B.tree, 0))
    return depth_of_boxes(pair)


@allocating
def plain_overlap(
    shaped_A: OrientedShape, shaped_B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write minus a certified depth of any bounded shape in a solid, as DISTANCE, or 0.

    Below 0 it is certain that the pair's kernel reports an overlap; from 0 nothing follows.
    """
    pair = posed_pair(shaped_A, shaped_B, p_AB_W, aim.tolerance)
    enough = PLAIN * noise_of(pair)
    least = plain_depth(pair, enough)
    out[DISTANCE] = -least if least > enough else 0.0
