"""EPA: certified bounds of the depth of two overlapping cores.

Van den Bergh (*Proximity queries and penetration depth computation on 3D game objects*, Game
Developers Conference 2001) grows a polytope P of points of the Minkowski difference D = A - B at
the face nearest to the origin. This implementation differs in three ways.

*The polytope need not enclose the origin at first.* Faces have signed offsets and the most
negative one is expanded first. So GJK need not provide an enclosing simplex, and touching shapes,
whose difference has the origin on its surface, are no special case.

*It starts near the answer.* Newton's method (see ``normals``) finds the local minimum next to a
hint, and a cap of directions in which nothing is less. Other faces only have to be farther than
that minimum, outside its cap: a dozen vertices suffice, and the last digits of distance and normal
cost nothing.

*The bounds do not rely on the planes.* Upper bound: ``h_D(n)``, the width of the overlap along the
unit n, holds for any n. Lower bound: a triangle with vertices v_i is no nearer to the origin than
``min_i (n . v_i)``, for any unit n, even if the triangle is a sliver. The links make the triangles
a closed surface in D. When all offsets are positive, all triangles are seen from inside. Then
their solid angles add up to 4 pi or more, the surface winds around the origin, and the ball of the
least offset lies within D. This needs neither convexity of P nor an exact visibility test. D must
have a volume: see ``revolution`` for pairs of cores without one.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.ball_caps import (
    ball_in_difference,
    is_in_ball_cap,
)
from drake_geom_ros.geometry._proximity.kernels.cores.caps import widest_cap
from drake_geom_ros.geometry._proximity.kernels.cores.epa_witnesses import witness
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import put, support_points
from drake_geom_ros.geometry._proximity.kernels.cores.normals import (
    NOTHING,
    nearby_minimum,
    onto_kink,
)
from drake_geom_ros.geometry._proximity.kernels.cores.polytope import (
    OFFSET,
    add_faces,
    expand,
    growth_arrays,
    growth_numbers,
    is_corner,
    link_tetrahedron,
    pop_living,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Depth, Difference
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    difference_of_edges,
    witness_points,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    cross,
    dot,
    norm,
    perpendicular,
    scale,
    sub,
    unit,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Integers32, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import outlive
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    FOLD,
    ROUNDING,
    SAME_DIRECTION,
    SLIVER,
    THIN,
)

LEAST_TILT = 0.1  # [rad]
COS_120 = (1.0, -0.5, -0.5)
SIN_120 = (0.0, math.sqrt(0.75), -math.sqrt(0.75))


class BestDirection(NamedTuple):
    """The best direction n so far, with the width [m] and the extreme points a and b along it.

    An ``exact`` one is a minimum: nothing is less within the angle ``cap`` [rad], and a - b is
    along n.
    """

    exact: bool
    width: float
    n: Vector
    a: Vector
    b: Vector
    cap: float


@compiled
def first_points(pair: CorePair, n: Vector, points: Floats) -> None:
    """Fill in support points 1 to 3 that span a volume with point 0, which is extreme along n."""
    along = n
    m = scale(-1.0, n)
    for k in range(1, 4):
        best = -1.0
        for turn in range(2 if k > 1 else 1):
            a, b = support_points(
                pair,
                scale(1.0 - 2.0 * turn, m),
                0.0,
            )
            rise = abs(dot(sub(sub(a, b), vector_in(points, 0)), m))
            if rise > best:
                best = rise
                put(points, k, a, b)
        if k == 1:
            along = unit(sub(vector_in(points, 1), vector_in(points, 0)))
            m = perpendicular(along)
        if k == 2:
            m = unit(cross(along, sub(vector_in(points, 2), vector_in(points, 0))))


@compiled
def ring_points(pair: CorePair, n: Vector, tilt: float, points: Floats) -> None:
    """Fill in four support points: three around n, tilted by ``tilt`` [rad], and one along -n."""
    e = perpendicular(n)
    f = cross(n, e)
    along, aside = math.cos(tilt), math.sin(tilt)
    for k in range(4):
        m = scale(-1.0, n)
        if k > 0:
            around = add_scaled(scale(COS_120[k - 1], e), SIN_120[k - 1], f)
            m = add_scaled(scale(along, n), aside, around)
        a, b = support_points(pair, m, 0.0)
        put(points, k, a, b)


@inlined
def is_in_cap(m: Vector, offset: float, n: Vector, rival: float, cap: float) -> bool:
    """Return whether all directions in which a face is nearer than ``rival`` are in the cap of n.

    A ray at an angle x from the normal m crosses the face at ``offset / cos x`` or later. Angles
    are computed from chords, because two directions 1e-9 rad apart have the cosine 1.
    """
    if cap == 0.0 or offset <= 0.0:
        return False
    chord = norm(sub(m, n))
    if chord > cap:  # rejects most faces, since the arc is even longer
        return False
    away = 2.0 * math.asin(min(0.5 * chord, 1.0))
    beyond = math.sqrt(max(rival - offset, 0.0) * (rival + offset))
    return away + math.atan2(beyond, offset) <= cap


@allocating
def minimum_near(
    pair: CorePair,
    difference: Difference,
    n: Vector,
    width: float,
    a: Vector,
    b: Vector,
    enough: float,
    noise: float,
) -> BestDirection:
    """Return the minimum next to n, or the given direction n if there is none.

    ``width`` [m], ``a`` and ``b`` are those along n. For hulls it is the minimum of the edges next
    to n, if the hulls reach no farther there. The h of the hulls is nowhere less than that of the
    edges, so the cap is valid for the hulls, too.
    """
    hulls, start = difference.last == 0, n
    if hulls:
        difference = difference_of_edges(pair, n)
        start = onto_kink(difference, n)
    minimum = nearby_minimum(difference, start, noise)
    if minimum.kind == NOTHING or minimum.h > width + noise:
        return BestDirection(False, width, n, a, b, 0.0)
    if hulls:
        s_A, s_B = support_points(pair, minimum.n, 0.0)
        if dot(sub(s_A, s_B), minimum.n) > minimum.h + noise:
            return BestDirection(False, width, n, a, b, 0.0)
    a, b = witness_points(difference, minimum.n)
    return BestDirection(True, minimum.h, minimum.n, a, b, widest_cap(difference, minimum, enough))


@compiled
def is_flat(points: Floats, share: float, size: float) -> bool:
    """Return whether the tetrahedron of vertices 0 to 3 is thinner than a share of the size."""
    a, b, c, d = (
        vector_in(points, 0),
        vector_in(points, 1),
        vector_in(points, 2),
        vector_in(points, 3),
    )
    n = cross(sub(b, a), sub(c, a))
    return abs(dot(sub(d, a), n)) <= share * size * max(norm(n), share * size * size)


@compiled
def start(
    pair: CorePair,
    best: BestDirection,
    near: bool,
    growth: tuple[Floats, Integers32, Floats, Integers32, Integers32, Integers32, Integers32],
    size: float,
    noise: float,
) -> tuple[int, int, int]:
    """Make the first polytope, around a minimum with a cap; return (count, total, waiting).

    They are the numbers of vertices, of faces, and of faces on the heap. ``near``: the best
    direction is expected to be near the answer.
    """
    points, faces, planes, horizon, stack, starting_at, heap = growth
    n, a, b, cap = best.n, best.a, best.b, best.cap
    if cap > 0.0 or near:
        ring_points(pair, n, max(0.5 * cap, LEAST_TILT), points)
    if not (cap > 0.0 or near) or is_flat(points, SLIVER, size):
        put(points, 0, a, b)
        first_points(pair, n, points)
    link_tetrahedron(points, faces)
    waiting = add_faces(points, faces, planes, heap, 0, 4, 0, size)
    total = 4
    for f in range(4):
        m = planes[f, 0], planes[f, 1], planes[f, 2]
        above = dot(sub(a, b), m) > planes[f, OFFSET] + noise
        if cap > 0.0 and total == 4 and above and dot(m, n) > 0.5:
            total = expand(points, faces, planes, horizon, stack, starting_at, f, a, b, 4, 4, size)
            waiting = add_faces(points, faces, planes, heap, 4, total, waiting, size)
    return (4 if total == 4 else 5), total, waiting


@compiled
def guarded_hulls(pair: CorePair, depth: Depth, noise: float) -> Depth:
    """Return a depth of hulls, checked against planes that no search chose.

    EPA's lower bound requires a difference with a volume. That of a segment and a hull negligible
    beside it has none: its faces are slivers, whose orientation is rounding.
    """
    if depth.lower <= 0.0:
        return depth
    e = perpendicular(depth.n)
    f = cross(depth.n, e)
    for m in (unit(pair.p_AB), scale(-1.0, depth.n), e, scale(-1.0, e), f, scale(-1.0, f)):
        a, b = support_points(pair, m, 0.0)
        h = dot(sub(a, b), m)
        if dot(m, m) > 0.5 and h < depth.lower - 2.0 * noise:
            apart = norm(sub(a, b))
            aside = norm(sub(sub(a, b), scale(h, m)))
            depth = Depth(h, -apart, m, a, b, aside, False)
    return depth


@compiled
def depth_at(
    points: Floats,
    faces: Integers32,
    planes: Floats,
    total: int,
    least: BestDirection,
    lower: float,
    enough: float,
    unique: bool,
) -> Depth:
    """Return the depth from a polytope and the least width found."""
    best, n, a, b, aside = least.width, least.n, least.a, least.b, 0.0
    if least.exact:
        lower = min(lower, best)
    else:
        a, b, aside = witness(points, faces, planes, total, n, best, best + enough, a, b)
    if lower <= 0.0:
        lower = -(abs(best) + aside)
    return Depth(best, lower, n, a, b, aside, unique)


@allocating
def depth_of_cores(
    pair: CorePair,
    difference: Difference,
    n: Vector,
    near: bool,
    size: float,
    tolerance: float,
    most_vertices: int,
) -> Depth:
    """Return the depth of two overlapping or touching cores.

    n is any direction to start from, the better the faster. ``near``: it may be good, and the
    cores are expected to overlap. See ``Depth`` for the result:

    - ``upper`` is the width of the overlap along the unit n (from A to B);
    - ``lower`` is the radius of a ball around the origin in the Minkowski difference, or minus a
      length within which the difference has a point;
    - a and b, from Ao, have ``a - b = upper n``; ``aside`` is that of ``witness``;
    - ``unique``: the bounds exclude every clearly different direction. Once the bounds have met,
      faces turned elsewhere are expanded until none is as near.

    Cores expected to overlap that turn out to be separated end the growth, with a negative
    ``upper``.
    """
    block = np.empty(growth_numbers(most_vertices))
    growth = growth_arrays(block, most_vertices)
    points, faces, planes, horizon, stack, starting_at, heap = growth
    noise = ROUNDING * EPS * size
    enough = max(tolerance, noise)
    a, b = support_points(pair, n, 0.0)
    best_direction = minimum_near(pair, difference, n, dot(sub(a, b), n), a, b, enough, noise)
    count, total, waiting = start(pair, best_direction, near, growth, size, noise)
    hulls, ball = difference.last == 0, ball_in_difference(pair)
    thin = hulls and is_flat(points, THIN, size)
    exact, best, n, a, b, cap = best_direction
    lower, least_in_cap, settled, unique = -np.inf, np.inf, False, False
    while True:
        f, waiting = pop_living(faces, planes, heap, waiting)
        if f < 0 or (settled and planes[f, OFFSET] > best + enough):
            lower = lower if settled else best  # all remaining faces are in caps
            unique = True
            break
        m, offset = (planes[f, 0], planes[f, 1], planes[f, 2]), planes[f, OFFSET]
        in_ball_cap = is_in_ball_cap(points, faces, planes, f, ball, best + enough)
        if in_ball_cap or is_in_cap(m, offset, n, best + enough, cap):
            least_in_cap = min(least_in_cap, offset)
            continue
        if not settled and lower > 0.0 and offset < min(lower, least_in_cap) - FOLD * size:
            break
        lower = lower if settled else max(lower, offset)
        settled = settled or (exact and lower >= best - enough)
        if settled and dot(m, n) >= SAME_DIRECTION:
            continue
        s_A, s_B = support_points(pair, m, 0.0)
        width = dot(sub(s_A, s_B), m)
        if settled and width <= best + 2.0 * enough:
            break
        closed = not settled and width - lower <= enough
        if closed or (not settled and width < best - noise):
            best_direction = BestDirection(False, width, m, s_A, s_B, 0.0)
            # Before the end it saves nothing for polytopes, which have no tolerance.
            if closed or not hulls or tolerance > 0.0:
                best_direction = minimum_near(pair, difference, m, width, s_A, s_B, enough, noise)
            exact, best, n, a, b, cap = best_direction
            if exact and dot(sub(a, b), m) > offset + noise:
                s_A, s_B = a, b
        if closed:
            settled = True
            continue
        if near and best < -noise:
            break
        grown = total
        if count < most_vertices and not is_corner(points, faces, f, sub(s_A, s_B)):
            grown = expand(
                points, faces, planes, horizon, stack, starting_at, f, s_A, s_B, count, total, size
            )
            waiting = add_faces(points, faces, planes, heap, total, grown, waiting, size)
        if grown == total:
            break
        count, total = count + 1, grown
    depth = depth_at(points, faces, planes, total, best_direction, lower, enough, unique)
    outlive(block)
    return guarded_hulls(pair, depth, noise) if thin else depth
