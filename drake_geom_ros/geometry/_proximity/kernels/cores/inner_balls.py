"""Lower bounds of the depth of two cores, from the depths of a point in both.

For any point c the width of the overlap along n is ``h_A(n) + h_B(-n) = (h_A(n) - n . c) +
(h_B(-n) + n . c)``. So the depth, the least width, is at least the sum of the depths of c in A and
B: each is the radius of the largest ball about c that fits, or minus the distance outside. The sum
has a closed form for primitive shapes. Where one body is smooth or flat around the contact it *is*
the depth: for a box corner or a cylinder's edge within a cylinder, for two barrels, for a face on
anything. Then no polytope is needed. That also holds for rings of equal minima (an axis through
the edge of a box), which EPA would have to cover with faces.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.closed_forms.ellipsoid_point import (
    ellipsoid_point,
)
from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import (
    box_point,
    clamp,
    cylinder_point,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import vertex_at
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import core_radius
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    column,
    norm,
    rotate,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_LENGTH,
    SHAPE_RADIUS,
    SPHERE,
    VERTEX_COUNT,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled

SHARES = (0.5, 0.0, 1.0)  # parameters between a and b
SEARCH_STEPS = 24  # of a line search: each step leaves two thirds, all of them a 17000th


@compiled
def depth_of_point(kind: int, shape: Floats, q: Vector, slack: float) -> tuple[float, bool]:
    """Return (depth, unique) of the point q in a core, in its frame; -infinity for a hull.

    ``unique``: one direction out is shorter than all others by more than ``slack`` [m].
    """
    if kind == BOX:
        distance, _, _, unique = box_point(vector_at(shape, 0), q, slack)
        return -distance, unique and distance < -slack
    if kind == CYLINDER:
        distance, _, _, unique = cylinder_point(shape[SHAPE_RADIUS], shape[HALF_LENGTH], q, slack)
        return -distance, unique and distance < -slack
    if kind == ELLIPSOID:
        e = vector_at(shape, 0)
        distance, _, _, unique = ellipsoid_point(e, q, slack)
        return -distance - core_radius(kind, shape), unique and distance < -slack
    if kind == CAPSULE:
        return -norm((q[0], q[1], q[2] - clamp(q[2], shape[HALF_LENGTH]))), False
    if kind == SPHERE:
        return -norm(q), False
    return -math.inf, False


@compiled
def depth_in_both(pair: CorePair, c: Vector, slack: float) -> tuple[float, bool]:
    """Return (depth, unique): the sum of the depths of the point c, from Ao, in both cores."""
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
    in_A, only_A = depth_of_point(kind_A, shape_A, unrotate(R_WA, c), slack)
    in_B, only_B = depth_of_point(kind_B, shape_B, unrotate(R_WB, sub(c, p)), slack)
    return in_A + in_B, only_A or only_B


@compiled
def depth_between(
    pair: CorePair, a: Vector, b: Vector, slack: float
) -> tuple[float, bool, Vector]:
    """Return (depth, unique, c) of the deepest among a, b and their midpoint."""
    best, unique, at = -math.inf, False, a
    for share in SHARES:
        c = add_scaled(a, share, sub(b, a))
        depth, only = depth_in_both(pair, c, slack)
        if depth > best:
            best, unique, at = depth, only, c
    return best, unique, at


@compiled
def deepest_along(pair: CorePair, c: Vector, u: Vector, reach: float) -> tuple[float, Vector]:
    """Return (depth, c) at the deepest point in both cores on c + t u, t within reach.

    The depth is concave, so the search keeps two thirds of the interval in each step.
    """
    low, high = -reach, reach
    for _ in range(SEARCH_STEPS):
        third = (high - low) / 3.0
        left, _ = depth_in_both(pair, add_scaled(c, low + third, u), 0.0)
        right, _ = depth_in_both(pair, add_scaled(c, high - third, u), 0.0)
        if left < right:
            low += third
        else:
            high -= third
    c = add_scaled(c, 0.5 * (low + high), u)
    depth, _ = depth_in_both(pair, c, 0.0)
    return depth, c


@compiled
def deepest_vertex(
    kind: int, shape: Floats, R: Floats, hull: Floats, R_hull: Floats, p: Vector
) -> float:
    """Return the depth of the deepest vertex of a hull in the core of another shape.

    A vertex is a point of the hull, so its depth in the hull is at least 0. ``p`` is from the
    shape to the hull, in World axes.
    """
    best = -math.inf
    for k in range(1, int(hull[VERTEX_COUNT]) + 1):
        q = add(p, rotate(R_hull, vertex_at(hull, k)))
        depth, _ = depth_of_point(kind, shape, unrotate(R, q), 0.0)
        best = max(best, depth)
    return best


@compiled
def deepest(pair: CorePair, a: Vector, b: Vector, size: float) -> float:
    """Return the depth in both cores of a deep point, searched along axes.

    The search starts from ab and both origins. For a hull only the vertices are tried.
    """
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
    if kind_B == CONVEX:
        return deepest_vertex(kind_A, shape_A, R_WA, shape_B, R_WB, p)
    _, _, middle = depth_between(pair, a, b, 0.0)
    best = -math.inf
    for start in (middle, (0.0, 0.0, 0.0), pair.p_AB):
        c = start
        depth, _ = depth_in_both(pair, c, 0.0)
        for k in range(12):
            u = column(pair.R_WA if k % 6 < 3 else pair.R_WB, k % 3)
            depth_there, x = deepest_along(pair, c, u, size)
            if depth_there > depth:
                depth, c = depth_there, x
        best = max(best, depth)
    return best
