"""How deep a core or a solid is in a solid, between certified bounds.

No formula tells the least translation that separates a body from a solid with dents, so it is
caught between two bounds, and the same steps serve every kind of A:

- *Above*: a translation t after which the two are apart, which is verified by their distance
  there. The first ones come from the triangles in contact, one from the hulls, which always
  separates. From where it got, A then slides along the plane of contact to where t is shortest,
  t' = (m . t) m for the normal m there, as long as that is verified to be apart too, and is drawn
  back along t until it touches. Between convex surfaces this walks to the nearest minimum.
- *Below*: a ball of A around a point that lies at depth d in B moves at least its radius plus d.
  The deepest points of A in the contacts found above are tried, and its middle.

Of solids and boxes the boxes within them come first (``separations``): the least translation that
parts these is a lower bound, and where it is seen to part the bodies it is the depth.

Bodies are given as in ``distance``. A is its core grown by a ball of ``radius``.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import OVERLAP
from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import inner_radius
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import local_support, support
from drake_geom_ros.geometry._proximity.kernels.solids.containment import (
    FLUSH,
    depth_in_solid,
    is_contained,
)
from drake_geom_ros.geometry._proximity.kernels.solids.distance import (
    PUSH_LENGTH,
    PUSH_WAY,
    PUSH_WIDTH,
    Nearest,
    close_pairs,
    contacts,
    nearest,
)
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import (
    hull_support,
    middle_of,
    way_out_of_hull,
)
from drake_geom_ros.geometry._proximity.kernels.solids.inner_boxes import boxes_in, boxes_of
from drake_geom_ros.geometry._proximity.kernels.solids.separations import least_parting
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    Solid,
    TreeBody,
    middle_of_triangle,
)
from drake_geom_ros.geometry._proximity.kernels.solids.winding import is_inside
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
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
    SOLID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import (
    BEYOND_HULL,
    EPS,
    RIGHT_ANGLE,
    ROUNDING,
    SAME_DIRECTION,
)

MOST_PUSHES = 6  # directions that are tried
MOST_CONTACTS = 64  # pairs of leaves that they are taken from
MOST_ROUNDS = 4  # pushes one after the other
MOST_SLIDES = 16
MOST_MIDDLES = 16  # of touching triangles that are tried
STEEPEST = 0.25  # cosine of a way out and the normal that it ends at: four gaps a step at most
MOST_STEPS_OUT = 12  # each twice as far as the one before: 4096 roundings in all
BACK_OFF = 4.0  # roundings that A is moved on beyond touching


@compiled
def clearance(
    A: TreeBody, B: Solid, p: Vector, n: Vector, size: float, tolerance: float, radius: float
) -> tuple[bool, Nearest]:
    """Return (clear, found): whether A at p is apart from B, and what ``nearest`` found.

    It is apart if no surfaces cross or are nearer than touching, and neither body is in the other:
    both are asked without a limit, and so nothing is left out.
    """
    noise = ROUNDING * EPS * size
    found = nearest(A, B, p, n, size, tolerance, math.inf)
    clear = found.end != OVERLAP and found.lower >= radius - 2.0 * noise
    return clear and not is_contained(A, B, p, found.lower <= noise, size), found


@allocating
def where_it_touches(
    A: TreeBody, B: Solid, p: Vector, m: Vector, size: float, tolerance: float, radius: float
) -> Vector:
    """Return the point of B where A at p touches the hull of B, out along the unit m.

    Rounding says that they cross. Somewhat farther out they do not, and are nearest at that point,
    unless A lies as near to another part of B. Any corner of the hull out along m would be as far
    out, but may be elsewhere on its face.
    """
    for k in range(1, MOST_STEPS_OUT):
        out = 2.0**k * BACK_OFF * ROUNDING * EPS * size
        there = add_scaled(p, out, m)
        clear, found = clearance(A, B, there, scale(-1.0, m), size, tolerance, radius)
        if clear and dot(found.n, m) <= -SAME_DIRECTION:
            return found.b
    if A.kind == ELLIPSOID:  # only one of its points is that far out
        return add_scaled(add(p, hull_support(A, scale(-1.0, m))), -radius, m)
    return local_support(CONVEX, B.shape, m, 0.0)


@allocating
def push_of(
    A: TreeBody,
    B: Solid,
    p: Vector,
    found: Nearest,
    size: float,
    tolerance: float,
    radius: float,
    pushes: Floats,
) -> int:
    """Fill ``pushes`` (k, PUSH_WIDTH) with ways out, the shortest first; return how many."""
    count = contacts(A, B, p, found.n, size, tolerance, radius, pushes, MOST_CONTACTS)
    if count == 0 and found.end != OVERLAP and is_inside(B.shape, B.tree, found.a):
        # Wholly inside: out through the nearest surface.
        m = unit(sub(found.b, found.a))
        lowest = add(p, hull_support(A, scale(-1.0, m)))
        pushes[0, 0], pushes[0, 1], pushes[0, 2] = m
        pushes[0, PUSH_LENGTH] = dot(sub(found.b, lowest), m) + radius
        count = 1
    pushes[:count] = pushes[np.argsort(pushes[:count, PUSH_LENGTH])]
    return count


@allocating
def escape(
    A: TreeBody,
    B: Solid,
    p: Vector,
    t: Vector,
    size: float,
    tolerance: float,
    radius: float,
    most: float,
) -> tuple[bool, Vector, Nearest]:
    """Return (clear, t, found): t grown, push after push, until A is out or it is too long."""
    pushes = np.empty((MOST_PUSHES, PUSH_WIDTH))
    back_off = BACK_OFF * ROUNDING * EPS * size
    n = scale(-1.0, unit(t))
    for turn in range(MOST_ROUNDS):
        clear, found = clearance(A, B, add(p, t), n, size, tolerance, radius)
        if clear or turn == MOST_ROUNDS - 1:
            break
        count = push_of(A, B, add(p, t), found, size, tolerance, radius, pushes)
        if count == 0:
            break
        t = add_scaled(t, pushes[0, PUSH_LENGTH] + back_off, vector_at(pushes[0], PUSH_WAY))
        if norm(t) >= most:
            break
    return clear and norm(t) < most, t, found


@compiled
def draw_back(
    A: TreeBody,
    B: Solid,
    p: Vector,
    t: Vector,
    found: Nearest,
    size: float,
    tolerance: float,
    radius: float,
) -> tuple[Vector, Nearest]:
    """Return (t, found): t shortened along itself until A touches, and what is near then.

    So it is drawn into a hole that it rests on from several sides. Newton's method on the
    separation; a step that leads too far is cut to the separation, within which A goes anywhere.
    """
    back_off = BACK_OFF * ROUNDING * EPS * size
    u = unit(t)
    for _ in range(MOST_SLIDES):
        separation, slope = found.lower - radius - back_off, -dot(found.n, u)
        if separation <= max(0.25 * tolerance, back_off):
            break
        step = min(separation / max(slope, STEEPEST), 0.5 * norm(t))
        ahead = add_scaled(t, -step, u)
        clear, there = clearance(A, B, add(p, ahead), found.n, size, tolerance, radius)
        if not clear:
            ahead = add_scaled(t, -min(separation, 0.5 * norm(t)), u)
            _, there = clearance(A, B, add(p, ahead), found.n, size, tolerance, radius)
        t, found = ahead, there
    return t, found


@compiled
def slide(
    A: TreeBody,
    B: Solid,
    p: Vector,
    t: Vector,
    found: Nearest,
    size: float,
    tolerance: float,
    radius: float,
) -> tuple[Vector, Vector, Vector, Vector]:
    """Return (t, m, a, b) for a t that is no longer, where A is apart and touches, if it can.

    There it touches with the point a of its core, at b, and m is the normal out of B.
    """
    back_off = BACK_OFF * ROUNDING * EPS * size
    for _ in range(MOST_SLIDES):
        m, separation = scale(-1.0, found.n), found.lower - radius
        s = dot(t, m) - separation + back_off
        if s > 0.0 and norm(t) - s > max(0.25 * tolerance, back_off):
            clear, ahead = clearance(A, B, add_scaled(p, s, m), found.n, size, tolerance, radius)
            if clear:
                t, found = scale(s, m), ahead
                continue
        t, found = draw_back(A, B, p, t, found, size, tolerance, radius)
        break
    return t, scale(-1.0, found.n), found.a, found.b


@compiled
def depth_in_body(
    A: TreeBody, B: Solid, p: Vector, x: Vector, size: float, radius: float
) -> float:
    """Return how deep x, in B's frame, lies in A [m], or less: minus infinity where unknown."""
    q = unrotate(A.R, sub(x, p))
    kind, shape = A.kind, A.shape
    if kind == SOLID:
        return depth_in_solid(Solid(shape, A.tree, B.identity), q, size)
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
def deepest_at(A: TreeBody, B: Solid, p: Vector, x: Vector, size: float, radius: float) -> float:
    """Return a lower bound of the depth [m] by a point x of A or of B: balls of both around it.

    Balls of radius a in A and b in B about one point are apart only after a move by a + b. With x
    at a distance d out of A, a is -d: a ball of radius b - d in B is about A's nearest point then.
    """
    return depth_in_body(A, B, p, x, size, radius) + depth_in_solid(B, x, size)


