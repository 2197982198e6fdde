"""Truth for the closed forms: signed distances with 50 digits, written to be short, not fast.

Nothing is shared with the kernels, and the ways differ: boxes and segments are lists of vertices
and edges; the ellipsoid is the textbook equation, bisected.
"""

import itertools

from mpmath import mp, mpf

from drake_geom_ros.geometry import ShapeKind
from truth.references.digits import columns, combine, cross, dot, norm, vector

SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID, HALF_SPACE, *_ = ShapeKind
DIGITS = 50


def _ellipsoid_distance(e, q):
    """Return the signed distance from an ellipsoid.

    It is by the largest root v > 0 of sum (e q / (v + f))^2 = 1, f = e^2 - min(e)^2, of which the
    nearest point is e^2 q / (v + f), inside and outside.
    """
    # A coordinate below 1e-60 would need more digits to be told from 0 than it could matter.
    e, q = vector(e), [abs(x) if abs(x) > mpf(10) ** -60 else mpf(0) for x in q]
    least = min(e)
    f = [x**2 - least**2 for x in e]
    used = [k for k in range(3) if q[k] > 0]

    def total(v, power=2):
        return sum(((e[k] * q[k]) ** 2 / (v + f[k]) ** power for k in used), mpf(0))

    shortest = [k for k in range(3) if f[k] == 0]
    if all(q[k] == 0 for k in shortest) and total(mpf(0)) <= 1:
        x = [e[k] ** 2 * q[k] / f[k] if f[k] > 0 else mpf(0) for k in range(3)]
        x[shortest[0]] = least * mp.sqrt(1 - total(mpf(0)))
        return -norm(combine(x, -1, q))
    high = norm([a * b for a, b in zip(e, q, strict=True)])
    low = high * mpf(10) ** -70
    for _ in range(60):
        middle = mp.sqrt(low * high) if high > 2 * low else (low + high) / 2
        low, high = (middle, high) if total(middle) > 1 else (low, middle)
    for _ in range(2):
        low += (total(low) - 1) / (2 * total(low, 3))
    x = [e[k] ** 2 * q[k] / (low + f[k]) if k in used else mpf(0) for k in range(3)]
    return norm(combine(x, -1, q)) * (1 if low > least**2 else -1)


def _rectangle(beyond):
    """Return the signed distance to a corner, given how far each of its sides is exceeded."""
    outside = norm([max(x, mpf(0)) for x in beyond])
    return outside if outside > 0 else max(beyond)


def point_distance(kind, size, q):
    """Return the signed distance of the point q (in the shape's frame) from a shape."""
    with mp.workdps(DIGITS):
        s, q = vector(size), [mpf(x) for x in q]
        if kind == SPHERE:
            return norm(q) - s[0]
        if kind == BOX:
            return _rectangle([abs(x) - h for x, h in zip(q, s, strict=True)])
        if kind == CAPSULE:
            return norm([q[0], q[1], max(abs(q[2]) - s[1], mpf(0))]) - s[0]
        if kind == CYLINDER:
            return _rectangle([norm(q[:2]) - s[0], abs(q[2]) - s[1]])
        if kind == ELLIPSOID:
            return _ellipsoid_distance(size, q)
        return q[2]


