"""Certified least h on a great circle of directions, by arcs between support points.

On a circle about the unit e the support function h of the Minkowski difference D (see ``sums``)
satisfies ``h'' + h = rho`` in the angle, where rho is the radius of curvature of D: a measure,
with a mass at each *kink*, where n is normal to a segment. Arcs end at kinks, so within an arc rho
is a function. On an arc of width w (at most a right angle) h has two lower bounds, of which the
larger counts:

- The *chord*: u and v, the support points at the ends, are points of D, so ``h(n) >= max(u . n,
  v . n)``. Where they are positive both are concave, so the least of their maximum is at an end or
  where they cross: at the normal of the chord. This is a growing polygon, and proves a strict
  minimum in a few steps.
- The *bend*: ``h'' + h <= rho`` for the largest rho. Let g be the lesser of the values at the ends
  and t the angle from the middle of the arc: ``y = rho - (rho - g) cos t / cos(w / 2)`` solves
  ``y'' + y = rho``. So ``(h - y)'' + (h - y) <= 0``, and h - y is not negative at the ends of an
  arc shorter than a half turn: then it is not negative within (Sturm). The least of y is at an end
  if g >= rho, else at the middle. Where D is almost round about e, rho - g is almost 0: so a few
  arcs prove a ring of almost equal values, for which a polygon needs thousands.

An arc whose bound exceeds the best h is done; others are split. Newton's method computes the last
digits of a minimum, and its certified cap (see ``caps``) ends the splitting.
"""

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.cores.caps import widest_cap
from drake_geom_ros.geometry._proximity.kernels.cores.normals import NOTHING, nearby_minimum
from drake_geom_ros.geometry._proximity.kernels.cores.records import Difference, Minimum
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    AXES_A,
    AXES_B,
    LENGTH,
    MOST_SEGMENTS,
    SEGMENT,
    ellipsoid_support,
    ends_at,
    width,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    norm,
    perpendicular,
    scale,
    sub,
    unit,
    vector_at,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import RIGHT_ANGLE, SAME_DIRECTION, TIE

MOST_ARCS = 64
MOST_SPLITS = 600
MOST_KINKS = 2 * MOST_SEGMENTS + 2
NO_CAP = -1.0
BORDER = 0.01  # [rad]
# Columns of an arc: its two directions and its two support points.
START, END, START_POINT, END_POINT = 0, 3, 6, 9
ARC_WIDTH = 12
# Columns of a kink after its direction: its order by angle, and the ellipsoids' support point.
TURN, ROUND_POINT = 3, 4
KINK_WIDTH = 7


@compiled
def put_arc(
    arc: Floats, start: Vector, end: Vector, start_point: Vector, end_point: Vector
) -> None:
    """Store an arc."""
    for k in range(3):
        arc[START + k], arc[END + k] = start[k], end[k]
        arc[START_POINT + k], arc[END_POINT + k] = start_point[k], end_point[k]


@compiled
def turn_of(x: float, y: float) -> float:
    """Return a number in [-2, 2] that increases with the angle of (x, y)."""
    t = x / (abs(x) + abs(y))
    return 1.0 - t if y >= 0.0 else t - 1.0


@inlined
def across(n: Vector, e: Vector) -> Vector:
    """Return the unit n without the component along the unit e that rounding left.

    The cross product of almost parallel vectors is normal to neither within rounding.
    """
    return unit(add_scaled(n, -dot(n, e), e))


@compiled
def put_kink(kinks: Floats, count: int, n: Vector, x: Vector, y: Vector) -> int:
    """Insert the direction n among ``count`` others, sorted by angle in the plane of x and y."""
    turn = turn_of(dot(n, x), dot(n, y))
    at = count
    while at > 0 and kinks[at - 1, TURN] > turn:
        for c in range(KINK_WIDTH):
            kinks[at, c] = kinks[at - 1, c]
        at -= 1
    kinks[at, 0], kinks[at, 1], kinks[at, 2] = n
    kinks[at, TURN] = turn
    return count + 1


