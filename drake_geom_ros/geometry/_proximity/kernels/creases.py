"""Depth of a box or capsule in a cylinder: the least of all kinds of normals that there are.

The support function h of the Minkowski difference D of two overlapping cores has a local minimum
only where D has no radius of curvature below h in any direction. A sum of segments and one disk is
nowhere curved in two directions, so its minima are on faces of D (two segments, or a disk) and on
its creases: great circles at right angles to a segment (see ``sums``). There are few faces, and on
a circle the least is found by growing a polygon: between two support points u and v a lower bound
of h is ``max(u . n, v . n)``, which is least at the normal of their chord. Arcs where that is
below the best h so far are split there; Newton's method takes the last digits, and the cap that it
proves (see ``normals``) ends the splitting.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.normals import (
    NOTHING,
    nearby_minimum,
    widest_cap,
)
from drake_geom_ros.geometry._proximity.kernels.sums import (
    AXES_A,
    AXES_B,
    LENGTH,
    MOST_SEGMENTS,
    SEGMENT,
    ends_at,
    likely_normal,
    tip,
    vector,
    width,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    cross,
    dot,
    perpendicular,
    scale,
    sub,
    unit,
)
from drake_geom_ros.geometry._proximity.tolerances import RIGHT_ANGLE, SAME_DIRECTION

MOST_ARCS = 64
MOST_SPLITS = 400
NO_CAP = 2.0
# Columns of an arc: its two directions and its two support points.
START, END, START_POINT, END_POINT = 0, 3, 6, 9
ARC_WIDTH = 12


@compiled
def part(row, k):
    """Return three numbers of a row from column k as a vector."""
    return row[k], row[k + 1], row[k + 2]


@compiled
def put_arc(arc, start, end, start_point, end_point):
    """Store an arc."""
    for k in range(3):
        arc[START + k], arc[END + k] = start[k], end[k]
        arc[START_POINT + k], arc[END_POINT + k] = start_point[k], end_point[k]


@compiled
def turn_of(x, y):
    """Return a number in [-2, 2] that grows with the angle of (x, y)."""
    t = x / (abs(x) + abs(y))
    return 1.0 - t if y >= 0.0 else t - 1.0


@compiled
def kinks_on_circle(terms, last, e, kinks):
    """Fill in the directions at right angles to e and a segment, in turn; return how many."""
    x = perpendicular(e)
    y = cross(e, x)
    count = 0
    for k in range(SEGMENT, last):
        m = cross(e, vector(terms, k))
        length = math.sqrt(dot(m, m))
        if length <= RIGHT_ANGLE * terms[k, LENGTH]:
            continue
        for side in (1.0 / length, -1.0 / length):
            n = scale(side, m)
            turn = turn_of(dot(n, x), dot(n, y))
            at = count
            while at > 0 and kinks[at - 1, 3] > turn:
                for c in range(4):
                    kinks[at, c] = kinks[at - 1, c]
                at -= 1
            kinks[at, 0], kinks[at, 1], kinks[at, 2], kinks[at, 3] = (
                n[0],
                n[1],
                n[2],
                turn,
            )
            count += 1
    if count == 0:
        for k in range(4):
            n = x if k % 2 == 0 else y
            for c in range(3):
                kinks[k, c] = n[c] if k < 2 else -n[c]
        count = 4
    return count


@compiled
def may_reach(start, end, e, p, reach):
    """Tell whether p . n may be as large as ``reach`` on an arc of the circle about e."""
    if dot(start, p) >= reach or dot(end, p) >= reach:
        return True
    inside = dot(cross(start, p), e) > 0.0 and dot(cross(p, end), e) > 0.0
    along = dot(p, e)
    return inside and dot(p, p) - along * along >= reach * reach


@compiled
def first_arcs(terms, last, i, reach, arcs, kinks):
    """Fill in the arcs between the kinks of the circle of segment i; return how many.

    Arcs on which p . n is below ``reach`` [m] hold no least h and are left out.
    """
    p = vector(terms, 0)
    e = scale(1.0 / terms[i, LENGTH], vector(terms, i))
    along = dot(p, e)
    if dot(p, p) - along * along < reach * reach:
        return 0
    count = kinks_on_circle(terms, last, e, kinks)
    arc = 0
    for k in range(count):
        start, end = part(kinks[k], 0), part(kinks[(k + 1) % count], 0)
        if may_reach(start, end, e, p, reach):
            base = ends_at(terms, last, add(start, end))
            u = add(base, add(tip(terms, AXES_A, start), tip(terms, AXES_B, start)))
            v = add(base, add(tip(terms, AXES_A, end), tip(terms, AXES_B, end)))
            put_arc(arcs[arc], start, end, u, v)
            arc += 1
    return arc


@compiled
def inner_radius(terms, first, last, axes):
    """Return the radius [m] of a ball in the core whose segments are from first to last."""
    if terms[axes, LENGTH] > 0.0:
        return min(terms[axes, LENGTH], terms[first, LENGTH])
    if last - first < 3:
        return 0.0
    return min(terms[first, LENGTH], terms[first + 1, LENGTH], terms[first + 2, LENGTH])


@compiled
def improved(difference, n, h, enough, noise):
    """Return (n, h, cosine of its cap) of the minimum near n, or of n if there is none."""
    found = nearby_minimum(difference, n, noise)
    if found[0] == NOTHING or found[2] > h + noise:
        return n, h, NO_CAP
    return found[1], found[2], math.cos(widest_cap(difference, found, enough))


@compiled
def chord_normal(arc, e):
    """Return the unit normal of an arc's chord on the circle about e, or 0 if beyond the arc."""
    start, end = part(arc, START), part(arc, END)
    m = unit(cross(sub(part(arc, END_POINT), part(arc, START_POINT)), e))
    if dot(m, add(start, end)) < 0.0:
        m = scale(-1.0, m)
    if dot(cross(start, m), e) <= 0.0 or dot(cross(m, end), e) <= 0.0:
        return 0.0, 0.0, 0.0
    return m