class Polytope:
    """A box (or a segment: a capsule's core) as vertices, edges and face normals, in World."""

    def __init__(self, kind, size, R, p):
        axes, p = columns(R), [mpf(x) for x in p]
        half = [mpf(0), mpf(0), mpf(float(size[1]))] if kind == CAPSULE else vector(size)
        self.axes, self.half, self.centre = axes, half, p
        self.radius = mpf(float(size[0])) if kind == CAPSULE else mpf(0)
        used = [k for k in range(3) if kind == BOX or k == 2]
        self.directions = [axes[k] for k in used]
        self.normals = axes if kind == BOX else []
        self.vertices, self.edges = [], []
        for signs in itertools.product((-1, 1), repeat=len(used)):
            v = p
            for k, sign in zip(used, signs, strict=True):
                v = combine(v, sign * half[k], axes[k])
            self.vertices.append(v)
        for k in used:
            others = [m for m in used if m != k]
            for signs in itertools.product((-1, 1), repeat=len(others)):
                v = p
                for m, sign in zip(others, signs, strict=True):
                    v = combine(v, sign * half[m], axes[m])
                self.edges.append((v, axes[k], half[k]))

    def distance_to_point(self, q):
        """Return the distance of a point from the solid; 0 inside."""
        r = combine(q, -1, self.centre)
        beyond = [abs(dot(r, a)) - h for a, h in zip(self.axes, self.half, strict=True)]
        return norm([max(x, mpf(0)) for x in beyond])


def _line_gap(edge, other):
    """Return the distance of two edges if their common perpendicular meets both, else None."""
    (p, u, hu), (q, v, hv) = edge, other
    n = cross(u, v)
    nn = dot(n, n)
    if nn < mpf(10) ** -40:
        return None
    r = combine(q, -1, p)
    s, t = dot(cross(r, v), n) / nn, dot(cross(r, u), n) / nn
    return abs(dot(r, n)) / mp.sqrt(nn) if abs(s) <= hu and abs(t) <= hv else None


def _polytope_distance(a, b):
    """Return the signed distance of polytopes: features where apart, all axes in overlap."""
    normals = a.normals + b.normals
    for u, v in itertools.product(a.directions, b.directions):
        n = cross(u, v)
        if dot(n, n) > mpf(10) ** -40:
            normals.append([x / norm(n) for x in n])
    separations = [mpf('-inf')]
    for n in normals:
        low_a, *_, high_a = sorted(dot(n, v) for v in a.vertices)
        low_b, *_, high_b = sorted(dot(n, v) for v in b.vertices)
        separations.append(max(low_b - high_a, low_a - high_b))
    if (a.normals or b.normals) and max(separations) <= 0:
        return max(separations)
    best = min(
        [b.distance_to_point(v) for v in a.vertices] + [a.distance_to_point(v) for v in b.vertices]
    )
    for edge, other in itertools.product(a.edges, b.edges):
        r = combine(edge[0], -1, other[0])
        if norm(r) - edge[2] - other[2] < best:
            gap = _line_gap(edge, other)
            best = best if gap is None else min(best, gap)
    return best


def _lowest(kind, size, R, n):
    """Return the height along n of a shape's lowest point, from its origin."""
    axes, s = columns(R), vector(size)
    if kind == BOX:
        return -sum(h * abs(dot(n, a)) for h, a in zip(s, axes, strict=True))
    if kind == CAPSULE:
        return -s[1] * abs(dot(n, axes[2])) - s[0]
    if kind == CYLINDER:
        return -s[1] * abs(dot(n, axes[2])) - s[0] * norm(cross(n, axes[2]))
    return -norm([e * dot(n, a) for e, a in zip(s, axes, strict=True)])


def signed_distance(kind_A, size_A, R_WA, kind_B, size_B, R_WB, p_AB_W):
    """Return the signed distance (mpf) of a pair with a closed form, the lower kind as A."""
    with mp.workdps(DIGITS):
        p = vector(p_AB_W)
        if kind_A == SPHERE:
            q = [-dot(p, a) for a in columns(R_WB)]
            return point_distance(kind_B, size_B, q) - mpf(float(size_A[0]))
        if kind_B == HALF_SPACE:
            n = columns(R_WB)[2]
            return _lowest(kind_A, size_A, R_WA, n) - dot(p, n)
        a = Polytope(kind_A, size_A, R_WA, [0, 0, 0])
        b = Polytope(kind_B, size_B, R_WB, p)
        return _polytope_distance(a, b) - a.radius - b.radius