@compiled
def kinks_on_circle(terms: Floats, last: int, e: Vector, kinks: Floats) -> int:
    """Write the directions normal to e and a segment, sorted by angle; return how many.

    Where they leave arcs wider than a right angle, directions without a kink are inserted. That
    happens only if all segments are coplanar with e: the projections of a box's axes onto the
    plane normal to e are not all within a right angle, since the sum of their squares is the same
    in each direction of the plane.
    """
    x = perpendicular(e)
    y = cross(e, x)
    count = 0
    for k in range(SEGMENT, last):
        m = cross(e, vector_in(terms, k))
        # A segment along e within rounding has no kink: its ends differ only by rounding.
        if norm(m) > RIGHT_ANGLE * terms[k, LENGTH]:
            n = across(unit(m), e)
            count = put_kink(kinks, count, n, x, y)
            count = put_kink(kinks, count, scale(-1.0, n), x, y)
    if count == 0:
        count = put_kink(kinks, count, x, x, y)
        count = put_kink(kinks, count, scale(-1.0, x), x, y)
    if count == 2:
        n = unit(cross(e, vector_at(kinks[0], 0)))
        count = put_kink(kinks, count, n, x, y)
        count = put_kink(kinks, count, scale(-1.0, n), x, y)
    return count


@compiled
def may_reach(
    start: Vector, end: Vector, e: Vector, q: Vector, reach: float, noise: float
) -> bool:
    """Return whether q . n may be as large as ``reach`` on an arc of the circle about e.

    q . n is largest at an end of the arc, or along q, with the value |q|, if that is on the arc.
    All comparisons allow for ``noise`` [m], the rounding of q: an arc that reaches is never left
    out, but one that does not may be retained.
    """
    if dot(start, q) >= reach - noise or dot(end, q) >= reach - noise:
        return True
    inside = dot(cross(start, q), e) >= -noise and dot(cross(q, end), e) >= -noise
    return inside and norm(q) >= reach - noise


@compiled
def first_arcs(
    terms: Floats, last: int, e: Vector, reach: float, noise: float, arcs: Floats, kinks: Floats
) -> int:
    """Write the arcs between the kinks of the circle about e; return how many.

    Arcs on which p . n is certified to be below ``reach`` [m] are left out. On the circle p . n is
    q . n for the part q of p normal to e.
    """
    p = vector_in(terms, 0)
    q = add_scaled(p, -dot(p, e), e)
    if norm(q) < reach - noise:
        return 0
    count = kinks_on_circle(terms, last, e, kinks)
    arc, last_pointed = 0, -1  # the last kink whose support point is stored
    for k in range(count):
        after = k + 1 if k + 1 < count else 0
        start, end = vector_at(kinks[k], 0), vector_at(kinks[after], 0)
        if may_reach(start, end, e, q, reach, noise):
            if last_pointed != k:
                put_round_point(terms, kinks[k])
            put_round_point(terms, kinks[after])
            last_pointed = after
            base = ends_at(terms, last, add(start, end))
            u = add(base, vector_at(kinks[k], ROUND_POINT))
            v = add(base, vector_at(kinks[after], ROUND_POINT))
            put_arc(arcs[arc], start, end, u, v)
            arc += 1
    return arc


@inlined
def put_round_point(terms: Floats, kink: Floats) -> None:
    """Store the support point of the ellipsoids at a kink."""
    point = point_on_arc(terms, (0.0, 0.0, 0.0), vector_at(kink, 0))
    for c in range(3):
        kink[ROUND_POINT + c] = point[c]


@inlined
def point_on_arc(terms: Floats, base: Vector, n: Vector) -> Vector:
    """Return the support point at n of an arc on which the segments' ends add up to ``base``."""
    return add(base, add(ellipsoid_support(terms, AXES_A, n), ellipsoid_support(terms, AXES_B, n)))


