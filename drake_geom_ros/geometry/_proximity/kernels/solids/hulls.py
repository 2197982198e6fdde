"""Convex hulls of two bodies: they hold the bodies, so what separates them separates the bodies.

Bodies are given as in ``distance``.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import vertex_at
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import local_support, support
from drake_geom_ros.geometry._proximity.kernels.solids.solid import PLANE, SolidPair, TreeBody
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    column,
    dot,
    rotate,
    scale,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SOLID, VERTEX_COUNT
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled


@compiled
def middle_of(A: TreeBody, p: Vector) -> Vector:
    """Return a point of A's core, inside where that has a volume, from Bo."""
    if A.kind != CONVEX:
        return p
    middle, count = (0.0, 0.0, 0.0), int(A.shape[VERTEX_COUNT])
    for k in range(1, count + 1):
        middle = add_scaled(middle, 1.0 / count, vertex_at(A.shape, k))
    return add(p, rotate(A.R, middle))


@compiled
def hull_support(A: TreeBody, n: Vector) -> Vector:
    """Return the point of A's core, or of its hull, that is extreme along n, from Ao in B."""
    if A.kind == SOLID:
        return rotate(A.R, local_support(CONVEX, A.shape, unrotate(A.R, n), 0.0))
    return support(A.kind, A.shape, A.R, n, 0.0)


@compiled
def width_of_hulls(pair: SolidPair, m: Vector, radius: float) -> float:
    """Return how far A, grown by ``radius``, must move along m to be beyond B's hull [m]."""
    b = local_support(CONVEX, pair.B.shape, m, 0.0)
    a = add(pair.p, hull_support(pair.A, scale(-1.0, m)))
    return dot(sub(b, a), m) + radius


@compiled
def separating_move_of_hulls(pair: SolidPair) -> tuple[Vector, float]:
    """Return (m, s): the shortest of some moves by s along m that separate the hulls.

    It tries the normals of their largest faces and the axes of A; no direction is wrong.
    """
    A, B, radius = pair.A, pair.B, pair.radius
    best, best_m = math.inf, (1.0, 0.0, 0.0)
    for side in range(2):
        body_shape, tree = (B.shape, B.tree) if side == 0 else (A.shape, A.tree)
        for k in range(tree.planes):
            m = vector_at(body_shape, tree.planes_at + PLANE * k)
            if side == 1:
                m = scale(-1.0, rotate(A.R, m))
            s = width_of_hulls(pair, m, radius)
            if s < best:
                best, best_m = s, m
    for k in range(6):
        m = scale(1.0 - 2.0 * (k % 2), column(A.R, k // 2))
        s = width_of_hulls(pair, m, radius)
        if s < best:
            best, best_m = s, m
    return best_m, best
