"""Depth of a core in a cylinder or capsule, where the separating translation is radial.

Two almost coaxial cylinders, or anything small in the middle of a cylinder, have a ring of almost
equally good directions normal to the axis u of the cylinder, which EPA would have to cover with
faces. The ring is the crease of the cylinder's axis, which ``circles`` searches. The criteria here
show that no direction off the ring is better.

*A long barrel.* Let the cylinder have radius r, 0 for the axis of a capsule, and half length l,
and ``h(n) = r s + l |c| + k(n)`` for ``n = s e + c u``, where k is the support function of the
rest. It is subadditive, so ``k(s e) <= k(n) + k(-c u)``, and with ``v = l - max(k(u), k(-u))``

    h(n) >= s (r + k(e)) + |c| v >= min(r + k(e), v)    where both are positive, as s + |c| >= 1.

If v is not below the least h on the crease, that is the depth, for any rest.

*A barrel about as long as wide.* Let the rest be within a ball of radius rho about the centre: its
support function k is within -rho and rho, and changes by at most rho times the angle. At the angle
phi from the crease, ``f = r cos(phi) + l sin(phi)`` is concave. So ``f(phi) >= f(0) + rho phi``
holds up to some angle, and ``f(phi) >= f(pi/2) + rho (pi/2 - phi)`` from some angle on. If both
hold at one angle, such as that of the largest f, h is nowhere less than at one of the ends of the
quarter circle, on the crease or along the axis.

*Two almost parallel cylinders.* Let phi be the angle about the axis u of one, of radius r, and
theta the angle from its crease. Along a half circle of constant phi only the disk of the other
cylinder is curved: its radius of curvature is ``r' (u' . t)^2 / s'^3``, with t normal to u and n,
which is at most ``r' sin^2(alpha) / s'^3`` for the angle alpha between the axes. Where no h is
below ``floor`` and that radius does not exceed it, h has a negative second derivative. So it is
least at a crease of either, or at the border of that region, the cap about u or -u where
``s <= s_0``. There ``h(n) >= y . n + r s + r' (s - sin alpha)`` for the point y of D at the ends
of both segments, which is concave in the angle while positive: least at u or at the border.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.normals import nowhere
from drake_geom_ros.geometry._proximity.kernels.cores.records import Difference, Least
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    AXES_A,
    AXES_B,
    LENGTH,
    SEGMENT,
    width,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.circles import (
    ARC_WIDTH,
    KINK_WIDTH,
    MOST_ARCS,
    MOST_KINKS,
    NO_CAP,
    Best,
    least_on_circle,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.creases import least_on_creases
from drake_geom_ros.geometry._proximity.kernels.revolution.rings import is_bulged
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    cross,
    dot,
    norm,
    scale,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled

STEEPEST = 0.9  # largest sine of the caps about the axes


@allocating
def least_in_long_barrel(
    difference: Difference, k: int, axes: int, n: Vector, h: float, enough: float, noise: float
) -> Least:
    """Return the least h for the cylinder with segment k and disk ``axes`` (0 for a capsule).

    ``n`` is a direction to start from, and h [m] its value. Complete if the barrel is long beside
    the rest (see *A long barrel*).
    """
    terms, _, last, r_A, r_B = difference
    length, radius = terms[k, LENGTH], terms[axes, LENGTH]
    u = scale(1.0 / length, vector_in(terms, k))
    # Along the axis the disk has no width, so the total width is l plus that of the rest.
    up = width(terms, last, r_A + r_B, u)
    down = width(terms, last, r_A + r_B, scale(-1.0, u))
    margin = length - (max(up, down) - length) - noise
    bulged = margin < h and is_bulged(radius, length, reach_beside(terms, last, k, axes))
    if margin < h and not bulged:
        return Least(False, h, -math.inf, n, False)
    arcs, kinks = np.empty((MOST_ARCS, ARC_WIDTH)), np.empty((MOST_KINKS, KINK_WIDTH))
    best = Best(n, h, NO_CAP, True, h)
    complete, best = least_on_circle(difference, u, best, 0.0, enough, noise, arcs, kinks)
    n, h, _, unique, floor = best
    if bulged:
        near = 2.0 * enough
        if min(up, down) < h:  # the best direction is off the crease
            unique = floor > min(up, down) + near and abs(up - down) > near
            n, h = (u, up) if up < down else (scale(-1.0, u), down)
        else:
            unique = unique and min(up, down) > h + near
        return Least(complete, h, min(floor, h), n, unique)
    return Least(
        complete and margin >= h, h, min(floor, h), n, unique and margin > h + 2.0 * enough
    )


@compiled
def reach_beside(terms: Floats, last: int, k: int, axes: int) -> float:
    """Return the radius [m] of a ball around the difference without the cylinder (k, axes)."""
    reach = norm(vector_in(terms, 0))
    for i in range(SEGMENT, last):
        reach += terms[i, LENGTH] if i != k else 0.0
    for other in (AXES_A, AXES_B):
        if other != axes:
            reach += max(terms[other, LENGTH], terms[other + 1, LENGTH], terms[other + 2, LENGTH])
    return reach


@compiled
def least_in_caps(terms: Floats, u: Vector, other: Vector, sine: float, radius: float) -> float:
    """Return a lower bound of h [m] in the caps of the given sine about u and -u.

    ``other`` is the axis of the other cylinder, ``radius`` [m] the sum of both radii.
    """
    p = vector_in(terms, 0)
    cosine, least = math.sqrt(1.0 - sine * sine), math.inf
    for side in (-1.0, 1.0):
        n = scale(side, u)
        y = scale(-1.0, p)
        for k in range(SEGMENT, SEGMENT + 2):
            s = vector_in(terms, k)
            y = add_scaled(y, 1.0 if dot(s, n) >= 0.0 else -1.0, s)
        along = dot(y, n)
        aside = norm(add_scaled(y, -along, n))
        least = min(least, along, along * cosine + (radius - aside) * sine)
    return least


@compiled
def least_of_barrels(
    difference: Difference, n: Vector, floor: float, enough: float, noise: float
) -> Least:
    """Return the least h of two cylinders, given a lower bound ``floor`` > 0 of h [m].

    Complete if they are parallel enough (see *Two almost parallel cylinders*).
    """
    terms = difference.terms
    first_is_wider = terms[AXES_A, LENGTH] >= terms[AXES_A + 3, LENGTH]
    k = SEGMENT if first_is_wider else SEGMENT + 1
    u = scale(1.0 / terms[k, LENGTH], vector_in(terms, k))
    m = 2 * SEGMENT + 1 - k
    other = scale(1.0 / terms[m, LENGTH], vector_in(terms, m))
    thin = min(terms[AXES_A, LENGTH], terms[AXES_A + 3, LENGTH])
    wide = max(terms[AXES_A, LENGTH], terms[AXES_A + 3, LENGTH])
    tilt = norm(cross(u, other))
    sine = tilt + (thin * tilt * tilt / (floor - noise)) ** (1.0 / 3.0) if floor > noise else 1.0
    if sine >= STEEPEST:
        return Least(False, 0.0, floor, n, False)
    caps = least_in_caps(terms, u, other, sine, thin + wide) - thin * tilt - noise
    complete, h, floor, n, unique = least_on_creases(difference, nowhere(n), enough, noise)
    return Least(complete and caps >= h - enough, h, min(floor, caps), n, unique)
