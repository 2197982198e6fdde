"""The maximum of f near a direction, to the last digit.

f is smooth but on great circles, at right angles to an edge of a polytope or to the axis of a
cylinder or capsule. So its maximum is one of a smooth piece, one along such a circle, or the
crossing of two: Newton's method finds all that are near. The best of them are evaluated with 40
digits (mpmath), on their circles: f is stationary along a circle and exact across it, so nothing
but the rounding of the result is left.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
from mpmath import mpf
from numpy.typing import NDArray

from drake_geom_ros.math.array_types import Floats
from truth.references.digits import combine, cross, dot, vector
from truth.references.supports import MinkowskiDifference, MinkowskiSum
from truth.tolerances import EQUAL, GAIN, LAST_STEP, LEAST_CURVATURE, PARALLEL

_Edge = tuple[MinkowskiSum, NDArray[np.int64]]
_Edges = tuple[_Edge, ...]  # at right angles to which a direction is held

ROUNDS = 6  # the last finds nothing better
CLOSER = 0.01  # [rad] about the direction that a round found, for the next one
STEPS = 20  # of Newton's method; 4 to 8 are usual
POLE = 0.99  # cosine of the angle within which the axis of a cylinder is tried
MOST_EXACT = 6  # candidates that get all digits; more are equal to these


def polished(pair: MinkowskiDifference, n: Floats, angle: float) -> tuple[Any, Floats]:
    """Return the exact maximum of f within about ``angle`` [rad] of n, and its direction."""
    best, best_n = mpf('-inf'), n
    for _ in range(ROUNDS):
        value, n = _best_near(pair, best_n, angle)
        if not value > best + GAIN * pair.size:
            break
        best, best_n, angle = value, n, min(angle, CLOSER)
    return best, best_n


def _best_near(pair: MinkowskiDifference, n: Floats, angle: float) -> tuple[Any, Floats]:
    tries = [(n, ()), *_candidates(pair, n, angle)]
    values = pair.values(np.array([m for m, _ in tries]))
    best = np.argsort(-values)[:MOST_EXACT]
    best = best[values[best] >= values.max() - EQUAL * pair.size]
    exact = [(pair.exact(_held(*tries[k])), tries[k][0]) for k in best]
    return max(exact, key=lambda each: each[0])


def _candidates(
    pair: MinkowskiDifference, n: Floats, angle: float
) -> Iterator[tuple[Floats, _Edges]]:
    """Yield maxima of smooth pieces and along circles, crossings of circles, and poles."""
    ahead = (pair.a, n), (pair.b, -n)
    edges = [[(x, edge) for edge in x.creases(d, angle)] for x, d in ahead]
    ends = [
        {int(i) for _, edge in side for i in edge} | {int(np.argmax(x.vertices @ (d @ x.R)))}
        for side, (x, d) in zip(edges, ahead, strict=True)
    ]
    for i, j in itertools.product(*ends):
        yield _maximum(pair, n, np.eye(3), i, j), ()
    near = [*edges[0], *edges[1]]
    along = [x.R @ (x.vertices[i] - x.vertices[j]) for x, (i, j) in near]
    for e, u in enumerate(along):
        across = np.linalg.svd(u[None])[2][1:]
        if np.linalg.norm(across @ n) < PARALLEL:
            continue
        corner = {int(near[e][1][0])}
        sides = (corner, ends[1]) if e < len(edges[0]) else (ends[0], corner)
        for i, j in itertools.product(*sides):
            yield _maximum(pair, n, across, i, j), (near[e],)
    for e, f in itertools.combinations(range(len(near)), 2):
        crossing = np.cross(along[e], along[f])
        length = np.linalg.norm(crossing)
        if length > PARALLEL * np.linalg.norm(along[e]) * np.linalg.norm(along[f]):
            sign = 1.0 if crossing @ n > 0 else -1.0
            yield sign / length * crossing, (near[e], near[f])
    for pole in np.vstack([pair.a.poles, -pair.b.poles]):
        if pole @ n > POLE:
            yield pole, ()


def _maximum(pair: MinkowskiDifference, n: Floats, E: Floats, i: int, j: int) -> Floats:
    """Return the maximum near n of the piece of f of vertices i of A and j of B.

    It is sought on the unit directions that the rows of E span. On these the balls are
    constant, and what is left, g(y) = d.y - |M_A y| - |M_B y|, is homogeneous.
    """
    a, b = pair.a, pair.b
    d = E @ (b.p + b.R @ b.vertices[j] - a.R @ a.vertices[i])
    flats = [x.flat @ x.R.T @ E.T for x in (a, b) if len(x.flat)]
    y = d if not flats and d.any() else E @ n
    y = y / np.linalg.norm(y)
    for _ in range(STEPS if flats else 0):
        slope, curve = d.copy(), np.zeros((len(y), len(y)))
        for M in flats:
            length = float(np.linalg.norm(M @ y)) or 1.0
            p = M.T @ (M @ y) / length
            slope -= p
            curve -= (M.T @ M - np.outer(p, p)) / length
        curve -= (slope @ y) * np.eye(len(y))
        slope -= (slope @ y) * y
        w, V = np.linalg.eigh(curve)
        step = (V / np.maximum(np.abs(w), LEAST_CURVATURE * pair.size)) @ (V.T @ slope)
        y, length = _ahead(d, flats, y, step / max(1.0, 4 * float(np.linalg.norm(step))))
        if length < LAST_STEP:
            break
    return y @ E


def _ahead(d: Floats, flats: list[Floats], y: Floats, step: Floats) -> tuple[Floats, float]:
    """Return where a step leads from y, and its length [rad]: halved for as long as g falls.

    Along a needle g is curved on a width of the order of the needle's own, and the whole step
    from beside it leads far beyond the maximum.
    """
    before = d @ y - sum(float(np.linalg.norm(M @ y)) for M in flats)
    while True:
        length, there = float(np.linalg.norm(step)), y + step
        there /= np.linalg.norm(there)
        g = d @ there - sum(float(np.linalg.norm(M @ there)) for M in flats)
        if g >= before or length < LAST_STEP:
            return there, length
        step = 0.5 * step


def _held(n: Floats, held: _Edges) -> list[Any]:
    """Return n in full digits, at right angles to the edges held."""
    edges = [body.exact_edge(edge) for body, edge in held]
    digits = vector(n)
    if len(edges) == 2:
        crossing = cross(*edges)
        return crossing if dot(crossing, digits) > 0 else [-x for x in crossing]
    for u in edges:
        digits = combine(digits, -dot(u, digits) / dot(u, u), u)
    return digits