@compiled
def largest_radius(terms: Floats, e: Vector) -> float:
    """Return a bound of the radius of curvature [m] of disks and ellipsoids on the circle about e.

    There ``|E n|`` is the support function of an ellipse, whose semi-axes a >= b have the
    eigenvalues of E^T E in the plane across e as squares; its largest radius is a^2 / b. Infinite
    for a disk that is seen from its edge.
    """
    x = perpendicular(e)
    y = cross(e, x)
    radius = 0.0
    for axes in (AXES_A, AXES_B):
        if terms[axes, LENGTH] > 0.0:
            xx, yy, xy = 0.0, 0.0, 0.0
            for k in range(3):
                u, v = dot(vector_in(terms, axes + k), x), dot(vector_in(terms, axes + k), y)
                xx, yy, xy = xx + u * u, yy + v * v, xy + u * v
            mean, spread = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
            least = mean - spread - TIE * mean
            if least <= 0.0:
                return math.inf
            radius += (mean + spread + TIE * mean) / math.sqrt(least)
    return radius


@compiled
def chord_of_cap(difference: Difference, minimum: Minimum, enough: float) -> float:
    """Return the chord of the certified cap of a minimum, or NO_CAP.

    It is a chord instead of a cosine, because caps may be as small as 1e-9 rad, with cosine 1.
    """
    cap = widest_cap(difference, minimum, enough)
    return 2.0 * math.sin(0.5 * cap) if cap > 0.0 else NO_CAP


@compiled
def improved(
    difference: Difference, n: Vector, h: float, enough: float, noise: float
) -> tuple[Vector, float, float]:
    """Return (n, h, chord of its cap) of the minimum near n, or of n itself if there is none."""
    minimum = nearby_minimum(difference, n, noise)
    if minimum.kind == NOTHING or minimum.h > h + noise:
        return n, h, NO_CAP
    return minimum.n, minimum.h, chord_of_cap(difference, minimum, enough)


@compiled
def chord_normal(arc: Floats, e: Vector) -> Vector:
    """Return the unit normal of an arc's chord on the circle about e, or 0 if beyond the arc."""
    start, end = vector_at(arc, START), vector_at(arc, END)
    m = across(unit(cross(sub(vector_at(arc, END_POINT), vector_at(arc, START_POINT)), e)), e)
    if dot(m, add(start, end)) < 0.0:
        m = scale(-1.0, m)
    if dot(cross(start, m), e) <= 0.0 or dot(cross(m, end), e) <= 0.0:
        return 0.0, 0.0, 0.0
    return m


@inlined
def values_at_ends(arc: Floats, radius: float) -> tuple[float, float, float]:
    """Return h at the start and end of an arc [m], and a crude lower bound, valid if positive.

    Directions of the arc are a start + b end with a + b >= 1. So a point of D reaches along n at
    least as far as along the end where it reaches less, if that is positive.
    """
    start, end = vector_at(arc, START), vector_at(arc, END)
    u, v = vector_at(arc, START_POINT), vector_at(arc, END_POINT)
    at_start, at_end = dot(u, start) - radius, dot(v, end) - radius
    crude = max(min(at_start, dot(u, end) - radius), min(at_end, dot(v, start) - radius))
    return at_start, at_end, crude


@compiled
def least_on_arc(arc: Floats, m: Vector, radius: float, rho: float) -> float:
    """Return a lower bound of h [m] on an arc with the chord's normal m (see *chord*, *bend*).

    ``radius`` [m] is that of the subtracted balls, ``rho`` [m] an upper bound of the radii of
    curvature of the rest.
    """
    start, end = vector_at(arc, START), vector_at(arc, END)
    u, v = vector_at(arc, START_POINT), vector_at(arc, END_POINT)
    ends = min(dot(u, start), dot(v, end))
    least = min(dot(u, m), dot(v, m), ends)
    if rho < math.inf:
        bent = ends
        if ends < rho:
            # Equal to rho - (rho - ends) / cos, for the half angle, without cancellation: rho may
            # be 1e6 times as large as the bodies (a disk seen almost from its edge).
            cosine, span = 0.5 * norm(add(start, end)), norm(sub(end, start))
            bent = (ends - rho * 0.25 * span * span / (1.0 + cosine)) / cosine
        least = max(least, bent)
    return least - radius


