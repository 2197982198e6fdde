"""What a ray meets first, in 50 digits: each surface's equation solved, then cut to the body."""

import mpmath as mp

from drake_geom_ros.geometry import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Sphere

mp.mp.dps = 50


def vector(values):
    return [mp.mpf(float(v)) for v in values]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def roots(a, b, c):
    """Return the real roots of a t^2 + 2 b t + c."""
    if a == 0:
        return []
    inside = b * b - a * c
    return [] if inside < 0 else [(-b - mp.sqrt(inside)) / a, (-b + mp.sqrt(inside)) / a]


def cross(a, b):
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def into_body(X_WG, o, d):
    """Return a ray in the frame of a posed body.

    The matrix is a rotation to rounding only: its inverse is taken, not its transpose.
    """
    x, y, z = (vector(column) for column in X_WG.rotation().matrix().T)
    duals = cross(y, z), cross(z, x), cross(x, y)
    volume = dot(x, duals[0])
    relative = [a - b for a, b in zip(o, vector(X_WG.translation()), strict=True)]
    return tuple([dot(dual, v) / volume for dual in duals] for v in (relative, d))


def sphere_roots(o, d, centre_z, r):
    shifted = [o[0], o[1], o[2] - centre_z]
    return roots(dot(d, d), dot(shifted, d), dot(shifted, shifted) - r * r)


def tube_roots(o, d, r):
    return roots(d[0] ** 2 + d[1] ** 2, o[0] * d[0] + o[1] * d[1], o[0] ** 2 + o[1] ** 2 - r * r)


def crossings(shape, o, d):
    """Return every t at which a ray crosses the surface of a shape, in its frame."""

    def at(t, i):
        return o[i] + t * d[i]

    if isinstance(shape, Sphere):
        return sphere_roots(o, d, 0, mp.mpf(shape.radius()))
    if isinstance(shape, HalfSpace):
        return [-o[2] / d[2]] if d[2] != 0 else []
    if isinstance(shape, Ellipsoid):
        axes = vector((shape.a(), shape.b(), shape.c()))
        unit_o, unit_d = ([v / a for v, a in zip(w, axes, strict=True)] for w in (o, d))
        return sphere_roots(unit_o, unit_d, 0, mp.mpf(1))
    if isinstance(shape, Box):
        half = [h / 2 for h in vector(shape.size())]
        found = []
        for i in range(3):
            others = [j for j in range(3) if j != i]
            for side in (-half[i], half[i]) if d[i] != 0 else ():
                t = (side - o[i]) / d[i]
                if all(abs(at(t, j)) <= half[j] for j in others):
                    found.append(t)
        return found
    r, half = mp.mpf(shape.radius()), mp.mpf(shape.length()) / 2
    found = [t for t in tube_roots(o, d, r) if abs(at(t, 2)) <= half]
    if isinstance(shape, Cylinder):
        ends = [(side - o[2]) / d[2] for side in (-half, half)] if d[2] != 0 else []
        return found + [t for t in ends if at(t, 0) ** 2 + at(t, 1) ** 2 <= r * r]
    assert isinstance(shape, Capsule)
    for side in (-1, 1):
        caps = sphere_roots(o, d, side * half, r)
        found += [t for t in caps if side * at(t, 2) >= half]
    return found


def triangle_crossings(p_Vs, triangles, o, d):
    """Return every t at which a ray crosses triangles, by Cramer's rule."""
    points = [vector(p) for p in p_Vs]
    found = []
    for a, b, c in ([points[i] for i in face] for face in triangles):
        e, f, rest = ([x - y for x, y in zip(v, a, strict=True)] for v in (b, c, o))
        across = cross(d, f)
        if (whole := dot(e, across)) == 0:
            continue
        turned = cross(rest, e)
        u, v = dot(rest, across) / whole, dot(d, turned) / whole
        if u >= 0 and v >= 0 and u + v <= 1:
            found.append(dot(f, turned) / whole)
    return found


def first_met(bodies, X_WC, slope, near, far=mp.inf):
    """Return (depth, index of the body) of what a ray of slopes (x, y) meets first.

    ``bodies`` are (shape or (vertices, triangles), X_WG); depth is infinite, and the index None,
    where nothing is met.
    """
    o = vector(X_WC.translation())
    R = X_WC.rotation().matrix()
    ahead = [mp.mpf(slope[0]), mp.mpf(slope[1]), mp.mpf(1)]
    d = [dot(vector(row), ahead) for row in R]
    best = mp.inf, None
    for index, (shape, X_WG) in enumerate(bodies):
        ray = into_body(X_WG, o, d)
        meet = triangle_crossings if isinstance(shape, tuple) else crossings
        given = shape if isinstance(shape, tuple) else (shape,)
        for t in meet(*given, *ray):
            if near <= t <= far and t < best[0]:
                best = t, index
    return best
