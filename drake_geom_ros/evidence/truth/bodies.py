"""The truth of a hard case: closed forms of 50 digits where there are, else the direction search.

Nothing of the engine takes part.
"""

import itertools

import numpy as np
from mpmath import mp, mpf

from drake_geom_ros.evidence.tolerances import EPS, SEARCH
from drake_geom_ros.evidence.truth import closed_forms, supports
from drake_geom_ros.evidence.truth.convex import signed_distance as searched_distance
from drake_geom_ros.evidence.truth.meshes import ball_distance

KINDS = ('Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'HalfSpace', 'Convex')


def kernel_form(body):
    """Return (type number, parameters) of a body as the oracles take them."""
    size = np.array(body.size, dtype=float)
    factors = {'Box': 0.5, 'Capsule': [1.0, 0.5], 'Cylinder': [1.0, 0.5]}.get(body.kind, 1.0)
    if body.kind == 'Convex':
        size = np.concatenate(([len(size)], size.ravel()))
        factors = 1.0
    return 1 + KINDS.index(body.kind), size * factors


def support(body, n):
    """Return the point of a body that is extreme along n; of a half space, along its normal."""
    if body.kind == 'HalfSpace':
        return body.p
    kind, size = kernel_form(body)
    # The oracle squares lengths: at 1 m, where nothing of that leaves float64.
    s = np.ldexp(1.0, np.frexp(np.abs(body.size).max())[1])
    size = np.concatenate((size[:1], size[1:] / s)) if body.kind == 'Convex' else size / s
    at_one_metre = supports.posed((kind, size), body.R, np.zeros(3))
    return body.p + s * at_one_metre.points(np.asarray(n, dtype=float)[None])[0]


def width(a, b, nhat_BA_W):
    """Return the gap between the supporting planes along a unit normal: at most the distance."""
    offset, normal = b.p - a.p, np.asarray(nhat_BA_W, dtype=float)
    near = [support(body, sign * normal) - body.p for body, sign in ((a, -1.0), (b, 1.0))]
    return float((near[0] - near[1] - offset) @ normal)


def is_closed(a, b):
    """Return whether the pair has a closed form with 50 digits."""
    low, high = sorted((kernel_form(a)[0], kernel_form(b)[0]))
    if 7 in (low, high):
        return (low, high) == (6, 7)
    return low == 1 or high == 6 or (low, high) in {(2, 2), (2, 3), (3, 3)}


def signed_distance(a, b):
    """Return (distance, tolerance): what is true, and within what.

    Of a Solid it is known for a Sphere as B, unless its way out is not straight.
    """
    tilt = sum(body.radius * np.abs(body.R.T @ body.R - np.eye(3)).max() for body in (a, b))
    if a.kind == 'Solid':
        return of_ball(a, b), tilt + EPS * (a.radius + np.abs(a.p).max())
    if is_closed(a, b):
        distance = _closed(a, b)
        return distance, tilt + EPS * abs(distance)
    distance, _ = searched_distance(kernel_form(a), (a.R, a.p), kernel_form(b), (b.R, b.p))
    extent = a.radius + b.radius + np.linalg.norm(b.p - a.p)
    return float(distance), tilt + SEARCH * extent


def of_ball(solid, ball):
    """Return the distance of a Solid and a Sphere; None where its way out is not straight."""
    return ball_distance(solid.corners, (solid.R, solid.p), ball.p, ball.size[0])


def _closed(a, b):
    if kernel_form(a)[0] > kernel_form(b)[0]:
        a, b = b, a
    if b.kind == 'Convex':
        return _lowest_vertex(b, a)
    with mp.workdps(closed_forms.DIGITS):
        (kind_a, size_a), (kind_b, size_b) = kernel_form(a), kernel_form(b)
        # The difference of positions is exact in mpmath, not in float64; and the forms tell what
        # is 0 for bodies of about 1 m, so that tiny ones are brought to that size.
        extent = a.radius + b.radius + np.linalg.norm(b.p - a.p)
        s = mpf(2) ** -round(np.log2(extent)) if extent else mpf(1)
        p = [s * (mpf(float(y)) - mpf(float(x))) for x, y in zip(a.p, b.p, strict=True)]
        size_a, size_b = ([s * mpf(float(x)) for x in size] for size in (size_a, size_b))
        return float(closed_forms.signed_distance(kind_a, size_a, a.R, kind_b, size_b, b.R, p) / s)


def _lowest_vertex(hull, half_space):
    """Height of a hull's lowest vertex over a half space."""
    with mp.workdps(closed_forms.DIGITS):
        n = closed_forms.vector(half_space.R[:, 2])
        offset = [mpf(float(y)) - mpf(float(x)) for x, y in zip(half_space.p, hull.p, strict=True)]
        heights = [
            sum(
                (mpf(float(hull.R[i, k])) * mpf(float(v[k])) * n[i])
                for i, k in itertools.product(range(3), repeat=2)
            )
            for v in hull.size
        ]
        return float(min(heights) + closed_forms.dot(offset, n))
