"""A solid against many points: the nearest triangle, and the side of it that the point is on.

The distance is that of the nearest triangle. Let b be the point nearest to q on the surface; then
nothing of the surface is between them, so q is inside where the segment from b to q begins inside.
About b the surface is a fan of triangles, or one: seen along the segment, the triangle first met
when one turns away from it decides, and so do all that b is on, where they agree. They mostly do.
Where not, at the tip of a needle say, the winding number tells; and where rounding leaves it open
even so, the bound holds both signs.
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
    Room,
    nearest_triangles,
    room_for,
    rounding_at,
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
    """Return on which side of the plane of triangle j the point q is, UNSURE to rounding.

    What the determinant may be off by is Shewchuk's (Discrete & Computational Geometry 18 (3),
    1997): of a face along the axes next to nothing.
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
    """Return on which side of the surface q is by its winding number, UNSURE to rounding."""
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
    shape: Floats, tree: Tree, q: Vector, distance: float, noise: float, count: int, room: Room
) -> int:
    """Return on which side of the surface q is, by the nearest triangles, the first of the room's.

    All that b is on are among these, and other points that are as near ask for the same side. One
    whose plane goes through q does not decide: seen from there it is the last to be met. But of
    more than two, or at the surface itself, rounding might hide one that does.
    """
    inside, outside_, unsure = 0, 0, 0
    for i in range(count):
        side = side_of_triangle(shape, tree, room.triangles[i], q)
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
def first_of(count: int, room: Room) -> int:
    """Return the place of the nearest triangle in the room, of equal ones that of least number."""
    best = 0
    for i in range(1, count):
        nearer = room.away[i] < room.away[best]
        if nearer or (
            room.away[i] == room.away[best] and room.triangles[i] < room.triangles[best]
        ):
            best = i
    return best


@compiled
def direction_of(shape: Floats, tree: Tree, i: int, noise: float, side: int, room: Room) -> Vector:
    """Return the unit vector along which the distance grows, as triangle i of the room has it."""
    if room.away[i] > noise:
        return scale(-1.0 if side != INSIDE else 1.0, unit(vector_in(room.vectors, i)))
    normal = normal_of(shape, tree, room.triangles[i])
    return normal if dot(normal, normal) > 0.5 else (1.0, 0.0, 0.0)


@compiled
def is_one_direction(
    shape: Floats, tree: Tree, grad: Vector, noise: float, side: int, count: int, room: Room
) -> bool:
    """Tell whether the distance grows along about the same direction by all nearest triangles."""
    for i in range(count):
        if dot(direction_of(shape, tree, i, noise, side, room), grad) < SAME_DIRECTION:
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
    """Signed distance of points to a solid."""
    shape = body.shape
    tree = tree_of(kind, shape)
    lanes, box = lane_tree_of(tree), box_of_node(shape, tree, 0)
    extent, room = 2.0 * norm(box.half), room_for(lanes, FEW)
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
        count = nearest_triangles(shape, tree, lanes, q, extent, room)
        while count == FULL:
            room = room_for(lanes, 2 * room.triangles.size)
            count = nearest_triangles(shape, tree, lanes, q, extent, room)
        best = first_of(count, room)
        distance = room.away[best]
        noise = rounding_at(distance, extent)
        side = OUTSIDE
        if beyond <= noise:
            side = side_of_surface(shape, tree, q, distance, noise, count, room)
        error = noise + rounding
        if side == UNSURE:
            error += 2.0 * distance
        signed = -distance if side == INSIDE else distance
        if signed - error > threshold:
            continue
        grad = direction_of(shape, tree, best, noise, side, room)
        unique = is_one_direction(shape, tree, grad, noise, side, count, room)
        p_GN, at = add(q, vector_in(room.vectors, best)), k * span.n + span.g
        grad_W = rotate(body.R_WG, grad)
        put_point(answers.rows, at, signed, grad_W, p_GN, error, unique, MESH)
        answers.found[at] = True
        answers.counts[MESH] += 1