@allocating
def deepest_touching(
    A: TreeBody,
    B: Solid,
    p: Vector,
    t: Vector,
    a: Vector,
    b: Vector,
    m: Vector,
    size: float,
    tolerance: float,
    radius: float,
) -> float:
    """Return a lower bound of the depth [m] by points near where A touches after the move by t.

    They are the point a of A's core and b of B's surface that touch then, what is half-way between
    them before the move, and the middles of what touches: of a core the lowest face, of solids the
    triangles. A corner that touches may be no deeper than a wall beside it.
    """
    before = sub(a, t)
    least = radius + depth_in_solid(B, before, size)
    least = max(least, deepest_at(A, B, p, b, size, radius))
    least = max(least, deepest_at(A, B, p, add_scaled(b, -0.5, t), size, radius))
    if A.kind != SOLID:
        lowest = add(p, support(A.kind, A.shape, A.R, scale(-1.0, m), RIGHT_ANGLE))
        return max(least, radius + depth_in_solid(B, lowest, size))
    noise = FLUSH * ROUNDING * EPS * size
    pairs = np.empty((MOST_MIDDLES, 2), dtype=np.int64)
    for k in range(close_pairs(A, B, add(p, t), scale(-1.0, m), size, tolerance, noise, pairs)):
        x = add(p, rotate(A.R, middle_of_triangle(A.shape, A.tree, pairs[k, 0])))
        y = middle_of_triangle(B.shape, B.tree, pairs[k, 1])
        least = max(least, depth_in_solid(B, x, size), depth_in_body(A, B, p, y, size, radius))
    return least


