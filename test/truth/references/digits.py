"""Vectors of numbers with many digits, or of fractions."""

from mpmath import mp, mpf


def vector(values):
    """Return the exact values of floats, or of numbers with more digits."""
    return [v if isinstance(v, mpf) else mpf(float(v)) for v in values]


def dot(a, b):
    """Return a . b."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def norm(a):
    """Return |a|."""
    return mp.sqrt(dot(a, a))


def combine(a, s, b):
    """Return the sum of a and s b."""
    return [x + s * y for x, y in zip(a, b, strict=True)]


def cross(a, b):
    """Return a x b."""
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def columns(R):
    """Return the columns of a matrix."""
    return [vector(R[:, k]) for k in range(3)]
