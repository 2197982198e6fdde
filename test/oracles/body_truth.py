"""The truth of two bodies: closed forms of 50 digits where there are, else a search."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpmath import mp, mpf
from oracles import closed_forms

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.cross_check.surfaces import CONVEX, HALF_SPACE
from drake_geom_ros.math.array_types import Floats
from truth.references import convex
from truth.references.meshes import ball_distance
from truth.references.supports import offset_between, posed
from truth.tolerances import EPS, SEARCH

WITH_CLOSED_FORM = {(2, 2), (2, 3), (3, 3)}  # beside spheres and half spaces


def support_point(body: Body, n: Any) -> Floats:
    """Return the point of a body that is extreme along n; of a half space, along its normal."""
    if body.kind == 'HalfSpace':
        return body.p
    kind, size = body.form
    # The search squares lengths: at 1 m, where nothing of that leaves float64.
    s = np.ldexp(1.0, np.frexp(np.abs(body.size).max())[1])
    size = np.concatenate((size[:1], size[1:] / s)) if kind == CONVEX else size / s
    at_one_metre = posed((kind, size), body.R, np.zeros(3))
    point: Floats = body.p + s * at_one_metre.points(np.asarray(n, dtype=float)[None])[0]
    return point


def apart(a: Body, b: Body, n: Floats, gap: float) -> Body:
    """Return B so placed that it is a gap [m] from A along a unit n."""
    return b.at(support_point(a, n) + gap * n - (support_point(b, -n) - b.p))


def is_closed(a: Body, b: Body) -> bool:
    """Return whether the pair has a closed form with 50 digits."""
    low, high = sorted((a.form[0], b.form[0]))
    if high == CONVEX:
        return low == HALF_SPACE
    return low == 1 or high == HALF_SPACE or (low, high) in WITH_CLOSED_FORM


def signed_distance(a: Body, b: Body) -> tuple[float | None, float]:
    """Return (distance, tolerance): what is true, and within what.

    Of a Solid it is known for a Sphere as B, unless its way out is not straight (None).
    """
    tilt = sum(body.radius * body.skew for body in (a, b))
    if a.kind == 'Solid':
        return of_ball(a, b), tilt + EPS * (a.radius + np.abs(a.p).max())
    if is_closed(a, b):
        distance = _closed(a, b)
        return distance, tilt + EPS * abs(distance)
    return convex.signed_distance(a, b)[0], tilt + SEARCH * Pair(a, b).extent


def of_ball(solid: Body, ball: Body) -> float | None:
    """Return the distance of a Solid and a Sphere; None where its way out is not straight."""
    return ball_distance(solid.corners, solid.X_WG, ball.p, ball.size[0])


def _closed(a: Body, b: Body) -> float:
    if a.form[0] > b.form[0]:
        a, b = b, a
    if b.form[0] == CONVEX:  # over a half space its vertices are compared with all digits
        return convex.signed_distance(a, b)[0]
    with mp.workdps(closed_forms.DIGITS):
        (kind_a, size_a), (kind_b, size_b) = a.form, b.form
        # The forms tell what is 0 for bodies of about 1 m, so that tiny ones are brought to that.
        extent = Pair(a, b).extent
        s = mpf(2) ** -round(np.log2(extent)) if extent else mpf(1)
        p = [s * x for x in offset_between(a.p, b.p)]
        sizes = [[s * mpf(float(x)) for x in size] for size in (size_a, size_b)]
        found = closed_forms.signed_distance(kind_a, sizes[0], a.R, kind_b, sizes[1], b.R, p)
        return float(found / s)