@allocating
def by_boxes(
    A: TreeBody, B: Solid, p: Vector, least: float, size: float, tolerance: float, radius: float
) -> tuple[float, float, Vector, Vector, bool]:
    """Return (least, depth, t, b, alone) of the depth by boxes within the bodies, if they tell.

    The least translation that parts the boxes is a lower bound, ``least`` or more. If it is seen
    to part the bodies too it is the depth, ``alone`` if no other is as short; else the depth is
    infinite.
    """
    noise = ROUNDING * EPS * size
    if A.kind != SOLID and A.kind != BOX and A.kind != CONVEX:
        return least, math.inf, p, p, True
    _, longest = way_out_of_hull(A, B, p, radius)
    upper = longest + max(2.0 * BACK_OFF * noise, BEYOND_HULL * longest)
    found = least_parting(boxes_of(A), boxes_in(B.shape, B.tree), A.R, p, upper, noise)
    least = max(least, min(found.lower, longest))
    if not found.parts:
        return least, math.inf, p, p, True
    for turn in range(2):  # as it is, and a little farther
        t = add_scaled(found.t, turn * BACK_OFF * noise, unit(found.t))
        clear, ahead = clearance(A, B, add(p, t), scale(-1.0, unit(t)), size, tolerance, radius)
        if clear:  # whoever reports it takes the step back off
            return least, norm(found.t) + BACK_OFF * noise, t, ahead.b, found.alone
    return least, math.inf, p, p, True


@allocating
def bounds_of_depth(
    A: TreeBody, B: Solid, p: Vector, found: Nearest, size: float, tolerance: float, radius: float
) -> tuple[float, float, Vector, Vector, bool]:
    """Return (depth, least, t, b, alone) of A at p, which overlaps with B.

    ``least <= depth of A in B <= depth = |t|``: moved by t A is apart, and b is where it touches.
    Not ``alone``: another way out, along a clearly different direction, is known to be as short.
    """
    # Whatever is tried or left out, both bounds hold: each t was seen to separate, and each depth
    # is of balls in both bodies. Trying less only leaves them farther apart, which is told.
    pushes = np.empty((MOST_PUSHES, PUSH_WIDTH))
    back_off = BACK_OFF * ROUNDING * EPS * size
    enough = max(0.5 * tolerance, 4.0 * back_off)
    least = 0.0
    if found.end != OVERLAP and found.upper < radius:
        least = radius - found.upper
    if A.kind != SOLID:
        ball = max(radius, inner_radius(A.kind, A.shape))
        least = max(least, ball + depth_in_solid(B, middle_of(A, p), size))
    depth, t_best, b_best = math.inf, p, p
    least, depth, t_best, b_best, alone = by_boxes(A, B, p, least, size, tolerance, radius)
    if depth - least <= enough:
        return depth, min(least, depth), t_best, b_best, alone
    count = push_of(A, B, p, found, size, tolerance, radius, pushes)
    for k in range(count + 1):
        if depth - least <= enough:
            break
        if k < count:
            m, s = vector_at(pushes[k], PUSH_WAY), pushes[k, PUSH_LENGTH] + back_off
            if s >= depth:
                continue
            clear, t, ahead = escape(A, B, p, scale(s, m), size, tolerance, radius, depth)
        else:
            m, s = way_out_of_hull(A, B, p, radius)
            t = scale(s + back_off, m)
            clear, ahead = clearance(A, B, add(p, t), scale(-1.0, m), size, tolerance, radius)
            if not clear and s < depth:  # so rounding says, but hulls that are apart are apart
                depth, t_best = norm(t), t
                b_best = where_it_touches(A, B, add(p, t), m, size, tolerance, radius)
        if clear:
            t, m, a, b = slide(A, B, p, t, ahead, size, tolerance, radius)
            if norm(t) < depth:
                depth, t_best, b_best = norm(t), t, b
            deep = deepest_touching(A, B, p, t, a, b, m, size, tolerance, radius)
            least = max(least, deep)
    return depth, min(least, depth), t_best, b_best, found.unique
