"""The true signed distance of two convex shapes, independent of the kernels.

``phi(A, B) = max over unit n of f(n)``, ``f(n) = -h_A(n) - h_B(-n)``, h the support functions. It
is found in three steps, and nothing of them is shared with the kernels:

search
    Where the bodies overlap: planes of the convex hull (Qhull) of support points of A - B, which
    is refined wherever one of its faces is nearer to the origin than the best direction known, so
    that no other direction can be better than those found by more than a small gap. Where they
    are apart f has one maximum, and caps that shrink around the best direction find it.
polish
    f is smooth but on great circles, at right angles to an edge of a polytope or to the axis of a
    cylinder or capsule. So near each direction found the maximum is a maximum of a smooth
    piece, one along such a circle, or the crossing of two: Newton's method finds all of these.
digits
    The best of them are evaluated with 40 digits (mpmath) on their circles, so that nothing but
    the rounding of the result is left: f is stationary along the circle, and exact across it.
"""

from __future__ import annotations

import math

import numpy as np
from mpmath import mp
from scipy.spatial import ConvexHull, QhullError

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.cross_check.surfaces import HALF_SPACE
from drake_geom_ros.math.array_types import Floats
from truth.bodies.random_bodies import even_directions
from truth.references.digits import dot, vector
from truth.references.polish import polished
from truth.references.supports import DIGITS, MinkowskiDifference, offset_between, posed
from truth.tolerances import CLIMBED, GAP, KNOWN, NEARBY, NO_DIRECTION, TIED

DENSE = 400  # directions that a search begins with
ROUNDS = 25  # of a search, each of which takes a new hull
MOST_OPEN = 150  # faces of the hull that one round refines
# Directions that are polished, best first; where more are as good, as in concentric bodies, it is
# by symmetry, or what they differ by polishing gains.
MOST_STARTS = 40


def signed_distance(a: Body, b: Body, near: Floats | None = None) -> tuple[float, Floats]:
    """Return phi [m] and a unit direction (3,) out of A that attains it.

    ``near`` is next to the best direction, where that is known: nothing is searched for then.
    Good to the rounding of the answer and of R. At most one of the two may be a half space.
    """
    with mp.workdps(DIGITS):
        if HALF_SPACE in (a.form[0], b.form[0]):
            return _half_space(a, b)
        pair = MinkowskiDifference(posed(a.form, *a.X_WG), posed(b.form, *b.X_WG))
        starts = search(pair) if near is None else [(near, KNOWN)]
        phi, n = max((polished(pair, *start) for start in starts), key=lambda each: each[0])
        return float(phi), n


def of_any_size(pair: Pair, near: Floats | None = None) -> float:
    """Return the signed distance [m] of a pair that may be tiny or huge, as ``signed_distance``.

    Lengths are brought to about 1 m by a power of two, which changes no digit: they are squared.
    """
    s = 2.0 ** -round(math.log2(pair.extent)) if pair.extent else 1.0
    scaled = pair.scaled(s)
    return signed_distance(scaled.a, scaled.b, near)[0] / s


def _half_space(a: Body, b: Body) -> tuple[float, Floats]:
    """Return the answer where one is a half space, which ends along its normal only."""
    if a.form[0] != HALF_SPACE:
        phi, n = _half_space(b, a)
        return phi, -n
    n = np.asarray(a.R, dtype=float)[:, 2]
    exact = vector(n)
    height = dot(offset_between(a.p, b.p), exact)
    below = posed(b.form, *b.X_WG).exact_height([-x for x in exact])
    return float(height - below), n


def search(pair: MinkowskiDifference) -> list[tuple[Floats, float]]:
    """Return directions (3,), one of them the best of all within the angle [rad] beside it."""
    n = np.vstack([even_directions(DENSE), *(_unit(x.flat @ x.R.T) for x in (pair.a, pair.b))])
    points = pair.gaps(n)
    values = np.einsum('ij,ij->i', points, n)
    found, best = [n[np.argmax(values)][None]], values.max()
    gap = GAP * pair.size
    for _ in range(ROUNDS):
        try:
            planes = np.unique(ConvexHull(points).equations, axis=0)
        except QhullError:  # flat: two bodies that are points or segments
            break
        # The plane's distance from the origin is at least f there, and f of what lies on it.
        normals, ahead = -planes[:, :3], planes[:, 3]
        open_ = np.flatnonzero(ahead > best + gap)
        tied = len(open_) > MOST_OPEN and ahead.max() < best + TIED * pair.size
        if tied or not len(open_):
            break
        open_ = open_[np.argsort(-ahead[open_])][:MOST_OPEN]
        new = pair.gaps(normals[open_])
        values = np.einsum('ij,ij->i', new, normals[open_])
        best = max(best, values.max())
        found.append(normals[open_])
        points = np.vstack([points, new])
    candidates = np.vstack(found)
    values = pair.values(candidates)
    order = np.argsort(-values)
    close = candidates[order[values[order] >= best - 2 * gap]]
    climbed = _climb(pair, candidates[order[0]])
    return [(climbed, CLIMBED), *((n, NEARBY) for n in _apart(close, NEARBY))]


def _climb(pair: MinkowskiDifference, n: Floats) -> Floats:
    """Return the best direction that caps around n find as they shrink."""
    angle = 4 / DENSE**0.5
    while angle > 0.2 * CLIMBED:
        around = _unit(n + angle * even_directions(120))
        around = np.vstack([n[None], around])
        best = around[np.argmax(pair.values(around))]
        # A better one at the rim: go on from there before looking closer.
        if best @ n > np.cos(0.5 * angle):
            angle *= 0.5
        n = best
    return n


def _unit(v: Floats) -> Floats:
    """Return vectors (m, 3) at unit length, without those that have none."""
    length = np.linalg.norm(v, axis=1)
    return v[length > NO_DIRECTION] / length[length > NO_DIRECTION, None]


def _apart(n: Floats, angle: float) -> Floats:
    """Return some of the directions, the first of those that are within an angle [rad]."""
    kept: list[Floats] = []
    for each in n:
        if all(each @ k < np.cos(angle) for k in kept):
            kept.append(each)
        if len(kept) == MOST_STARTS:
            break
    return np.array(kept)
