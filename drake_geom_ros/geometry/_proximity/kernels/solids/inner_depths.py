"""Lower bounds of the depth of bodies in each other: balls in both about one point.

A ball of A around a point that lies at depth d in B moves at least its radius plus d before A is
out. Candidates are the deepest points of A in contacts, and its middle. Bodies are given as in
``distance``.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.shapes.supports import support
from drake_geom_ros.geometry._proximity.kernels.solids.contacts import (
    CLOSE_WIDTH,
    LEAF_A,
    LEAF_B,
    close_pairs,
)
from drake_geom_ros.geometry._proximity.kernels.solids.containment import FLUSH
from drake_geom_ros.geometry._proximity.kernels.solids.lane_tree import lane_tree_of
from drake_geom_ros.geometry._proximity.kernels.solids.nearest_triangles import (
    FEW,
    nearest_triangles,
    rounding_at,
    scratch_for,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    Solid,
    SolidPair,
    middle_of_triangle,
    moved,
    noise_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.to_points import (
    INSIDE,
    first_of,
    side_of_surface,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import box_of_node
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    norm,
    rotate,
    scale,
    sub,
    unrotate,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HALF_LENGTH,
    SHAPE_RADIUS,
    SOLID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import RIGHT_ANGLE

MOST_MIDDLES = 16  # of touching triangles that are tried


@allocating
def depth_in_solid(B: Solid, q: Vector) -> float:
    """Return how deep q lies in B [m], or less: negative outside and where the side is unknown."""
    shape, tree = B.shape, B.tree
    lanes, extent = lane_tree_of(tree), 2.0 * norm(box_of_node(shape, tree, 0).half)
    scratch = scratch_for(lanes, FEW)
    count = nearest_triangles(shape, tree, lanes, q, extent, scratch)
    while count < 0:
        scratch = scratch_for(lanes, 2 * scratch.triangles.size)
        count = nearest_triangles(shape, tree, lanes, q, extent, scratch)
    distance = scratch.away[first_of(count, scratch)]
    noise = rounding_at(distance, extent)
    inside = side_of_surface(shape, tree, q, distance, noise, count, scratch) == INSIDE
    return distance if inside else -distance


@compiled
def depth_in_body(pair: SolidPair, x: Vector) -> float:
    """Return how deep x, in B's frame, lies in A [m], or less: minus infinity where unknown."""
    A, radius = pair.A, pair.radius
    q = unrotate(A.R, sub(x, pair.p))
    kind, shape = A.kind, A.shape
    if kind == SOLID:
        return depth_in_solid(Solid(shape, A.tree, pair.B.identity), q)
    if kind == CAPSULE:
        return radius - norm((q[0], q[1], max(abs(q[2]) - shape[HALF_LENGTH], 0.0)))
    if kind == SPHERE:
        return radius - norm(q)
    depth = -math.inf
    if kind == BOX:
        depth = min(shape[0] - abs(q[0]), shape[1] - abs(q[1]), shape[2] - abs(q[2]))
    if kind == CYLINDER:
        depth = min(shape[SHAPE_RADIUS] - math.hypot(q[0], q[1]), shape[HALF_LENGTH] - abs(q[2]))
    if kind == ELLIPSOID:  # a smaller one around x, of the same proportions, fits
        level = norm((q[0] / shape[0], q[1] / shape[1], q[2] / shape[2]))
        depth = (1.0 - level) * min(shape[0], shape[1], shape[2])
    return depth if depth >= 0.0 else -math.inf


@compiled
def deepest_at(pair: SolidPair, x: Vector) -> float:
    """Return a lower bound of the depth [m]: by balls of A and of B around a point x of either.

    Balls of radius a in A and b in B about one point are apart only after a move by a + b. With x
    at a distance d out of A, a is -d: a ball of radius b - d in B is about A's nearest point then.
    """
    return depth_in_body(pair, x) + depth_in_solid(pair.B, x)


@allocating
def deepest_touching(pair: SolidPair, t: Vector, contact: tuple[Vector, Vector, Vector]) -> float:
    """Return a lower bound of the depth [m] by points near where A touches after the move by t.

    They are the points a of A's core and b of B's surface that touch then, the point half-way
    between them before the move, and the middles of what touches: of a core the lowest face, of
    solids the triangles. A corner that touches may be no deeper than a wall beside it. ``contact``
    is (a, b, m), m out of B.
    """
    A, B, radius, (a, b, m) = pair.A, pair.B, pair.radius, contact
    least = radius + depth_in_solid(B, sub(a, t))
    least = max(least, deepest_at(pair, b), deepest_at(pair, add_scaled(b, -0.5, t)))
    if A.kind != SOLID:
        lowest = add(pair.p, support(A.kind, A.shape, A.R, scale(-1.0, m), RIGHT_ANGLE))
        return max(least, radius + depth_in_solid(B, lowest))
    close = np.empty((MOST_MIDDLES, CLOSE_WIDTH))
    there, near = moved(pair, t), FLUSH * noise_of(pair)
    for k in range(close_pairs(there, scale(-1.0, m), near, close)):
        x = add(pair.p, rotate(A.R, middle_of_triangle(A.shape, A.tree, int(close[k, LEAF_A]))))
        y = middle_of_triangle(B.shape, B.tree, int(close[k, LEAF_B]))
        least = max(least, depth_in_solid(B, x), depth_in_body(pair, y))
    return least
