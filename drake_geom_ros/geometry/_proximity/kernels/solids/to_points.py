"""A solid against many points: the nearest triangle, and the side of it that the point is on.

The distance is that of the nearest triangle. Let b be the point nearest to q on the surface; then
nothing of the surface is between them, so q is inside where the segment from b to q begins inside.
About b the surface is a fan of triangles, or one: seen along the segment, the triangle first met
when one turns away from it decides, and so do all that b is on, where they agree. They mostly do.
Where not, at the tip of a needle say, the winding number decides; and where rounding leaves it
open even so, the error bound includes both signs.
"""

import math
from typing import Any

from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    PointAnswers,
    PointedBody,
    Span,
    put_point,
    seen,
)
from drake_geom_ros.geometry._proximity.kernels.solids.lane_tree import lane_tree_of
from drake_geom_ros.geometry._proximity.kernels.solids.nearest_triangles import (
    FEW,
    FULL,
    PointScratch,
    nearest_triangles,
    rounding_at,
    scratch_for,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    Tree,
    normal_of,
    tree_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.winding import (
    FIRST_RATIO,
    next_ratio,
    winding,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import box_of_node, outside
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
    vector_at,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import MESH
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import EPS, SAME_DIRECTION

INSIDE, UNSURE, OUTSIDE = -1, 0, 1
# Rounding of a determinant of three differences, over the sum of its products' sizes: 7 u and some
# u^2 more, in units u = EPS / 2.
DETERMINANT = 4.0 * EPS
# Roundings within which a triangle whose side is open may be the one that decides.
AT_SURFACE = 4.0


@compiled
def side_of_triangle(shape: Floats, tree: Tree, j: int, q: Vector) -> int:
    """Return the side of the plane of triangle j that the point q is on, UNSURE to rounding.

    The error bound of the determinant is Shewchuk's (Discrete & Computational Geometry 18 (3),
    1997): for a face along the axes it is next to nothing.
    """
    at = tree.corners + CORNERS * j
    a = vector_at(shape, at)
    b, c = sub(vector_at(shape, at + 3), a), sub(vector_at(shape, at + 6), a)
    d = sub(q, a)
    x, y = (b[1] * c[2], b[2] * c[1]), (b[2] * c[0], b[0] * c[2])
    z = b[0] * c[1], b[1] * c[0]
    height = (x[0] - x[1]) * d[0] + (y[0] - y[1]) * d[1] + (z[0] - z[1]) * d[2]
    most = (abs(x[0]) + abs(x[1])) * abs(d[0]) + (abs(y[0]) + abs(y[1])) * abs(d[1])
    most += (abs(z[0]) + abs(z[1])) * abs(d[2])
    if not abs(height) > DETERMINANT * most:
        return UNSURE
    return OUTSIDE if height > 0.0 else INSIDE


@compiled
def side_by_winding(shape: Floats, tree: Tree, q: Vector) -> int:
    """Return the side of the surface that q is on, by its winding number, UNSURE to rounding."""
    ratio = FIRST_RATIO
    while True:
        # No triangle has this number: all are counted, and so is their rounding.
        number, error = winding(shape, tree, q, ratio, tree.triangles)
        if abs(number - 0.5) > error:
            return INSIDE if number > 0.5 else OUTSIDE
        if ratio == math.inf:
            return UNSURE
        ratio = next_ratio(ratio)


@compiled
def side_of_surface(
    shape: Floats,
    tree: Tree,
    q: Vector,
    distance: float,
    noise: float,
    count: int,
    scratch: PointScratch,
) -> int:
    """Return the side of the surface that q is on, by the nearest triangles, the scratch's first.

    All that b is on are among these, and other points that are as near give the same side. One
    whose plane goes through q does not decide: seen from there it is the last to be met. But among
    more than two, or at the surface itself, rounding might hide one that does.
    """
    inside, outside_, unsure = 0, 0, 0
    for i in range(count):
        side = side_of_triangle(shape, tree, scratch.triangles[i], q)
        inside += side == INSIDE
        outside_ += side == OUTSIDE
        unsure += side == UNSURE
    agree = (inside == 0) != (outside_ == 0)
    if agree and (unsure == 0 or (count == 2 and distance > AT_SURFACE * noise)):
        return OUTSIDE if outside_ > 0 else INSIDE
    if distance <= AT_SURFACE * noise:
        return UNSURE
    return side_by_winding(shape, tree, q)


@compiled
def first_of(count: int, scratch: PointScratch) -> int:
    """Return the place of the nearest triangle in the scratch, the least number among equals."""
    best = 0
    for i in range(1, count):
        nearer = scratch.away[i] < scratch.away[best]
        if nearer or (
            scratch.away[i] == scratch.away[best]
            and scratch.triangles[i] < scratch.triangles[best]
        ):
            best = i
    return best


@compiled
def direction_of(
    shape: Floats, tree: Tree, i: int, noise: float, side: int, scratch: PointScratch
) -> Vector:
    """Return the unit vector along which the distance from triangle i of the scratch grows."""
    if scratch.away[i] > noise:
        return scale(-1.0 if side != INSIDE else 1.0, unit(vector_in(scratch.vectors, i)))
    normal = normal_of(shape, tree, scratch.triangles[i])
    return normal if dot(normal, normal) > 0.5 else (1.0, 0.0, 0.0)


@compiled
def is_one_direction(
    shape: Floats,
    tree: Tree,
    grad: Vector,
    noise: float,
    side: int,
    count: int,
    scratch: PointScratch,
) -> bool:
    """Return whether the distances from all nearest triangles grow along about one direction."""
    for i in range(count):
        if dot(direction_of(shape, tree, i, noise, side, scratch), grad) < SAME_DIRECTION:
            return False
    return True


@allocating
def to_solid(
    address: Any,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points to a solid."""
    shape = body.shape
    tree = tree_of(kind, shape)
    lanes, box = lane_tree_of(tree), box_of_node(shape, tree, 0)
    extent, scratch = 2.0 * norm(box.half), scratch_for(lanes, FEW)
    for k in range(span.first, span.last):
        near, q, rounding = seen(body, p_WQs, k, threshold)
        if not near:
            continue
        beyond = norm(
            (
                outside(q[0] - box.middle[0], box.half[0]),
                outside(q[1] - box.middle[1], box.half[1]),
                outside(q[2] - box.middle[2], box.half[2]),
            )
        )
        if beyond > max(threshold, 0.0) + rounding + 2.0 * rounding_at(beyond, extent):
            continue
        count = nearest_triangles(shape, tree, lanes, q, extent, scratch)
        while count == FULL:
            scratch = scratch_for(lanes, 2 * scratch.triangles.size)
            count = nearest_triangles(shape, tree, lanes, q, extent, scratch)
        best = first_of(count, scratch)
        distance = scratch.away[best]
        noise = rounding_at(distance, extent)
        side = OUTSIDE
        if beyond <= noise:
            side = side_of_surface(shape, tree, q, distance, noise, count, scratch)
        error = noise + rounding
        if side == UNSURE:
            error += 2.0 * distance
        signed = -distance if side == INSIDE else distance
        if signed - error > threshold:
            continue
        grad = direction_of(shape, tree, best, noise, side, scratch)
        unique = is_one_direction(shape, tree, grad, noise, side, count, scratch)
        p_GN, at = add(q, vector_in(scratch.vectors, best)), k * span.n + span.g
        grad_W = rotate(body.R_WG, grad)
        put_point(answers.rows, at, signed, grad_W, p_GN, error, unique, MESH)
        answers.is_within[at] = True
        answers.counts[MESH] += 1
