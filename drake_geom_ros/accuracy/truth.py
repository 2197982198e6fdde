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

import itertools
from typing import Any

import numpy as np
from mpmath import mp, mpf
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from drake_geom_ros.accuracy.supports import DIGITS, HALF_SPACE, Body, Pose, Shape, posed

Floats = NDArray[np.float64]

DENSE = 400  # directions that a search begins with
GAP = 1e-4  # relative to the pair's size: how much better a direction the search may overlook
NEARBY = 0.03  # [rad] about a direction found that polishing looks for edges
ROUNDS = 40  # of a search, each of which takes a new hull
MOST_OPEN = 150  # faces of the hull that one round refines
STEPS = 40  # of Newton's method; 4 to 8 are usual
EQUAL = 1e-11  # relative to the pair's size: candidates this near to the best get all digits


def signed_distance(
    shape_a: Shape, X_WA: Pose, shape_b: Shape, X_WB: Pose
) -> tuple[float, Floats]:
    """Return phi [m] and a unit direction (3,) out of A that attains it.

    A shape is ``(type number, half sizes)``; of a hull, the number of vertices and the vertices.
    A pose is ``(R, p)``. Good to the rounding of the answer and of R. At most one of the two may
    be a half space.
    """
    with mp.workdps(DIGITS):
        if HALF_SPACE in (shape_a[0], shape_b[0]):
            return _half_space(shape_a, X_WA, shape_b, X_WB)
        pair = _Pair(posed(shape_a, *X_WA), posed(shape_b, *X_WB))
        found = [pair.polished(n, NEARBY) for n in pair.search()]
        phi, n = max(found, key=lambda each: each[0])
        return float(phi), n


def near_direction(
    shape_a: Shape, X_WA: Pose, shape_b: Shape, X_WB: Pose, n: Floats
) -> tuple[float, Floats]:
    """Return what ``signed_distance`` does, where n is known to be next to the best direction."""
    with mp.workdps(DIGITS):
        if HALF_SPACE in (shape_a[0], shape_b[0]):
            return _half_space(shape_a, X_WA, shape_b, X_WB)
        pair = _Pair(posed(shape_a, *X_WA), posed(shape_b, *X_WB))
        phi, n = pair.polished(n, 1e-6)
        return float(phi), n


def _half_space(shape_a: Shape, X_a: Pose, shape_b: Shape, X_b: Pose) -> tuple[float, Floats]:
    """A half space has one direction in which it ends: its normal."""
    if shape_a[0] != HALF_SPACE:
        phi, n = _half_space(shape_b, X_b, shape_a, X_a)
        return phi, -n
    n = np.asarray(X_a[0], dtype=float)[:, 2]
    exact = [mpf(float(x)) for x in n]
    offset = _offset(X_a[1], X_b[1])
    height = sum((x * y for x, y in zip(offset, exact, strict=True)), mpf(0))
    below = posed(shape_b, *X_b).exact_height([-x for x in exact])
    return float(height - below), n


def _offset(p_WA: Any, p_WB: Any) -> list[Any]:
    """Return p_AB in full digits."""
    return [mpf(float(b)) - mpf(float(a)) for a, b in zip(p_WA, p_WB, strict=True)]


