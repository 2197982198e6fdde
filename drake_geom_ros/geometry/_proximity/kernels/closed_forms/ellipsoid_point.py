"""Signed distance from a point to an ellipsoid: the global minimum, exact to rounding.

The point of the surface nearest to q satisfies ``x_i = e_i^2 q_i / (e_i^2 + s)`` for the largest
root s of ``S = sum_i (e_i q_i / (e_i^2 + s))^2 = 1`` above minus the square of the shortest
semi-axis, inside and outside alike (D. Eberly, *Distance from a Point to an Ellipse, an
Ellipsoid, or a Hyperellipsoid*). Two changes make it exact to rounding and fast:

- the unknown is ``u = s + e_min^2``, so that every denominator is ``u + (e_i - e_min)(e_i +
  e_min)``, a sum of positive numbers that loses no digits, even where u is close to 0
  (near the medial set) or the axes are nearly equal;
- ``1 / sqrt(S)`` is concave in u and nearly linear, so Newton's method on it climbs from the
  left without overshoot (J. More and D. Sorensen, *Computing a Trust Region Step*, 1983). The
  start is the larger of two lower bounds, with ``f_i = e_i^2 - e_min^2``: ``max_i (e_i q_i -
  f_i)``, where S <= 3, and ``|e q|`` less the mean of the f_i by the weights ``(e_i q_i)^2``,
  where the asymptote of ``1 / sqrt(S)``, which a concave function is below, is 1. Where the
  bracket is wide its exponent is halved first, since Newton would only grow u by a half a step.

Where q lies so deep in the plane normal to the shortest axis that S < 1 at u = 0, two
mirror images (or a circle) are nearest: the medial set.
"""

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.vectors import norm, unit
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import row
from drake_geom_ros.geometry._proximity.tolerances import (
    DISTINCT_NORMALS,
    ELLIPSOID_HALVINGS,
    ELLIPSOID_STEPS,
    EPS,
    VANISHING,
)

# Points outside rarely need more than four; a vectorised step costs a tenth of a scalar one.
STEPS_OF_ALL = 4


class NearestOnSurface(NamedTuple):
    """The point N of a shape's surface nearest to q: ``q - p_GN = distance * grad``.

    ``distance`` [m] is signed, negative inside, ``grad`` its unit gradient, which is the outward
    normal at N, and ``unique`` is True if there is only one such point.
    """

    distance: float
    grad: Vector
    p_GN: Vector
    unique: bool


class Octant(NamedTuple):
    """A point relative to an ellipsoid, in units of the longest semi-axis, coordinates >= 0.

    ``w = e q`` are the weights of the image, and ``-f`` its poles, ``f = e^2 - e_min^2``.
    """

    w: Vector
    f: Vector
    a: Vector  # semi-axes
    a_min: float
    longest: float  # [m]


@inlined
def in_octant(e: Vector, q: Vector) -> Octant:
    """Return the octant of the point q for the ellipsoid with semi-axes e."""
    longest = max(e)
    a = (e[0] / longest, e[1] / longest, e[2] / longest)
    p = (abs(q[0]) / longest, abs(q[1]) / longest, abs(q[2]) / longest)
    a_min = min(e) / longest
    f = (
        (a[0] - a_min) * (a[0] + a_min),
        (a[1] - a_min) * (a[1] + a_min),
        (a[2] - a_min) * (a[2] + a_min),
    )
    w = (
        a[0] * p[0] if p[0] > VANISHING else 0.0,
        a[1] * p[1] if p[1] > VANISHING else 0.0,
        a[2] * p[2] if p[2] > VANISHING else 0.0,
    )
    return Octant(w, f, a, a_min, longest)


@inlined
def _image(w: Vector, f: Vector, u: float) -> Vector:
    """Return x_i / e_i at the parameter u, for weights w = e q and poles at -f."""
    return (
        w[0] / (u + f[0]) if w[0] > 0.0 else 0.0,
        w[1] / (u + f[1]) if w[1] > 0.0 else 0.0,
        w[2] / (u + f[2]) if w[2] > 0.0 else 0.0,
    )


@inlined
def newton_step(w: Vector, f: Vector, u: float) -> float:
    """Return Newton's step for 1 / sqrt(S) = 1 at u, or 0 where S <= 1 within rounding."""
    # Divisions take most of the time, so there is one per axis; the last point is exact.
    r = 1.0 / (u + f[0]) if w[0] > 0.0 else 0.0
    s = 1.0 / (u + f[1]) if w[1] > 0.0 else 0.0
    t = 1.0 / (u + f[2]) if w[2] > 0.0 else 0.0
    x, y, z = w[0] * r, w[1] * s, w[2] * t
    x, y, z = x * x, y * y, z * z
    size, slope = x + y + z, x * r + y * s + z * t
    return size * (math.sqrt(size) - 1.0) / slope if size > 1.0 + 2.0 * EPS else 0.0


