"""The depth of a core or a solid in a solid, between certified bounds.

No formula gives the least translation that separates a body from a solid with dents, so it is
enclosed between two bounds, by the same steps for every kind of A:

- *Above*: a translation t after which the two are apart, which is verified by their distance
  there (``clearing``). The first ones come from the triangles in contact, one from the hulls,
  which always separates. From there A then slides along the plane of contact to where t is
  shortest, t' = (m . t) m for the normal m there, as long as that is verified to be apart too, and
  is drawn back along t until it touches. Between convex surfaces this walks to the nearest
  minimum.
- *Below*: balls in both about one point (``inner_depths``).

For solids and boxes the boxes within them come first (``separations``): the least translation that
separates these is a lower bound, and where it is certain to separate the bodies it is the depth.

Where an accuracy is wanted, the move that separates the hulls comes first. It leads to the same
translation in most overlaps of solids, in a tenth of the time; a push from a triangle in contact
then has to separate the bodies at once. The search ends when the bounds are as near as is wanted
and prove the overlap, so a larger accuracy never has narrower bounds. Where it ends without a
proof, ``exact`` answers.

Bodies are given as in ``distance``. A is its core grown by a ball of ``radius``.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import OVERLAP
from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import inner_radius
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import local_support
from drake_geom_ros.geometry._proximity.kernels.solids.clearing import (
    MOST_CONTACTS,
    cleared,
    step_aside,
)
from drake_geom_ros.geometry._proximity.kernels.solids.contacts import (
    PUSH_LENGTH,
    PUSH_WAY,
    PUSH_WIDTH,
    contacts,
)
from drake_geom_ros.geometry._proximity.kernels.solids.distance import NEVER, Nearest, nearest
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import (
    hull_support,
    middle_of,
    separating_move_of_hulls,
)
from drake_geom_ros.geometry._proximity.kernels.solids.inner_boxes import boxes_in, boxes_of
from drake_geom_ros.geometry._proximity.kernels.solids.inner_depths import (
    deepest_touching,
    depth_in_solid,
)
from drake_geom_ros.geometry._proximity.kernels.solids.separations import least_parting
from drake_geom_ros.geometry._proximity.kernels.solids.solid import SolidPair, moved, noise_of
from drake_geom_ros.geometry._proximity.kernels.solids.winding import is_inside
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    dot,
    norm,
    scale,
    sub,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOX, CONVEX, ELLIPSOID, SOLID, SPHERE
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.tolerances import BEYOND_HULL, COARSE, SAME_DIRECTION

MOST_PUSHES = 6  # directions that are tried
MOST_ROUNDS = 4  # pushes one after the other; one where an accuracy is wanted
MOST_SLIDES = 16
STEEPEST = 0.25  # cosine of a translation and the normal at its end: four gaps a step at most
MOST_STEPS_OUT = 12  # each twice as far as the one before: 4096 roundings in all
BACK_OFF = 4.0  # roundings that A is moved on beyond touching
ROOM = 8.0  # roundings by which boxes are to be apart that may fit each other


class DepthBounds(NamedTuple):
    """Bounds of a depth: ``least <= depth of A in B <= depth = |t|`` [m].

    Moved by t A is apart and touches B at b.
    """

    depth: float
    least: float
    t: Vector
    b: Vector


class DepthGoal(NamedTuple):
    """Bounds of a depth that end its search: no farther apart than ``enough`` [m].

    Their least is beyond ``proof`` [m], minus infinity where it need not prove the overlap.
    """

    enough: float
    proof: float


@inlined
def is_reached(goal: DepthGoal, bounds: DepthBounds) -> bool:
    """Return whether bounds end the search."""
    return bounds.depth - bounds.least <= goal.enough and bounds.least > goal.proof


@allocating
def where_it_touches(pair: SolidPair, m: Vector) -> Vector:
    """Return the point of B where A touches the hull of B, out along the unit m.

    To rounding they cross there. Somewhat farther out they do not, and are nearest at that point,
    unless A lies as near to another part of B. Any corner of the hull out along m would be as far
    out, but may be elsewhere on its face.
    """
    A, B = pair.A, pair.B
    for k in range(1, MOST_STEPS_OUT):
        out = 2.0**k * BACK_OFF * noise_of(pair)
        clear, _, closest = cleared(pair, scale(out, m), scale(-1.0, m))
        if clear and dot(closest.n, m) <= -SAME_DIRECTION:
            return closest.b
    if A.kind == ELLIPSOID or A.kind == SPHERE:  # only one of its points is that far out
        return add_scaled(add(pair.p, hull_support(A, scale(-1.0, m))), -pair.radius, m)
    return local_support(CONVEX, B.shape, m, 0.0)


@allocating
def push_of(pair: SolidPair, closest: Nearest, pushes: Floats) -> int:
    """Fill ``pushes`` (k, PUSH_WIDTH) with moves out of B, the shortest first; return how many."""
    B = pair.B
    count = contacts(pair, closest.n, 0.0, pushes, MOST_CONTACTS)
    if count == 0 and closest.end != OVERLAP and is_inside(B.shape, B.tree, closest.a):
        # Wholly inside: out through the nearest surface.
        m = unit(sub(closest.b, closest.a))
        lowest = add(pair.p, hull_support(pair.A, scale(-1.0, m)))
        for c in range(3):
            pushes[0, PUSH_WAY + c] = m[c]
        pushes[0, PUSH_LENGTH] = dot(sub(closest.b, lowest), m) + pair.radius
        count = 1
    pushes[:count] = pushes[np.argsort(pushes[:count, PUSH_LENGTH])]
    return count


@allocating
def escape(pair: SolidPair, t: Vector, most: float, rounds: int) -> tuple[bool, Vector, Nearest]:
    """Return (clear, t, closest): t grown, push after push, until A is out or it is too long."""
    pushes = np.empty((MOST_PUSHES, PUSH_WIDTH))
    back_off = BACK_OFF * noise_of(pair)
    n = scale(-1.0, unit(t))
    for turn in range(rounds):
        clear, t, closest = cleared(pair, t, n)
        if clear or turn == rounds - 1:
            break
        count = push_of(moved(pair, t), closest, pushes)
        if count == 0:
            break
        t = add_scaled(t, pushes[0, PUSH_LENGTH] + back_off, vector_at(pushes[0], PUSH_WAY))
        if norm(t) >= most:
            break
    return clear and norm(t) < most, t, closest


@allocating
def draw_back(pair: SolidPair, t: Vector, closest: Nearest) -> tuple[Vector, Nearest]:
    """Return (t, closest): t shortened along itself until A touches, and what is nearest then.

    This draws A into a hole that it rests on from several sides. It is Newton's method on the
    separation; a step that leads too far is cut to the separation, which is safe in any direction.
    """
    back_off = BACK_OFF * noise_of(pair)
    u = unit(t)
    for _ in range(MOST_SLIDES):
        separation, slope = closest.lower - pair.radius - back_off, -dot(closest.n, u)
        if separation <= max(0.25 * pair.tolerance, back_off):
            break
        step = min(separation / max(slope, STEEPEST), 0.5 * norm(t))
        clear, ahead, there = cleared(pair, add_scaled(t, -step, u), closest.n)
        if not clear:
            ahead = add_scaled(t, -min(separation, 0.5 * norm(t)), u)
            there = nearest(moved(pair, ahead), closest.n, math.inf, NEVER)
        t, closest = ahead, there
    return t, closest


@allocating
def slide(pair: SolidPair, t: Vector, closest: Nearest) -> tuple[Vector, Vector, Vector, Vector]:
    """Return (t, m, a, b) for a t no longer, after which A is apart, and touches if it can.

    There the point a of its core touches B at b, and m is the normal out of B.
    """
    back_off = BACK_OFF * noise_of(pair)
    for _ in range(MOST_SLIDES):
        m, separation = scale(-1.0, closest.n), closest.lower - pair.radius
        s = dot(t, m) - separation + back_off
        if s > 0.0 and norm(t) - s > max(0.25 * pair.tolerance, back_off):
            clear, ahead, there = cleared(pair, scale(s, m), closest.n)
            if clear and norm(ahead) < norm(t):
                t, closest = ahead, there
                continue
        t, closest = draw_back(pair, t, closest)
        break
    return t, scale(-1.0, closest.n), closest.a, closest.b


@allocating
def by_boxes(
    pair: SolidPair, least: float, most: float
) -> tuple[float, float, Vector, Vector, bool]:
    """Return (least, depth, t, b, alone) by boxes within the bodies, if these decide the depth.

    The least translation that separates the boxes is a lower bound, ``least`` or more, unless they
    may overlap. If it is certain to separate the bodies too it is the depth, ``alone`` if no other
    is as short; else the depth is infinite. ``most`` [m] is how long it may be where they may
    overlap, infinite where they do.
    """
    A, p, noise = pair.A, pair.p, noise_of(pair)
    if A.kind != SOLID and A.kind != BOX and A.kind != CONVEX:
        return least, math.inf, p, p, True
    _, longest = separating_move_of_hulls(pair)
    upper = longest + max(2.0 * BACK_OFF * noise, BEYOND_HULL * longest)
    boxes = boxes_of(A), boxes_in(pair.B.shape, pair.B.tree)
    for turn in range(0 if most == math.inf else 2, 3):
        # First as it is; then some roundings longer; then with room for rounding in a close fit.
        if turn != 1:
            more = ROOM * noise if turn == 2 else 0.0
            parting = least_parting(boxes, A.R, p, (upper, more), noise)
        if turn == 0:
            least = max(least, min(parting.lower, longest))
        if not parting.separates or norm(parting.t) >= most - ROOM * noise:
            break
        m = unit(parting.t)
        there = add_scaled(parting.t, BACK_OFF * noise if turn == 1 else 0.0, m)
        clear, t, ahead = cleared(pair, there, scale(-1.0, m))
        if clear:  # the caller that reports it subtracts the step
            length = max(norm(t), norm(parting.t) + BACK_OFF * noise)
            return least, length, t, ahead.b, parting.alone
    return least, math.inf, p, p, True


@allocating
def certain_separating_move(
    pair: SolidPair, closest: Nearest, ways: Floats, count: int
) -> tuple[float, Vector, Vector]:
    """Return (depth, t, b) of bodies that may overlap: moved by t, of length depth, A is apart.

    ``closest`` and ``ways`` are of ``stand_of``. Mostly some roundings suffice. A body that fits
    between walls has to leave as if it were wider by these.
    """
    noise, nowhere = noise_of(pair), (0.0, 0.0, 0.0)
    clear, t, ahead = step_aside(pair, nowhere, closest, ways, count)
    if clear:
        return norm(t), t, ahead.b
    m, s = separating_move_of_hulls(pair)
    s = max(s, 0.0) + BACK_OFF * noise
    _, depth, t, b, _ = by_boxes(pair, 0.0, s)
    if s < depth:  # hulls that are apart are apart
        return s, scale(s, m), where_it_touches(moved(pair, scale(s, m)), m)
    return depth, t, b


@allocating
def with_way(pair: SolidPair, t: Vector, ahead: Nearest, bounds: DepthBounds) -> DepthBounds:
    """Return the bounds with those from a t after which A is apart, ``ahead`` of it."""
    t, m, a, b = slide(pair, t, ahead)
    depth, t_best, b_best = bounds.depth, bounds.t, bounds.b
    if norm(t) < depth:
        depth, t_best, b_best = norm(t), t, b
    least = max(bounds.least, deepest_touching(pair, t, (a, b, m)))
    return DepthBounds(depth, least, t_best, b_best)


@allocating
def with_pushes(
    pair: SolidPair, closest: Nearest, bounds: DepthBounds, goal: DepthGoal, rounds: int
) -> DepthBounds:
    """Return the bounds with those from contacts, until they reach the goal."""
    pushes = np.empty((MOST_PUSHES, PUSH_WIDTH))
    for k in range(push_of(pair, closest, pushes)):
        if is_reached(goal, bounds):
            break
        m, s = vector_at(pushes[k], PUSH_WAY), pushes[k, PUSH_LENGTH] + BACK_OFF * noise_of(pair)
        if s < bounds.depth:
            clear, t, ahead = escape(pair, scale(s, m), bounds.depth, rounds)
            if clear:
                bounds = with_way(pair, t, ahead, bounds)
    return bounds


@allocating
def with_hulls(pair: SolidPair, bounds: DepthBounds) -> DepthBounds:
    """Return the bounds with those from the move that separates the hulls."""
    m, s = separating_move_of_hulls(pair)
    out = scale(s + BACK_OFF * noise_of(pair), m)
    clear, t, ahead = cleared(pair, out, scale(-1.0, m))
    if clear:
        return with_way(pair, t, ahead, bounds)
    if s < bounds.depth:  # by rounding: hulls that are apart are apart
        b = where_it_touches(moved(pair, out), m)
        return DepthBounds(norm(out), bounds.least, out, b)
    return bounds


@allocating
def with_boxes(pair: SolidPair, bounds: DepthBounds) -> tuple[DepthBounds, bool]:
    """Return the bounds with those from the boxes within the bodies, and ``alone`` of these."""
    least, depth, t, b, alone = by_boxes(pair, bounds.least, math.inf)
    if depth < bounds.depth:
        return DepthBounds(depth, least, t, b), alone
    return DepthBounds(bounds.depth, least, bounds.t, bounds.b), alone


@allocating
def coarse_bounds(
    pair: SolidPair, closest: Nearest, bounds: DepthBounds, goal: DepthGoal
) -> DepthBounds:
    """Return the bounds with those from the quickest ways out, until they reach the goal."""
    bounds = with_hulls(pair, bounds)
    if not is_reached(goal, bounds):
        bounds, _ = with_boxes(pair, bounds)
    if not is_reached(goal, bounds):
        bounds = with_pushes(pair, closest, bounds, goal, 1)
    return bounds


@allocating
def bounds_of_depth(
    pair: SolidPair, closest: Nearest, accuracy: float
) -> tuple[DepthBounds, bool]:
    """Return the bounds of the depth of A at p, which overlaps with B, and whether t is alone.

    Not alone: another separating translation, along a clearly different direction, may be as
    short. From an ``accuracy`` [m] of COARSE on, the bounds need not be nearer than that.
    """
    # Whatever is tried or left out, both bounds hold: each t was verified to separate, and each
    # depth is of balls in both bodies. Trying less only leaves them farther apart, which the
    # answer's error bound reports.
    A, B, p, radius = pair.A, pair.B, pair.p, pair.radius
    rounding, least = 4.0 * BACK_OFF * noise_of(pair), 0.0
    enough = max(0.5 * pair.tolerance, rounding)
    if closest.end != OVERLAP and closest.upper < radius:
        least = radius - closest.upper
    if A.kind != SOLID:
        ball = max(radius, inner_radius(A.kind, A.shape))
        least = max(least, ball + depth_in_solid(B, middle_of(A, p)))
    start = DepthBounds(math.inf, least, p, p)
    if accuracy >= COARSE:
        # Widened by what ``exact`` is content with, they are no narrower than its own. The least
        # depth has to prove the overlap, by which motions, too, decide.
        goal = DepthGoal(max(enough, accuracy - 2.0 * enough), rounding + enough)
        depth, least, t, b = coarse_bounds(pair, closest, start, goal)
        least = min(least, depth) - enough
        if least > rounding:
            return DepthBounds(depth + enough, least, t, b), False
    goal = DepthGoal(enough, -math.inf)
    bounds, alone = with_boxes(pair, start)
    if not is_reached(goal, bounds):
        alone = closest.unique
        bounds = with_pushes(pair, closest, bounds, goal, MOST_ROUNDS)
        if not is_reached(goal, bounds):
            bounds = with_hulls(pair, bounds)
    depth, least, t, b = bounds
    return DepthBounds(depth, min(least, depth), t, b), alone
