"""Signs of determinants, exact where floats cannot decide.

A place is a point of six numbers: its rounded coordinates, then their rounding errors. So a vertex
that a pose without rotation has moved is exact to the last bit. A sign is that of a determinant of
differences of places: computed in floats where the error bound allows, else summed without error
as an expansion, a sum of floats that do not overlap (Shewchuk, Discrete & Computational Geometry
18 (3), 1997). Places may be off by ``off`` [m], as a rotation leaves them: then a determinant that
is no larger than the error this causes counts as 0, and nothing is summed.
"""

from typing import NamedTuple, TypeAlias

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.vectors import cross, dot
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import EPS

Place: TypeAlias = tuple[float, float, float, float, float, float]
Triangle: TypeAlias = tuple[Place, Place, Place]
Signs: TypeAlias = tuple[int, int, int]

SPLITTER = 2.0**27 + 1.0
# Of a determinant of differences, over the sum of its products' sizes: each of three factors is
# off by EPS, products and sums add four times half of it.
FILTER = 16.0 * EPS
MOST_PARTS = 1600  # six triple products of expansions of four parts, four parts each


@inlined
def two_sum(a: float, b: float) -> tuple[float, float]:
    """Return (s, e) with s + e = a + b exactly, s the rounded sum (Knuth)."""
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


@inlined
def halves(a: float) -> tuple[float, float]:
    """Return two numbers of 26 bits at most, whose sum is a (Dekker)."""
    c = SPLITTER * a
    high = c - (c - a)
    return high, a - high


@inlined
def two_product(a: float, b: float) -> tuple[float, float]:
    """Return (p, e) with p + e = a b exactly, p the rounded product."""
    p = a * b
    (ah, al), (bh, bl) = halves(a), halves(b)
    return p, al * bl - (((p - ah * bh) - al * bh) - ah * bl)


@inlined
def grow(parts: Floats, count: int, x: float) -> int:
    """Add x to an expansion, smallest part first; return its number of parts."""
    remaining = 0
    for k in range(count):
        x, e = two_sum(x, parts[k])
        if e != 0.0:
            parts[remaining] = e
            remaining += 1
    if x != 0.0:
        parts[remaining] = x
        remaining += 1
    return remaining


@compiled
def difference(parts: Floats, a: Place, b: Place, c: int) -> int:
    """Write coordinate c of a - b as an expansion; return its number of parts."""
    count = grow(parts, 0, a[c])
    count = grow(parts, count, -b[c])
    count = grow(parts, count, a[c + 3])
    return grow(parts, count, -b[c + 3])


@compiled
def add_products(
    total: Floats, count: int, sign: float, edges: Floats, counts: Indices, k: Signs
) -> int:
    """Add sign u_k[0] v_k[1] w_k[2], k a permutation of axes, to an expansion."""
    for i in range(counts[0, k[0]]):
        for j in range(counts[1, k[1]]):
            high, low = two_product(sign * edges[0, k[0], i], edges[1, k[1], j])
            for m in range(counts[2, k[2]]):
                p, e = two_product(high, edges[2, k[2], m])
                count = grow(total, count, e)
                count = grow(total, count, p)
                if low != 0.0:
                    p, e = two_product(low, edges[2, k[2], m])
                    count = grow(total, count, e)
                    count = grow(total, count, p)
    return count


@allocating
def exact_sign(a: Place, b: Place, c: Place, d: Place, axis: int) -> int:
    """Return the sign of ``det(b - a, c - a, d - a)``.

    With ``axis`` >= 0 the unit vector along that axis stands for the last column.
    """
    edges, counts = np.empty((3, 3, 4)), np.zeros((3, 3), dtype=np.int64)
    for k in range(3):
        counts[0, k] = difference(edges[0, k], b, a, k)
        counts[1, k] = difference(edges[1, k], c, a, k)
        if axis < 0:
            counts[2, k] = difference(edges[2, k], d, a, k)
    if axis >= 0:
        counts[2, axis], edges[2, axis, 0] = 1, 1.0
    total, count = np.empty(MOST_PARTS), 0
    count = add_products(total, count, 1.0, edges, counts, (0, 1, 2))
    count = add_products(total, count, 1.0, edges, counts, (1, 2, 0))
    count = add_products(total, count, 1.0, edges, counts, (2, 0, 1))
    count = add_products(total, count, -1.0, edges, counts, (0, 2, 1))
    count = add_products(total, count, -1.0, edges, counts, (1, 0, 2))
    count = add_products(total, count, -1.0, edges, counts, (2, 1, 0))
    if count == 0:
        return 0
    return 1 if total[count - 1] > 0.0 else -1


@inlined
def apart(a: Place, b: Place) -> tuple[Vector, Vector]:
    """Return the rounded difference of two places, and bounds of its terms."""
    x = (a[0] - b[0]) + (a[3] - b[3])
    y = (a[1] - b[1]) + (a[4] - b[4])
    z = (a[2] - b[2]) + (a[5] - b[5])
    return (x, y, z), (
        abs(x) + (abs(a[3]) + abs(b[3])),
        abs(y) + (abs(a[4]) + abs(b[4])),
        abs(z) + (abs(a[5]) + abs(b[5])),
    )


@inlined
def level(a: Place, b: Place, c: Place, d: Place) -> bool:
    """Return whether four places have one coordinate in common."""
    return (
        (a[0] == b[0] == c[0] == d[0] and a[3] == b[3] == c[3] == d[3])
        or (a[1] == b[1] == c[1] == d[1] and a[4] == b[4] == c[4] == d[4])
        or (a[2] == b[2] == c[2] == d[2] and a[5] == b[5] == c[5] == d[5])
    )


