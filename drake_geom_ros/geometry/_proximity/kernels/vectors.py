"""Three-vectors as tuples: allocation free, and equal whether compiled or not."""

import math

from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import LARGE_SQUARE, SMALL_SQUARE


@inlined
def vector_at(numbers: Floats, k: int) -> Vector:
    """Return three numbers of an array (n,) from place k on."""
    return numbers[k], numbers[k + 1], numbers[k + 2]


@inlined
def vector_in(rows: Floats, k: int, column: int = 0) -> Vector:
    """Return three numbers of row k of an array (n, m) from a column on."""
    # Unsigned indices: the test for negative ones would take as long as the rest.
    k, column = unsigned(k), unsigned(column)
    return rows[k, column], rows[k, column + unsigned(1)], rows[k, column + unsigned(2)]


@inlined
def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def sub(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def scale(s: float, a: Vector) -> Vector:
    """Return s a for a scalar s."""
    return s * a[0], s * a[1], s * a[2]


@inlined
def add_scaled(a: Vector, s: float, b: Vector) -> Vector:
    """Return a + s b for a scalar s."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@inlined
def dot(a: Vector, b: Vector) -> float:
    """Return the inner product of a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled
def _scaled(a: Vector) -> tuple[float, Vector]:
    """Return m and a / m for the largest component m; (0, 0) for the zero vector."""
    m = max(abs(a[0]), abs(a[1]), abs(a[2]))
    if m == 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    return m, (a[0] / m, a[1] / m, a[2] / m)


@inlined
def norm(a: Vector) -> float:
    """Return |a|; tiny and huge vectors, whose squares vanish or overflow, are scaled first."""
    squared = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    if SMALL_SQUARE < squared < LARGE_SQUARE:
        return math.sqrt(squared)
    m, (x, y, z) = _scaled(a)
    return m * math.sqrt(x * x + y * y + z * z)


@inlined
def unit(a: Vector) -> Vector:
    """Return a / |a|, or the zero vector for the zero vector."""
    squared = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    x, y, z = a
    if not SMALL_SQUARE < squared < LARGE_SQUARE:
        m, (x, y, z) = _scaled(a)
        if m == 0.0:
            return 0.0, 0.0, 0.0
        squared = x * x + y * y + z * z
    n = math.sqrt(squared)
    return x / n, y / n, z / n


@inlined
def perpendicular(a: Vector) -> Vector:
    """Return the unit vector along a x e, for the first axis e with the least component of a."""
    x, y, z = abs(a[0]), abs(a[1]), abs(a[2])
    if x <= y and x <= z:
        return unit(cross(a, (1.0, 0.0, 0.0)))
    if y <= z:
        return unit(cross(a, (0.0, 1.0, 0.0)))
    return unit(cross(a, (0.0, 0.0, 1.0)))


@inlined
def rotate(R: Floats, v: Vector) -> Vector:
    """Return R v for R (3, 3)."""
    return (
        R[0, 0] * v[0] + R[0, 1] * v[1] + R[0, 2] * v[2],
        R[1, 0] * v[0] + R[1, 1] * v[1] + R[1, 2] * v[2],
        R[2, 0] * v[0] + R[2, 1] * v[1] + R[2, 2] * v[2],
    )


@inlined
def unrotate(R: Floats, v: Vector) -> Vector:
    """Return R^T v for R (3, 3)."""
    return (
        R[0, 0] * v[0] + R[1, 0] * v[1] + R[2, 0] * v[2],
        R[0, 1] * v[0] + R[1, 1] * v[1] + R[2, 1] * v[2],
        R[0, 2] * v[0] + R[1, 2] * v[1] + R[2, 2] * v[2],
    )


@inlined
def column(R: Floats, k: int) -> Vector:
    """Return column k of R: the k-th axis of the frame, in World."""
    return R[0, k], R[1, k], R[2, k]
