"""Truth for signed distances: the support-function maximum, in plain NumPy and SciPy.

``phi(A, B) = max over unit n of f(n) = -h_A(n) - h_B(-n)``. A support function is a sum of pieces
that are smooth except on known great circles (n at right angles to an edge of a polytope, to the
axis of a cylinder or capsule) and at known points (face normals, axes, cross products of edges).
So the maximum is the best of: all those points, the maxima along all those circles, and the maxima
of the smooth pieces, each started from dense directions. Nothing here is shared with the kernels.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import ConvexHull

SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID, HALF_SPACE, CONVEX = 1, 2, 3, 4, 5, 6, 7
DENSE = 20_000
STARTS = 14


@dataclass
class _Body:
    """A shape at a pose: all that the search needs to know of it, in World axes."""

    kind: int
    size: np.ndarray
    R: np.ndarray
    p: np.ndarray
    edges: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    normals: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    vertices: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))

    def support(self, n: np.ndarray) -> np.ndarray:
        """The points (m, 3) of the body that are extreme along the unit directions n (m, 3)."""
        d = n @ self.R
        s = self.size
        if self.kind == SPHERE:
            x = s[0] * d
        elif self.kind == BOX:
            x = s * np.sign(d)
        elif self.kind == CAPSULE:
            x = s[0] * d
            x[:, 2] += s[1] * np.sign(d[:, 2])
        elif self.kind == CYLINDER:
            rho = np.hypot(d[:, 0], d[:, 1])
            rho[rho == 0] = 1.0
            x = np.column_stack([s[0] * d[:, :2] / rho[:, None], s[1] * np.sign(d[:, 2])])
        elif self.kind == ELLIPSOID:
            x = s**2 * d / np.linalg.norm(s * d, axis=1)[:, None]
        else:
            x = self.vertices[np.argmax(d @ self.vertices.T, axis=1)]
        return self.p + x @ self.R.T

    def radius(self) -> float:
        if self.kind == CONVEX:
            return float(np.linalg.norm(self.vertices, axis=1).max())
        return float(np.sum(self.size))


def _body(shape, X):
    kind, parameters = shape
    R, p = X
    parameters = np.asarray(parameters, dtype=float)
    body = _Body(kind, parameters, np.asarray(R, dtype=float), np.asarray(p, dtype=float))
    axes = body.R.T
    if kind == BOX:
        body.edges = axes.copy()
        body.normals = np.vstack([axes, -axes])
    elif kind == CAPSULE:
        body.edges = axes[2:].copy()
    elif kind == CYLINDER:
        body.edges = axes[2:].copy()
        body.normals = np.vstack([axes[2:], -axes[2:]])
    elif kind == ELLIPSOID:
        body.normals = np.vstack([axes, -axes])
    elif kind == CONVEX:
        body.vertices = parameters[1:].reshape(-1, 3)
        hull = ConvexHull(body.vertices)
        pairs = {tuple(sorted((t[i], t[i - 1]))) for t in hull.simplices for i in range(3)}
        edges = np.array([body.vertices[i] - body.vertices[j] for i, j in sorted(pairs)])
        body.edges = edges / np.linalg.norm(edges, axis=1)[:, None] @ axes
        body.normals = hull.equations[:, :3] @ axes
    return body


def _fibonacci(count: int) -> np.ndarray:
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    angle = np.pi * (1 + 5**0.5) * k
    rho = np.sqrt(1 - z * z)
    return np.column_stack([rho * np.cos(angle), rho * np.sin(angle), z])


def _unit(v: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(v, axis=1)
    keep = length > 1e-9
    return v[keep] / length[keep, None]


def _width(a: _Body, b: _Body, n: np.ndarray) -> np.ndarray:
    """f(n) of unit directions n (m, 3)."""
    return np.einsum('ij,ij->i', b.support(-n) - a.support(n), n)


def _along_circles(a: _Body, b: _Body, edges: np.ndarray) -> list[tuple[float, np.ndarray]]:
    """The best direction on each great circle at right angles to an edge."""
    found = []
    for u in edges:
        e1 = np.cross(u, np.eye(3)[np.argmin(np.abs(u))])
        e1 /= np.linalg.norm(e1)
        e2 = np.cross(u, e1)
        angles = np.linspace(0, 2 * np.pi, 720, endpoint=False)
        values = _width(a, b, np.outer(np.cos(angles), e1) + np.outer(np.sin(angles), e2))
        peaks = np.flatnonzero((values >= np.roll(values, 1)) & (values >= np.roll(values, -1)))
        peaks = peaks[np.argsort(-values[peaks])][:6]
        centres, step = angles[peaks], angles[1]
        while step > 1e-14:
            fan = centres[:, None] + step * np.linspace(-1, 1, 33)
            flat = fan.ravel()
            n = np.outer(np.cos(flat), e1) + np.outer(np.sin(flat), e2)
            values = _width(a, b, n).reshape(fan.shape)
            best = np.argmax(values, axis=1)
            centres = fan[np.arange(len(fan)), best]
            step /= 8
        k = np.argmax(values.max(axis=1))
        n = np.cos(centres[k]) * e1 + np.sin(centres[k]) * e2
        found.append((float(values[k].max()), n))
    return found


def _uphill(a: _Body, b: _Body, n: np.ndarray, rounds: int = 1) -> tuple[float, np.ndarray]:
    """The maximum of f on the smooth piece around n, by BFGS in the tangent plane."""
    for _ in range(rounds):
        e1 = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
        e1 /= np.linalg.norm(e1)
        basis = np.vstack([e1, np.cross(n, e1)])

        def minus(t, n=n, basis=basis):
            m = n + t @ basis
            length = np.linalg.norm(m)
            u = (m / length)[None]
            gap = (b.support(-u) - a.support(u))[0]
            value = gap @ u[0]
            return -value, -(basis @ (gap - value * u[0])) / length

        # A value is exact to the square of its slope; at a kink the search would go on for ever.
        options = {'gtol': 1e-9, 'maxiter': 25}
        t = minimize(minus, np.zeros(2), jac=True, method='BFGS', options=options).x
        n = n + t @ basis
        n /= np.linalg.norm(n)
    return float(_width(a, b, n[None])[0]), n


def _starts(values: np.ndarray, n: np.ndarray) -> np.ndarray:
    """The best directions that are not neighbours of a better one."""
    chosen: list[np.ndarray] = []
    for k in np.argsort(-values)[:4000]:
        if all(n[k] @ c < 0.995 for c in chosen):
            chosen.append(n[k])
            if len(chosen) == STARTS:
                break
    return np.array(chosen)


def _half_space(shape_a, X_a, shape_b, X_b):
    """A half space has one finite direction: its own normal."""
    if shape_a[0] == HALF_SPACE:
        n = np.asarray(X_a[0], dtype=float)[:, 2]
        b = _body(shape_b, X_b)
        return float((b.support(-n[None])[0] - X_a[1]) @ n), n
    phi, n = _half_space(shape_b, X_b, shape_a, X_a)
    return phi, -n


def signed_distance(shape_a, X_WA, shape_b, X_WB):
    """Return (phi [m], n): the signed distance and a unit direction out of A that attains it.

    A shape is ``(type_number, parameters)`` with the parameters of the kernels, a pose ``(R, p)``.
    Good to about 1e-12 of the size of the pair. At most one of the two may be a half space.
    """
    if HALF_SPACE in (shape_a[0], shape_b[0]):
        return _half_space(shape_a, X_WA, shape_b, X_WB)
    offset = np.asarray(X_WB[1], dtype=float) - np.asarray(X_WA[1], dtype=float)
    a, b = _body(shape_a, (X_WA[0], np.zeros(3))), _body(shape_b, (X_WB[0], offset))
    scale = a.radius() + b.radius() + float(np.linalg.norm(offset))
    a, b = (_scaled(x, scale) for x in (a, b))
    dense = [_fibonacci(DENSE)]
    for body in (a, b):  # as many normals for a thin body's edge as for its flat side
        if body.kind == ELLIPSOID:
            dense.append(_unit(_fibonacci(4000) / body.size * body.size.min()) @ body.R.T)
    smooth = np.vstack([*dense, _unit(b.p[None])])
    crosses = np.array([np.cross(u, v) for u in a.edges for v in b.edges]).reshape(-1, 3)
    corners = np.vstack([a.normals, b.normals, _unit(crosses), _unit(-crosses)])
    values = _width(a, b, smooth)
    found = [(float(values.max()), smooth[np.argmax(values)])]
    found += [(float(v), n) for v, n in zip(_width(a, b, corners), corners, strict=True)]
    found += _along_circles(a, b, np.vstack([a.edges, b.edges]))
    found += [_uphill(a, b, n) for n in _starts(values, smooth)]
    phi, n = max(found, key=lambda item: item[0])
    found.append(_uphill(a, b, n, rounds=3))
    phi, n = max(found, key=lambda item: item[0])
    return phi * scale, n


def _scaled(body: _Body, scale: float) -> _Body:
    size = body.size / scale if body.kind != CONVEX else body.size
    return _Body(
        body.kind, size, body.R, body.p / scale, body.edges, body.normals, body.vertices / scale
    )


def support_point(shape, X_WG, n):
    """Return the point (3,) of a body at its pose that is extreme along the unit direction n."""
    return _body(shape, X_WG).support(np.asarray(n, dtype=float)[None])[0]