@compiled
def least_on_circle(difference, i, best, inner, enough, noise, arcs, kinks):
    """Return (complete, best) for the circle at right angles to segment i.

    ``best`` is (n, h, cosine, unique): the best direction so far, the cosine of the angle around
    it in which nothing is less, and whether nothing clearly elsewhere is as good.
    """
    terms, _, last, r_A, r_B = difference
    n, h, cosine, unique = best
    e = scale(1.0 / terms[i, LENGTH], vector(terms, i))
    # Both cores are symmetric, so h(n) >= inner - p . n.
    waiting = first_arcs(terms, last, i, max(inner - h - 2.0 * enough, 0.0), arcs, kinks)
    for _ in range(MOST_SPLITS):
        if waiting == 0:
            return True, (n, h, cosine, unique)
        waiting -= 1
        arc = arcs[waiting]
        start, end = part(arc, START), part(arc, END)
        u, v = part(arc, START_POINT), part(arc, END_POINT)
        if dot(start, n) < SAME_DIRECTION and dot(u, start) <= h + 2.0 * enough:
            unique = False
        m = chord_normal(arc, e)
        limit = h + 2.0 * enough if unique else h - noise
        if dot(m, m) == 0.0 or min(dot(u, m), dot(v, m)) >= limit:
            continue
        if dot(start, n) >= cosine and dot(end, n) >= cosine:
            continue
        width_m = width(terms, last, r_A + r_B, m)
        if width_m < h - noise:
            before = n, h
            n, h, cosine = improved(difference, m, width_m, enough, noise)
            far = dot(before[0], n) < SAME_DIRECTION
            unique = before[1] > h + 2.0 * enough if far else unique
        elif width_m <= h + 2.0 * enough and dot(m, n) < SAME_DIRECTION:
            unique = False
        if waiting + 2 > MOST_ARCS:
            break
        base = ends_at(terms, last, m)
        w = add(base, add(tip(terms, AXES_A, m), tip(terms, AXES_B, m)))
        put_arc(arcs[waiting], start, m, u, w)
        put_arc(arcs[waiting + 1], m, end, w, v)
        waiting += 2
    return False, (n, h, cosine, unique)


@compiled
def least_on_creases(difference, n, enough, noise):
    """Return (complete, h, n, unique): the least h over all faces and creases, and where.

    ``n`` is any direction to start from. Not complete where the splitting of arcs did not come to
    an end. It is the depth if the cores overlap: h is positive then.
    """
    terms, first, last, r_A, r_B = difference
    inner = inner_radius(terms, SEGMENT, first, AXES_A) + inner_radius(terms, first, last, AXES_B)
    arcs, kinks = np.empty((MOST_ARCS, ARC_WIDTH)), np.empty((2 * MOST_SEGMENTS, 4))
    n = likely_normal(difference, n)
    n, h, cosine = improved(difference, n, width(terms, last, r_A + r_B, n), enough, noise)
    best = n, h, cosine, True
    complete = True
    for i in range(SEGMENT, last):
        done, best = least_on_circle(difference, i, best, inner, enough, noise, arcs, kinks)
        complete = complete and done
    n, h, cosine, unique = best
    axes = AXES_A if terms[AXES_A, LENGTH] > 0.0 else AXES_B
    axis = unit(cross(vector(terms, axes), vector(terms, axes + 1)))
    for side in (-1.0, 1.0):
        m = scale(side, axis)
        if dot(m, n) < SAME_DIRECTION and width(terms, last, r_A + r_B, m) <= h + 2.0 * enough:
            unique = False
    return complete, h, n, unique
