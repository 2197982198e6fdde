"""How far a core or a solid is from a solid's surface: branch and bound over trees of boxes.

A is a ``Body`` and B a ``Solid`` of ``tree``, and A's origin is at p in B. Points are
measured from Bo and expressed in B's axes; n points from A towards B.

A pair of leaves is answered by GJK, with a certificate; a sphere's centre by the closed form. What
touches to rounding is told from what crosses by the slabs between the leaves: a face that lies
flush on another crosses nothing.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import (
    BEYOND_CUTOFF,
    CLOSED,
    OVERLAP,
    distance_of_cores,
    support_points,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Separation
from drake_geom_ros.geometry._proximity.kernels.cores.simplices import (
    closest_on_triangle,
    weighted,
)
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import width_of_hulls
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    Solid,
    TreeBody,
    edge_of,
    first_of_leaf,
    normal_of,
)
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    column,
    cross,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID, SPHERE, TRIANGLE
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    NEAR_TOUCH,
    ROUNDING,
    SAME_DIRECTION,
    SHARPER,
)


class Nearest(NamedTuple):
    """Where the surfaces of A's core and of B are nearest: a and b, with n from a to b.

    ``lower <= distance <= upper = |b - a|``. End BEYOND_CUTOFF: farther apart than was asked, and
    only ``lower`` tells. End OVERLAP: they cross, and the rest tells nothing. ``unique`` is False
    if other points are as near, along a clearly different n.
    """

    end: int
    upper: float
    lower: float
    n: Vector
    a: Vector
    b: Vector
    unique: bool


@compiled
def leaf_pair(A: TreeBody, i: int, B: Solid, j: int, p: Vector) -> CorePair:
    """Return the pair, as GJK takes it, of A's core or triangle i and of B's triangle j."""
    kind, shape = A.kind, A.shape
    if kind == SOLID:
        at = A.tree.corners + CORNERS * i
        kind, shape = TRIANGLE, shape[at : at + CORNERS]
    at = B.tree.corners + CORNERS * j
    corners = B.shape[at : at + CORNERS]
    return CorePair(kind, shape, A.R, TRIANGLE, corners, B.identity, scale(-1.0, p))


@compiled
def slab_axis(A: TreeBody, i: int, B: Solid, j: int, turn: int) -> Vector:
    """Return one of the 11 axes that may separate two leaves, or the zero vector.

    They are the normals of both triangles and the products of their edges; of a core, which has no
    normal, its axes stand for edges. Of a box and of a triangle these are all there are.
    """
    if turn == 0:
        return normal_of(B.shape, B.tree, j)
    if turn == 1:
        return rotate(A.R, normal_of(A.shape, A.tree, i)) if A.kind == SOLID else (0.0, 0.0, 0.0)
    k, m = (turn - 2) // 3, (turn - 2) % 3
    other = column(A.R, m)
    if A.kind == SOLID:
        other = rotate(A.R, edge_of(A.shape, A.tree, i, m))
    return unit(cross(edge_of(B.shape, B.tree, j, k), other))


@compiled
def widest_slab(
    A: TreeBody, i: int, B: Solid, j: int, pair: CorePair, noise: float
) -> tuple[float, Vector]:
    """Return (width, n) of the widest slab between two leaves along ``slab_axis``.

    Of slabs that are as wide to rounding n is the first one's, out of A's triangle and into B's:
    of faces that lie flush rounding would choose the side.
    """
    widest, best, best_n = -math.inf, -math.inf, (0.0, 0.0, 0.0)
    for turn in range(11):
        axis = slab_axis(A, i, B, j, turn)
        first = -1.0 if turn == 0 else 1.0
        for side in range(2):
            n = scale(first * (1.0 - 2.0 * side), axis)
            a, b = support_points(pair, n, 0.0)
            width = dot(sub(b, a), n)
            if dot(n, n) > 0.5:
                widest = max(widest, width)
                if width > best + noise:
                    best, best_n = width, n
    return widest, best_n


@compiled
def separation_of_point(q: Vector, B: Solid, j: int, noise: float) -> tuple[float, Vector, Vector]:
    """Return (d, n, b) for the point b of triangle j nearest to q, at d along the unit n."""
    at = B.tree.corners + CORNERS * j
    x = sub(vector_at(B.shape, at), q)
    y, z = sub(vector_at(B.shape, at + 3), q), sub(vector_at(B.shape, at + 6), q)
    v = weighted(x, y, z, closest_on_triangle(x, y, z))
    d = norm(v)
    if d > noise:
        return d, unit(v), add(q, v)
    n = scale(-1.0, normal_of(B.shape, B.tree, j))
    if dot(n, n) < 0.5:
        n = (-1.0, 0.0, 0.0)
    return d, n, add(q, v)


@compiled
def separation_of_leaves(
    A: TreeBody,
    i: int,
    B: Solid,
    j: int,
    p: Vector,
    n: Vector,
    size: float,
    tolerance: float,
    limit: float,
) -> Separation:
    """Return the separation of two leaves, as GJK does, but a and b are from Bo."""
    noise = ROUNDING * EPS * size
    if A.kind == SPHERE:
        d, n, b = separation_of_point(p, B, j, noise)
        return Separation(CLOSED if d <= limit else BEYOND_CUTOFF, d, d, n, p, b)
    pair = leaf_pair(A, i, B, j, p)
    end, upper, lower, n, a, b = distance_of_cores(pair, n, size, SHARPER * tolerance, limit)
    apart = end != OVERLAP and end != BEYOND_CUTOFF
    if apart and upper - lower > max(tolerance, noise):
        # A thin simplex lost its last digits (curved cores, triangles of km): with a new one the
        # walk goes on.
        again = distance_of_cores(pair, n, size, SHARPER * tolerance, limit)
        closed = again.end != OVERLAP and again.end != BEYOND_CUTOFF
        if closed and again.upper - again.lower < upper - lower:
            end, upper, lower, n, a, b = again
    if end == OVERLAP or (apart and upper <= NEAR_TOUCH * size):
        width, m = widest_slab(A, i, B, j, pair, noise)
        if end == OVERLAP or width > lower:
            n, lower = m, width
        apart = apart or lower >= -noise
    if apart:
        end = CLOSED
    return Separation(end, upper, lower, n, add(p, a), add(p, b))


@compiled
def is_wider(A: TreeBody, B: Solid, p: Vector, n: Vector, other: Vector) -> bool:
    """Tell whether the hulls are less of an overlap along n than along another direction.

    Of walls that are in line and floors that lie on each other, the floors are in contact.
    """
    along, across = scale(-1.0, n), scale(-1.0, other)
    return width_of_hulls(A, B, p, along, 0.0) < width_of_hulls(A, B, p, across, 0.0)


@allocating
def nearest(
    A: TreeBody, B: Solid, p: Vector, n: Vector, size: float, tolerance: float, limit: float
) -> Nearest:
    """Return where the surfaces of A's core and of B are nearest.

    Nothing nearer is missed: left out, by boxes or within a leaf by GJK, is what is beyond the
    limit, or farther than the best so far by more than ``noise``, which rounding keeps below. The
    least of what was left out is in ``lower``: with ``noise`` added to the error it is a
    certificate. Nothing that crosses is missed, if the limit is ``noise`` or more: its boxes have
    a separation of 0, to rounding, and no best is below 0.
    """
    noise, cutoff = ROUNDING * EPS * size, limit
    path, top = walk(A, B, p), 1
    best, least, a, b, unique = math.inf, math.inf, p, p, True
    n_best = n
    while True:
        top, i, j, skipped = next_leaves(A, B, p, path, top, limit)
        least = min(least, skipped)
        if i < 0:
            break
        for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
            for m in range(first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)):
                end, upper, lower, n, x, y = separation_of_leaves(
                    A, k, B, m, p, n_best, size, tolerance, limit
                )
                if end == OVERLAP:
                    return Nearest(OVERLAP, upper, lower, n, x, y, True)
                least = min(least, lower)
                if end == BEYOND_CUTOFF:
                    continue
                if upper < best - noise:
                    nearer, unique = True, True
                elif upper > best + noise:
                    continue
                elif dot(n, n_best) < SAME_DIRECTION:
                    nearer, unique = best <= noise and is_wider(A, B, p, n, n_best), False
                else:
                    nearer = upper < best
                best = min(best, upper)
                limit = min(limit, best + noise)
                if nearer:
                    n_best, a, b = n, x, y
    # What was left out is farther than the cutoff; so may be what was answered all the same.
    end = CLOSED if best < math.inf and least <= cutoff else BEYOND_CUTOFF
    return Nearest(end, best, min(least, best), n_best, a, b, unique)


@compiled
def push_out(
    A: TreeBody, i: int, B: Solid, j: int, p: Vector, radius: float, found: Separation
) -> tuple[Vector, float]:
    """Return (m, s): moving A by s along the unit m takes it, as far as these leaves go, out of B.

    ``found`` is their ``separation_of_leaves``. Where the leaves cross, m is the normal of B's
    triangle and all of A's core, or A's triangle, is lifted over its plane; else m is from b to a.
    """
    if found.end != OVERLAP:
        return scale(-1.0, found.n), radius - found.upper
    m = normal_of(B.shape, B.tree, j)
    pair = leaf_pair(A, i, B, j, p)
    a, b = support_points(pair, scale(-1.0, m), 0.0)
    return m, dot(sub(b, a), m) + radius


@allocating
def close_pairs(
    A: TreeBody,
    B: Solid,
    p: Vector,
    n: Vector,
    size: float,
    tolerance: float,
    cutoff: float,
    pairs: Indices,
) -> int:
    """Fill ``pairs`` (k, 2) with leaves of A and of B within ``cutoff``; return how many.

    Whoever asks has room for as many as matter; the rest is left out: they are where to begin, and
    no answer rests on there being no more.
    """
    noise = ROUNDING * EPS * size
    path, top = walk(A, B, p), 1
    count = 0
    while True:
        top, i, j, _ = next_leaves(A, B, p, path, top, cutoff)
        if i < 0:
            return count
        for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
            for t in range(first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)):
                found = separation_of_leaves(A, k, B, t, p, n, size, tolerance, cutoff + noise)
                if found.end == OVERLAP or (found.end == CLOSED and found.upper <= cutoff):
                    pairs[count, 0], pairs[count, 1] = k, t
                    count += 1
                    if count == pairs.shape[0]:
                        return count


# Columns of a row of pushes: out along a unit vector, by how much [m].
PUSH_WAY = 0  # 3
PUSH_LENGTH = 3
PUSH_WIDTH = 4


@allocating
def contacts(
    A: TreeBody,
    B: Solid,
    p: Vector,
    n: Vector,
    size: float,
    tolerance: float,
    radius: float,
    slots: Floats,
    most: int,
) -> int:
    """Fill ``slots`` (k, PUSH_WIDTH) with pushes of distinct directions; return how many.

    Of A's core grown by a ball of ``radius``. At most ``most`` pairs of leaves in contact are
    looked at; a slot keeps the longest push along its direction.
    """
    noise = ROUNDING * EPS * size
    pairs = np.empty((most, 2), dtype=np.int64)
    count = 0
    for k in range(close_pairs(A, B, p, n, size, tolerance, radius, pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        found = separation_of_leaves(A, i, B, j, p, n, size, tolerance, radius + noise)
        m, s = push_out(A, i, B, j, p, radius, found)
        if s > 0.0 and dot(m, m) > 0.5:
            count = add_slot(slots, count, m, s)
    return count


@compiled
def add_slot(slots: Floats, count: int, m: Vector, s: float) -> int:
    """Put a push into the slot of its direction, or into a new one while there is room."""
    for k in range(count):
        if dot(vector_at(slots[k], PUSH_WAY), m) >= SAME_DIRECTION:
            slots[k, PUSH_LENGTH] = max(slots[k, PUSH_LENGTH], s)
            return count
    if count < slots.shape[0]:
        for c in range(3):
            slots[count, PUSH_WAY + c] = m[c]
        slots[count, PUSH_LENGTH] = s
        count += 1
    return count
