"""The signed distance of a point from a closed surface, in fractions: nothing is rounded."""

import math
from fractions import Fraction

import numpy as np
from mpmath import mp, mpf

DIGITS = 60
NEAR = 1e-6  # of what is about: floats tell farther triangles apart
# Along which rays are cast: through no edge of what has few digits.
RAYS = [(Fraction(1), Fraction(17, 10007), Fraction(-31, 20011))]
RAYS += [(Fraction(-3, 10009), Fraction(1), Fraction(7, 50021))]


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _sub(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def squared_distance(triangle, q):
    """The square of how far q is from a triangle."""
    normal = _cross(_sub(triangle[1], triangle[0]), _sub(triangle[2], triangle[0]))
    sides = [(triangle[k], _sub(triangle[(k + 1) % 3], triangle[k])) for k in range(3)]
    if _dot(normal, normal) > 0 and all(
        _dot(_cross(along, _sub(q, start)), normal) >= 0 for start, along in sides
    ):
        return _dot(_sub(q, triangle[0]), normal) ** 2 / _dot(normal, normal)
    found = []
    for start, along in sides:
        share = min(
            max(_dot(_sub(q, start), along) / _dot(along, along), Fraction(0)), Fraction(1)
        )
        gap = _sub(_sub(q, start), tuple(share * x for x in along))
        found.append(_dot(gap, gap))
    return min(found)


def is_inside(triangles, q):
    """Whether q, off the surface, is in it: a ray leaves once more often than it enters."""
    for ray in RAYS:
        crossings = [_crossing(triangle, q, ray) for triangle in triangles]
        if None not in crossings:
            return sum(crossings) != 0
    raise AssertionError(f'every ray from {q} goes through an edge')


def _crossing(triangle, q, ray):
    """1 where the ray leaves by a triangle, -1 where it enters, 0 elsewhere; None: an edge."""
    a, b, c = (_sub(corner, q) for corner in triangle)
    volumes = [_dot(ray, _cross(*pair)) for pair in ((a, b), (b, c), (c, a))]
    if min(volumes) < 0 < max(volumes):
        return 0
    if 0 in volumes:
        return None if any(volumes) else 0
    normal = _cross(_sub(b, a), _sub(c, a))
    return 0 if _dot(normal, a) * _dot(normal, ray) < 0 else (1 if volumes[0] > 0 else -1)


def fractions(rows):
    """Rows of numbers as fractions."""
    return [tuple(Fraction(float(x)) for x in row) for row in rows]


def signed_distance(corners, q):
    """The signed distance of q from triangles (n, 3, 3), in DIGITS digits."""
    rough = [math.sqrt(squared_distance(rows, tuple(map(float, q)))) for rows in corners.tolist()]
    limit = min(rough) + NEAR * float(np.abs(corners - q).max())
    triangles, q = [fractions(corner) for corner in corners], fractions([q])[0]
    near = [triangle for triangle, gap in zip(triangles, rough, strict=True) if gap <= limit]
    squared = min(squared_distance(triangle, q) for triangle in near)
    with mp.workdps(DIGITS):
        distance = mp.sqrt(mpf(squared.numerator) / mpf(squared.denominator))
        return -distance if squared and is_inside(triangles, q) else distance
