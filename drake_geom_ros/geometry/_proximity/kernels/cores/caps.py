"""Certified caps of directions around a minimum of h, in which h is nowhere less.

On a great circle from n, ``g'' + g = rho`` where g is h and rho >= 0 the radius of curvature (a
measure: kinks only add to it). If ``rho >= rho_0`` within the angle C, then ``g >= g(0) cos +
g'(0) sin + rho_0 (1 - cos)`` there. With ``rho_0 >= g(0)`` that is at least g(0), up to the square
of the slope that Newton's method left. The ellipsoid ``y = |E n|`` has ``rho = const / y^3`` on
the circle, and in the cap y is at most ``y_0 cos C + |E| sin C`` and at most |E|: ``rho_0`` is rho
times the cube of y_0 over the smaller of both. So a whole cap of directions is certified at once,
for which a polytope would need dozens of faces.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.cores.normals import CREASE, FLAT, SMOOTH
from drake_geom_ros.geometry._proximity.kernels.cores.records import Difference, Minimum
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    AXES_A,
    AXES_B,
    LENGTH,
    SEGMENT,
    SHARE,
    curvature,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    cross,
    perpendicular,
    scale,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

WIDEST_CAP = 1.2  # [rad]; wider ones would save no faces
NARROWER = 0.7  # times a cap that could not be proven
LEAST_CAP = 0.002  # [rad]
FLAT_SHARE = 0.9  # of the margin of a face; the rest is ten times what CLEAR requires
# h rises in a cap with the cosine of the angle. At the angle where another normal counts as
# clearly different, this share of the coefficient remains after the effect of all other terms.
CLEAR = 0.125 * (1.0 - SAME_DIRECTION)


@compiled
def sharpness(
    terms: Floats, radius: float, n: Vector, e: Vector, f: Vector, cap: float
) -> tuple[float, float, float]:
    """Return the least radii of curvature [m] of D within ``cap`` [rad] of n, see the module."""
    m11, m12, m22 = -radius, 0.0, -radius
    cosine, sine = math.cos(cap), math.sin(cap)
    for axes in (AXES_A, AXES_B):
        y, _, _, k11, k12, k22 = curvature(terms, axes, n, e, f)
        if y > 0.0:
            longest = max(terms[axes, LENGTH], terms[axes + 1, LENGTH], terms[axes + 2, LENGTH])
            q = y / min(y * cosine + longest * sine, longest)
            q = q * q * q
            m11, m12, m22 = m11 + q * k11, m12 + q * k12, m22 + q * k22
    return m11, m12, m22


@compiled
def is_cap(
    terms: Floats, last: int, radius: float, minimum: Minimum, cap: float, enough: float
) -> bool:
    """Return whether h is nowhere less than the minimum within ``cap`` [rad] of it."""
    kind, n, h, margin = minimum
    half = math.tan(0.5 * cap)
    e = (0.0, 0.0, 0.0)
    for k in range(SEGMENT, last):
        if kind == CREASE and abs(terms[k, SHARE]) < 1.0:
            e = scale(1.0 / terms[k, LENGTH], vector_in(terms, k))
    if kind == SMOOTH:
        e = perpendicular(n)
    f = cross(n, e)
    m11, m12, m22 = sharpness(terms, radius, n, e, f, cap)
    m11, m22 = m11 - h, m22 - h
    if kind == SMOOTH:
        # The least eigenvalue.
        rise = 0.5 * (m11 + m22) - math.hypot(0.5 * (m11 - m22), m12)
        return rise * CLEAR >= enough
    if min(margin, m22) * CLEAR < enough:
        return False
    return margin >= 2.0 * half * (2.0 * m12 * m12 / m22 - m11)


@compiled
def widest_cap(difference: Difference, minimum: Minimum, enough: float) -> float:
    """Return the angle [rad] of a certified cap around the minimum; 0 if there is none."""
    terms, _, last, r_A, r_B = difference
    cap = WIDEST_CAP
    if minimum.kind == FLAT:
        h, margin = minimum.h, minimum.margin
        if margin * CLEAR < enough:
            return 0.0
        return min(cap, 2.0 * math.atan(FLAT_SHARE * margin / max(h, FLAT_SHARE * margin)))
    if not is_cap(terms, last, r_A + r_B, minimum, LEAST_CAP, enough):
        return 0.0
    while cap > LEAST_CAP and not is_cap(terms, last, r_A + r_B, minimum, cap, enough):
        cap *= NARROWER
    return max(cap, LEAST_CAP)