@inlined
def plain_difference(a: float, b: float, da: float, db: float) -> tuple[bool, float]:
    """Return (exact, difference) of a and b, with their rounding errors."""
    x, e = two_sum(a, -b)
    return e == 0.0 and da == 0.0 and db == 0.0, x


@inlined
def plain_edge(a: Place, b: Place) -> tuple[bool, Vector]:
    """Return (exact, a - b)."""
    ex, x = plain_difference(a[0], b[0], a[3], b[3])
    ey, y = plain_difference(a[1], b[1], a[4], b[4])
    ez, z = plain_difference(a[2], b[2], a[5], b[5])
    return ex and ey and ez, (x, y, z)


@inlined
def plain_minor(a: float, b: float, c: float, d: float) -> tuple[bool, float]:
    """Return (exact, a d - b c)."""
    p, dp = two_product(a, d)
    q, dq = two_product(b, c)
    x, dx = two_sum(p, -q)
    return dp == 0.0 and dq == 0.0 and dx == 0.0, x


@compiled
def plain_sign(a: Place, b: Place, c: Place, d: Place) -> tuple[bool, int]:
    """Return (is_exact, sign) of ``det(b - a, c - a, d - a)``, exact where nothing is rounded.

    This holds between walls of round numbers, where most determinants are 0.
    """
    (e, u), (f, v), (g, w) = plain_edge(b, a), plain_edge(c, a), plain_edge(d, a)
    if not (e and f and g):
        return False, 0
    (e, x), (f, y) = plain_minor(v[1], v[2], w[1], w[2]), plain_minor(v[2], v[0], w[2], w[0])
    g, z = plain_minor(v[0], v[1], w[0], w[1])
    if not (e and f and g):
        return False, 0
    (p, dp), (q, dq), (r, dr) = two_product(u[0], x), two_product(u[1], y), two_product(u[2], z)
    s, ds = two_sum(p, q)
    s, dt = two_sum(s, r)
    is_exact = dp == dq == dr == ds == dt == 0.0
    return is_exact, 1 if s > 0.0 else (-1 if s < 0.0 else 0)


class SignPlane(NamedTuple):
    """A plane through three places: its normal, as long as twice the triangle, and sizes of it."""

    a: Place
    b: Place
    c: Place
    n: Vector
    most: Vector  # sizes of the products that the normal is a sum of
    reach: float  # factor of an error of a fourth place, beside its own
    share: float


@inlined
def plane_through(a: Place, b: Place, c: Place, off: float) -> SignPlane:
    """Return the plane through three places that may be off by ``off`` [m]."""
    (u, mu), (v, mv) = apart(b, a), apart(c, a)
    most = (
        mu[1] * mv[2] + mu[2] * mv[1],
        mu[2] * mv[0] + mu[0] * mv[2],
        mu[0] * mv[1] + mu[1] * mv[0],
    )
    if off == 0.0:
        return SignPlane(a, b, c, cross(u, v), most, 0.0, 0.0)
    lu, lv = mu[0] + mu[1] + mu[2], mv[0] + mv[1] + mv[2]
    return SignPlane(a, b, c, cross(u, v), most, lu * lv, lu + lv)


@compiled
def summed_sign(a: Place, b: Place, c: Place, d: Place) -> int:
    """Return the sign of ``det(b - a, c - a, d - a)`` without error."""
    is_exact, sign = plain_sign(a, b, c, d)
    return sign if is_exact else exact_sign(a, b, c, d, -1)


@inlined
def side_of(plane: SignPlane, d: Place, off: float) -> int:
    """Return 1 where d is above a plane, whose places turn counter-clockwise as seen from above.

    0 where it is in the plane, -1 where it is beneath.
    """
    a, b, c, n, most, reach, share = plane
    w, mw = apart(d, a)
    value = dot(n, w)
    noise = FILTER * dot(most, mw)
    if off > 0.0:
        noise += 2.0 * off * (reach + share * (mw[0] + mw[1] + mw[2]))
    if value > noise:
        return 1
    if value < -noise:
        return -1
    if off > 0.0 or level(a, b, c, d):
        return 0
    return summed_sign(a, b, c, d)


@compiled
def side(a: Place, b: Place, c: Place, d: Place, off: float) -> int:
    """Return the side of the plane of a, b, c that the place d is on, as ``side_of`` does."""
    return side_of(plane_through(a, b, c, off), d, off)


@compiled
def turn(a: Place, b: Place, c: Place, axis: int, off: float) -> int:
    """Return 1 where a, b, c turn counter-clockwise, seen from far out along an axis.

    0 where they are in a line as seen from there, -1 where they turn the other way.
    """
    (u, mu), (v, mv) = apart(b, a), apart(c, a)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    value = u[i] * v[j] - u[j] * v[i]
    noise = FILTER * (mu[i] * mv[j] + mu[j] * mv[i])
    if off > 0.0:
        noise += 2.0 * off * (mu[i] + mu[j] + mv[i] + mv[j])
    if value > noise:
        return 1
    if value < -noise:
        return -1
    if off > 0.0:
        return 0
    for k in (i, j):
        if a[k] == b[k] == c[k] and a[k + 3] == b[k + 3] == c[k + 3]:
            return 0
    return exact_sign(a, b, c, a, axis)
