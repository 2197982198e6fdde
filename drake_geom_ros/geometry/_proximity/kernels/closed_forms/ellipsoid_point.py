"""Signed distance from a point to an ellipsoid, global and to rounding.

The point of the surface nearest to q satisfies ``x_i = e_i^2 q_i / (e_i^2 + s)`` for the largest
root s of ``S = sum_i (e_i q_i / (e_i^2 + s))^2 = 1`` above minus the square of the shortest
semi-axis, inside and outside alike (D. Eberly, *Distance from a Point to an Ellipse, an
Ellipsoid, or a Hyperellipsoid*). Two changes make it exact to rounding and short:

- the unknown is ``u = s + e_min^2``, so that every denominator is ``u + (e_i - e_min)(e_i +
  e_min)``, a sum of positive numbers that loses no digits, even where u is close to 0
  (near the medial set) or the axes are nearly equal;
- ``1 / sqrt(S)`` is concave in u and nearly linear, so Newton's method on it climbs from the
  left without overshoot (J. More and D. Sorensen, *Computing a Trust Region Step*, 1983). The
  start is the larger of two lower bounds, with ``f_i = e_i^2 - e_min^2``: ``max_i (e_i q_i -
  f_i)``, where S <= 3, and ``|e q|`` less the mean of the f_i by the weights ``(e_i q_i)^2``,
  where the asymptote of ``1 / sqrt(S)``, which a concave function is below, is 1. Where the
  bracket is wide its exponent is halved first, since Newton would only grow u by a half a step.

Where q lies so deep in the plane across the shortest axis that S < 1 already at u = 0, two
mirror images (or a circle) are nearest: the medial set.
"""

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.compiled import inlined
from drake_geom_ros.geometry._proximity.kernels.vectors import Vector, norm, unit
from drake_geom_ros.geometry._proximity.tolerances import (
    DISTINCT_NORMALS,
    ELLIPSOID_HALVINGS,
    ELLIPSOID_STEPS,
    EPS,
    VANISHING,
)


class Nearest(NamedTuple):
    """The point N of a shape's surface nearest to q: ``q - p_GN = distance * grad``.

    ``distance`` [m] is signed, negative inside, ``grad`` its unit gradient, which is the outward
    normal at N, and ``unique`` tells whether there is only one such point.
    """

    distance: float
    grad: Vector
    p_GN: Vector
    unique: bool


@inlined
def _image(w, f, u):
    """Return x_i / e_i at the parameter u, for weights w = e q and poles at -f."""
    return (
        w[0] / (u + f[0]) if w[0] > 0.0 else 0.0,
        w[1] / (u + f[1]) if w[1] > 0.0 else 0.0,
        w[2] / (u + f[2]) if w[2] > 0.0 else 0.0,
    )


@inlined
def _newton_step(w, f, u):
    """Return Newton's step for 1 / sqrt(S) = 1 at u, or 0 where S <= 1 to rounding."""
    size, slope = 0.0, 0.0
    for k in range(3):
        if w[k] > 0.0:
            # Divisions take most of the time here: one an axis, and the last point is exact.
            r = 1.0 / (u + f[k])
            y = w[k] * r
            size += y * y
            slope += y * y * r
    if size <= 1.0 + 2.0 * EPS:
        return 0.0
    return size * (math.sqrt(size) - 1.0) / slope


@inlined
def _largest_root(w, f, low):
    """Return the root u > 0 of |_image(w, f, u)| = 1, given a lower bound low > 0 of it."""
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
    u = low
    for _ in range(ELLIPSOID_STEPS):
        step = _newton_step(w, f, u)
        u += step
        if step <= EPS * u:
            break
    return u


@inlined
def ellipsoid_point(e, q, slack):
    """Return the point of the ellipsoid with semi-axes e that is nearest to q.

    See ``points`` for the meaning of slack.
    """
    # All in units of the longest semi-axis, in the octant of q.
    longest, shortest = max(e), min(e)
    a = (e[0] / longest, e[1] / longest, e[2] / longest)
    p = (abs(q[0]) / longest, abs(q[1]) / longest, abs(q[2]) / longest)
    a_min = shortest / longest
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
    low = max(w[0] - f[0], w[1] - f[1], w[2] - f[2])
    medial = False
    if low > 0.0:
        u = _largest_root(w, f, low)
        y = _image(w, f, u)
    else:
        u = 0.0
        y = _image(w, f, u)
        room = 1.0 - (y[0] * y[0] + y[1] * y[1] + y[2] * y[2])
        if room < -2.0 * EPS:
            u = _largest_root(w, f, _newton_step(w, f, 0.0))
            y = _image(w, f, u)
        elif room > 0.0:
            medial = True
            side = math.sqrt(room)
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

    # A mirror image that is as near to rounding: 4 q_i x_i more in the square of the distance.
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
    return Nearest(distance, grad, p_GN, unique)