@inlined
def _below_root(w: Vector, f: Vector, low: float) -> float:
    """Return a sharper lower bound than ``low`` > 0 of the root of |_image(w, f, u)| = 1."""
    high = norm(w)
    mean = 0.0
    for k in range(3):
        share = w[k] / high
        mean += share * share * f[k]
    low = max(low, high - mean)
    for _ in range(ELLIPSOID_HALVINGS):
        if high <= 4.0 * low:
            break
        middle = math.sqrt(low) * math.sqrt(high)
        if norm(_image(w, f, middle)) > 1.0:
            low = middle
        else:
            high = middle
    return low


@inlined
def first_parameter(octant: Octant) -> float:
    """Return the start of Newton's method: at most the root, or 0 if no root is positive."""
    w, f = octant.w, octant.f
    low = max(w[0] - f[0], w[1] - f[1], w[2] - f[2])
    if low > 0.0:
        return _below_root(w, f, low)
    y = _image(w, f, 0.0)
    if y[0] * y[0] + y[1] * y[1] + y[2] * y[2] > 1.0 + 2.0 * EPS:
        return _below_root(w, f, newton_step(w, f, 0.0))
    return 0.0


@inlined
def last_parameter(octant: Octant, u: float) -> float:
    """Return the root by Newton's method from a lower bound u, or 0."""
    for _ in range(ELLIPSOID_STEPS):
        step = newton_step(octant.w, octant.f, u)
        u += step
        if step <= EPS * u:
            break
    return u


@compiled
def step_all(f: Vector, work: Floats) -> None:
    """Do some steps of ``last_parameter`` for many points, each step for all points at once.

    ``work`` (5, n) holds their weights w, their parameters, and 1 for points not converged yet.
    """
    xs, ys, zs, us, going = row(work, 0), row(work, 1), row(work, 2), row(work, 3), row(work, 4)
    for _ in range(STEPS_OF_ALL):
        for k in range(unsigned(us.size)):
            u = us[k]
            step = going[k] * newton_step((xs[k], ys[k], zs[k]), f, u)
            u += step
            us[k] = u
            going[k] = 0.0 if step <= EPS * u else 1.0


@inlined
def nearest_at(e: Vector, q: Vector, slack: float, octant: Octant, u: float) -> NearestOnSurface:
    """Return the point of the ellipsoid nearest to q, from the parameter of its image."""
    _, _, a, a_min, longest = octant
    y = _image(octant.w, octant.f, u)
    room = 1.0 - (y[0] * y[0] + y[1] * y[1] + y[2] * y[2])
    medial = u == 0.0 and room > 0.0
    if medial:
        side, shortest = math.sqrt(room), min(e)
        if e[0] == shortest:
            y = (side, y[1], y[2])
        elif e[1] == shortest:
            y = (y[0], side, y[2])
        else:
            y = (y[0], y[1], side)
    y = unit(y)
    normal = (y[0] / a[0], y[1] / a[1], y[2] / a[2])
    distance = longest * (u - a_min * a_min) * norm(normal)
    grad = unit(normal)

    # A mirror image may be equally near within rounding: its squared distance has 4 q_i x_i more.
    unique = not medial
    for k in range(3):
        near = 2.0 * abs(q[k]) * e[k] * y[k] <= -distance * slack
        if near and grad[k] > DISTINCT_NORMALS:
            unique = False
    s = (
        -1.0 if q[0] < 0.0 else 1.0,
        -1.0 if q[1] < 0.0 else 1.0,
        -1.0 if q[2] < 0.0 else 1.0,
    )
    grad = (s[0] * grad[0], s[1] * grad[1], s[2] * grad[2])
    p_GN = (s[0] * e[0] * y[0], s[1] * e[1] * y[1], s[2] * e[2] * y[2])
    return NearestOnSurface(distance, grad, p_GN, unique)


@inlined
def ellipsoid_point(e: Vector, q: Vector, slack: float) -> NearestOnSurface:
    """Return the point of the ellipsoid with semi-axes e nearest to q.

    See ``points`` for the meaning of slack.
    """
    octant = in_octant(e, q)
    u = last_parameter(octant, first_parameter(octant))
    return nearest_at(e, q, slack, octant, u)
