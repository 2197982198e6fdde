"""Three-vectors as tuples: small, allocation free, and the same compiled or not."""

import math

from drake_geom_ros.geometry._proximity.compiled import compiled


@compiled
def add(a, b):
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def sub(a, b):
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def scale(s, a):
    """Return s a for a scalar s."""
    return s * a[0], s * a[1], s * a[2]


@compiled
def add_scaled(a, s, b):
    """Return a + s b for a scalar s."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@compiled
def dot(a, b):
    """Return the inner product of a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a, b):
    """Return the vector product a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled
def norm(a):
    """Return |a|; scaled by the largest component, so that tiny and huge vectors do not vanish."""
    m = max(abs(a[0]), abs(a[1]), abs(a[2]))
    if m == 0.0:
        return 0.0
    x, y, z = a[0] / m, a[1] / m, a[2] / m
    return m * math.sqrt(x * x + y * y + z * z)


@compiled
def unit(a):
    """Return a / |a|, or the zero vector for the zero vector."""
    m = max(abs(a[0]), abs(a[1]), abs(a[2]))
    if m == 0.0:
        return 0.0, 0.0, 0.0
    x, y, z = a[0] / m, a[1] / m, a[2] / m
    n = math.sqrt(x * x + y * y + z * z)
    return x / n, y / n, z / n


@compiled
def perpendicular(a):
    """Return a unit vector at right angles to a: the axis least along a, made orthogonal."""
    x, y, z = abs(a[0]), abs(a[1]), abs(a[2])
    if x <= y and x <= z:
        return unit(cross(a, (1.0, 0.0, 0.0)))
    if y <= z:
        return unit(cross(a, (0.0, 1.0, 0.0)))
    return unit(cross(a, (0.0, 0.0, 1.0)))


@compiled
def rotate(R, v):
    """Return R v for R (3, 3)."""
    return (
        R[0, 0] * v[0] + R[0, 1] * v[1] + R[0, 2] * v[2],
        R[1, 0] * v[0] + R[1, 1] * v[1] + R[1, 2] * v[2],
        R[2, 0] * v[0] + R[2, 1] * v[1] + R[2, 2] * v[2],
    )


@compiled
def unrotate(R, v):
    """Return R^T v for R (3, 3)."""
    return (
        R[0, 0] * v[0] + R[1, 0] * v[1] + R[2, 0] * v[2],
        R[0, 1] * v[0] + R[1, 1] * v[1] + R[2, 1] * v[2],
        R[0, 2] * v[0] + R[1, 2] * v[1] + R[2, 2] * v[2],
    )


@compiled
def column(R, k):
    """Return column k of R: the k-th axis of the frame, in World."""
    return R[0, k], R[1, k], R[2, k]