class _Pair:
    """Two bounded bodies, and f."""

    def __init__(self, a: Body, b: Body) -> None:
        self.offset = _offset(a.p, b.p)
        zero = np.zeros(3)
        p_AB = np.array([float(x) for x in self.offset])
        self.a = Body(a.vertices, a.edges, a.radius, a.flat, a.R, zero, a.poles)
        self.b = Body(b.vertices, b.edges, b.radius, b.flat, b.R, p_AB, b.poles)
        self.size = a.size + b.size + float(np.linalg.norm(p_AB))

    def gaps(self, n: Floats) -> Floats:
        """Return the points (m, 3) of B - A that are lowest along the unit directions n (m, 3)."""
        return self.b.points(-n) - self.a.points(n)

    def values(self, n: Floats) -> Floats:
        """Return f of unit directions (m, 3)."""
        return np.einsum('ij,ij->i', self.gaps(n), n)

    def exact(self, n: list[Any]) -> Any:
        """Return f of a direction of any length, in full digits."""
        ahead = sum((x * y for x, y in zip(self.offset, n, strict=True)), mpf(0))
        value = ahead - self.a.exact_height(n) - self.b.exact_height([-x for x in n])
        return value / mp.sqrt(sum((x * x for x in n), mpf(0)))

    # Search.

    def search(self) -> Floats:
        """Return directions (m, 3), one of them next to the best of all."""
        n = np.vstack([_sphere(DENSE), *(_unit(x.flat @ x.R.T) for x in (self.a, self.b))])
        points = self.gaps(n)
        values = np.einsum('ij,ij->i', points, n)
        found, best = [n[np.argmax(values)][None]], values.max()
        gap = GAP * self.size
        for _ in range(ROUNDS):
            try:
                planes = np.unique(ConvexHull(points).equations, axis=0)
            except QhullError:  # flat: two bodies that are points or segments
                break
            # The plane's distance from the origin is at least f there, and f of what lies on it.
            normals, ahead = -planes[:, :3], planes[:, 3]
            open_ = np.flatnonzero(ahead > best + gap)
            if not len(open_):
                break
            open_ = open_[np.argsort(-ahead[open_])][:MOST_OPEN]
            new = self.gaps(normals[open_])
            values = np.einsum('ij,ij->i', new, normals[open_])
            best = max(best, values.max())
            found.append(normals[open_])
            points = np.vstack([points, new])
        candidates = np.vstack(found)
        values = self.values(candidates)
        top = candidates[np.argsort(-values)][:1]
        close = _apart(candidates[values >= best - 2 * gap], NEARBY)
        return np.vstack([self._climb(top[0])[None], close])

    def _climb(self, n: Floats) -> Floats:
        """Return the best direction that caps around n find as they shrink."""
        angle = 4 / DENSE**0.5
        while angle > 0.2 * NEARBY:
            around = _unit(n + angle * _sphere(120))
            around = np.vstack([n[None], around])
            best = around[np.argmax(self.values(around))]
            # A better one at the rim: go on from there before looking closer.
            if best @ n > np.cos(0.5 * angle):
                angle *= 0.5
            n = best
        return n

    # Polish.

    def polished(self, n: Floats, angle: float) -> tuple[Any, Floats]:
        """Return the exact f and the direction of the maximum near n."""
        best, best_n = mpf('-inf'), n
        for _ in range(6):
            value, n = self._best_near(best_n, angle)
            if not value > best + mpf(10) ** -17 * self.size:
                break
            best, best_n, angle = value, n, min(angle, 0.01)
        return best, best_n

    def _best_near(self, n: Floats, angle: float) -> tuple[Any, Floats]:
        """Return the best of smooth pieces, circles and crossings near n."""
        bodies = (self.a, n), (self.b, -n)
        edges = [(body, edge) for body, d in bodies for edge in body.creases(d, angle)]
        along = _unit(
            np.array(
                [(x.vertices[i] - x.vertices[j]) @ x.R.T for x, (i, j) in edges]
            ).reshape(-1, 3)
        )
        tries: list[tuple[Floats, tuple[int, ...]]] = [(n, ()), (self._newton(n, np.eye(3)), ())]
        for k, u in enumerate(along):
            across = np.linalg.svd(u[None])[2][1:]
            start = _unit((across.T @ (across @ n))[None])
            if len(start):
                tries.append((self._newton(start[0], across), (k,)))
        for i, j in itertools.combinations(range(len(along)), 2):
            crossing = np.cross(along[i], along[j])
            if np.linalg.norm(crossing) > 1e-9:
                crossing /= np.linalg.norm(crossing)
                tries.append((crossing if crossing @ n > 0 else -crossing, (i, j)))
        poles = np.vstack([self.a.poles, self.b.poles])
        tries += [(pole, ()) for pole in poles if abs(pole @ n) > 0.99]
        values = self.values(np.array([m for m, _ in tries]))
        exact = []
        for k in np.flatnonzero(values >= values.max() - EQUAL * self.size)[:12]:
            m, held = tries[k]
            digits = _held([float(x) for x in m], [edges[e] for e in held])
            exact.append((self.exact(digits), m))
        return max(exact, key=lambda each: each[0])

    def _newton(self, n: Floats, E: Floats) -> Floats:
        """Return the maximum near n of f on the unit directions that the rows of E span."""
        y = E @ n
        value = self.values((y @ E)[None])[0]
        flats = [x.flat @ x.R.T @ E.T for x in (self.a, self.b) if len(x.flat)]
        for _ in range(STEPS):
            n = y @ E
            slope = E @ self.gaps(n[None])[0]
            curve = np.zeros((len(y), len(y)))
            for M in flats:
                length = np.linalg.norm(M @ y)
                if length > 0:
                    p = M.T @ (M @ y) / length
                    curve -= (M.T @ M - np.outer(p, p)) / length
            # On the sphere the balls are constant, and what is left is homogeneous.
            curve -= (value + self.a.radius + self.b.radius) * np.eye(len(y))
            T = np.linalg.svd(y[None])[2][1:]
            w, V = np.linalg.eigh(T @ curve @ T.T)
            step = (V / np.maximum(np.abs(w), 1e-9 * self.size)) @ V.T @ (T @ slope)
            step /= max(1.0, 4 * np.linalg.norm(step))
            if np.linalg.norm(step) < 1e-15:
                break
            for half in range(30):
                trial = y + 0.5**half * step @ T
                trial /= np.linalg.norm(trial)
                better = self.values((trial @ E)[None])[0]
                if better > value:
                    break
            else:
                break
            y, value = trial, better
        return y @ E


def _held(n: list[float], held: list[tuple[Body, Any]]) -> list[Any]:
    """Return n in full digits, at right angles to the edges held."""
    edges = [body.exact_edge(edge) for body, edge in held]
    digits = [mpf(x) for x in n]
    if len(edges) == 2:
        (a, b, c), (d, e, f) = edges
        cross = [b * f - c * e, c * d - a * f, a * e - b * d]
        same = sum((x * y for x, y in zip(cross, digits, strict=True)), mpf(0)) > 0
        return cross if same else [-x for x in cross]
    for u in edges:
        uu, un = (sum((x * y for x, y in zip(u, v, strict=True)), mpf(0)) for v in (u, digits))
        digits = [x - un / uu * y for x, y in zip(digits, u, strict=True)]
    return digits


def _sphere(count: int) -> Floats:
    """Return unit directions (count, 3) that lie evenly: a Fibonacci spiral."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    rho = np.sqrt(1 - z * z)
    return np.column_stack([rho * np.cos(turn), rho * np.sin(turn), z])


def _unit(v: Floats) -> Floats:
    """Return vectors (m, 3) at unit length, without those that have none."""
    length = np.linalg.norm(v, axis=1)
    return v[length > 1e-12] / length[length > 1e-12, None]


def _apart(n: Floats, angle: float) -> Floats:
    """Return directions of which each has one of the result within an angle [rad]."""
    kept: list[Floats] = []
    for each in n:
        if all(each @ k < np.cos(0.5 * angle) for k in kept):
            kept.append(each)
    return np.array(kept)