@inlined
def is_away(from_n: float, to_n: float, span: float) -> bool:
    """Return whether part of an arc of width ``span`` [rad] is clearly another direction than n.

    ``from_n`` and ``to_n`` are the cosines of its ends with n. A short arc across the border of
    what counts as another direction does not, since that border need not be exact.
    """
    across_border = max(from_n, to_n) >= SAME_DIRECTION and span <= BORDER
    return min(from_n, to_n) < SAME_DIRECTION and not across_border


class Best(NamedTuple):
    """The best direction n of a search so far, and its h [m].

    Within the angle of this ``chord`` nothing is less. If ``unique``, nothing clearly elsewhere is
    as good. No h examined so far is below ``floor`` [m].
    """

    n: Vector
    h: float
    chord: float
    unique: bool
    floor: float


@compiled
def least_on_circle(
    difference: Difference,
    e: Vector,
    best: Best,
    inner: float,
    enough: float,
    noise: float,
    arcs: Floats,
    kinks: Floats,
) -> tuple[bool, Best]:
    """Return (complete, best) for the circle of directions normal to the unit e.

    ``best`` is the ``Best`` so far. ``inner`` [m] is a lower bound of how far both cores together
    reach from their centres along any such direction. The search is not complete if the splitting
    of arcs was ended.

    Arcs left out by ``first_arcs`` contain nothing as good: the cores are symmetric, so ``h(n) >=
    inner - p . n``, and h(-n) is less than h(n) by -2 p . n.
    """
    terms, _, last, r_A, r_B = difference
    n, h, chord, unique, floor = best
    reach = max(inner - h, 0.0) - 2.0 * enough
    waiting = first_arcs(terms, last, e, reach, noise, arcs, kinks)
    radius, rho = r_A + r_B, largest_radius(terms, e)
    for _ in range(MOST_SPLITS):
        if waiting == 0:
            return True, Best(n, h, chord, unique, floor)
        waiting -= 1
        arc = arcs[waiting]
        start, end = vector_at(arc, START), vector_at(arc, END)
        u, v = vector_at(arc, START_POINT), vector_at(arc, END_POINT)
        from_n, to_n = dot(start, n), dot(end, n)
        if max(norm(sub(start, n)), norm(sub(end, n))) <= chord:
            continue
        away = is_away(from_n, to_n, norm(sub(end, start)))
        at_start, at_end, crude = values_at_ends(arc, radius)
        if from_n < SAME_DIRECTION and at_start <= h + 2.0 * enough:
            unique = False
        ends = min(at_start, at_end)
        if ends < h - noise:
            m = start if at_start < at_end else end
            n, h, chord = improved(difference, m, ends, enough, noise)
            unique = unique and not away
            waiting += 1  # examined again with the better minimum
            continue
        # Without a cap the minimum is so flat that only its tolerance can be proved.
        limit = h - (enough if chord == NO_CAP else noise)
        if unique and away:
            limit = h + 2.0 * enough
        if crude > 0.0 and crude >= limit:  # most arcs
            floor = min(floor, crude)
            continue
        m = chord_normal(arc, e)
        if dot(m, m) == 0.0:  # the least of the arc is at an end
            floor = min(floor, ends)
            continue
        least = least_on_arc(arc, m, radius, rho)
        if least >= limit:
            floor = min(floor, least)
            continue
        width_m = width(terms, last, radius, m)
        if width_m < h - noise:
            n_before, h_before = n, h
            n, h, chord = improved(difference, m, width_m, enough, noise)
            far = dot(n_before, n) < SAME_DIRECTION
            unique = h_before > h + 2.0 * enough if far else unique
        elif width_m <= h + 2.0 * enough and dot(m, n) < SAME_DIRECTION:
            unique = False
        if waiting + 2 > MOST_ARCS:
            break
        base = ends_at(terms, last, m)
        w = point_on_arc(terms, base, m)
        put_arc(arcs[waiting], start, m, u, w)
        put_arc(arcs[waiting + 1], m, end, w, v)
        waiting += 2
    return False, Best(n, h, chord, unique, floor)
