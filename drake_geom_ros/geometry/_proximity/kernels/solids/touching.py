"""All triangles of two solids that meet: what follows for the insides, and the ways apart.

Bodies are given as in ``distance``; the triangles are those of ``rays.Posed``.
"""

from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.solids.contacts import PUSH_LENGTH, PUSH_WAY
from drake_geom_ros.geometry._proximity.kernels.solids.distance import (
    TOUCHING,
    Nearest,
    is_wider,
)
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import separation_of_leaves
from drake_geom_ros.geometry._proximity.kernels.solids.meetings import (
    A_IS_OUT,
    B_IS_OUT,
    NOTHING,
    OVERLAPPING,
    TOUCH,
    meeting,
)
from drake_geom_ros.geometry._proximity.kernels.solids.rays import Posed, triangle_of
from drake_geom_ros.geometry._proximity.kernels.solids.signs import Triangle
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    SolidPair,
    first_of_leaf,
    normal_of,
)
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kernels.vectors import dot, rotate, scale, vector_at
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

# Columns of a row of ways apart, beyond those of a push (``contacts``).
WAY_A = 4  # triangles of A and of B that it separates
WAY_B = 5
IS_FLUSH = 6  # 1 where they lie on each other, 0 where an edge or a corner does
WAY_WIDTH = 7
MOST_WAYS = 8  # clearly different directions


class Met(NamedTuple):
    """The result of all triangles that meet: whether they show an overlap, and whether any touch.

    ``ways`` is the number of rows of ways apart that were filled.
    """

    overlapping: bool
    touches: bool
    ways: int


@compiled
def beside(
    T: Triangle,
    S: Triangle,
    apart: float,
) -> bool:
    """Return whether the boxes of two triangles are more than ``apart`` from each other."""
    (a, b, c), (x, y, z) = T, S
    for k in range(3):
        if min(a[k], b[k], c[k]) - max(x[k], y[k], z[k]) > apart:
            return True
        if min(x[k], y[k], z[k]) - max(a[k], b[k], c[k]) > apart:
            return True
    return False


@compiled
def add_way(ways: Floats, count: int, m: Vector, k: int, j: int, flush: float) -> int:
    """Put a way into the row of its direction, flush ones first, or else into a free row."""
    if not dot(m, m) > 0.5:
        return count
    for row in range(count):
        if dot(vector_at(ways[row], PUSH_WAY), m) >= SAME_DIRECTION:
            if flush > ways[row, IS_FLUSH]:
                ways[row, WAY_A], ways[row, WAY_B], ways[row, IS_FLUSH] = k, j, flush
            return count
    if count == ways.shape[0]:
        return count
    for c in range(3):
        ways[count, PUSH_WAY + c] = m[c]
    ways[count, PUSH_LENGTH], ways[count, WAY_A], ways[count, WAY_B] = 0.0, k, j
    ways[count, IS_FLUSH] = flush
    return count + 1


@compiled
def add_ways(pair: SolidPair, bits: int, k: int, j: int, ways: Floats, count: int) -> int:
    """Add the way apart of two triangles that touch: out of the one that the other lies on."""
    A, B = pair.A, pair.B
    flush = 1.0 if bits & A_IS_OUT and bits & B_IS_OUT else 0.0
    if bits & B_IS_OUT:
        return add_way(ways, count, normal_of(B.shape, B.tree, j), k, j, flush)
    if bits & A_IS_OUT:
        m = scale(-1.0, rotate(A.R, normal_of(A.shape, A.tree, k)))
        return add_way(ways, count, m, k, j, flush)
    return count


@allocating
def meet_anywhere(
    pair: SolidPair,
    posed: tuple[Posed, Posed],
    reach: float,
    touch_bits: tuple[Indices, Indices],
    ways: Floats,
) -> Met:
    """Return whether triangles of A and B that meet show that these overlap, and how they touch.

    ``touch_bits`` ((n,), (m,)) gets the bits of each triangle of A and of B, ``ways``
    (k, WAY_WIDTH) the directions apart; triangles farther apart than ``reach`` do not meet.
    """
    A, B, p = pair.A, pair.B, pair.p
    (posed_A, posed_B), (of_A, of_B) = posed, touch_bits
    path, top = walk(A, B, p), 1
    touches, count = False, 0
    while True:
        top, i, j, _ = next_leaves(A, B, p, path, top, reach)
        if i < 0:
            return Met(False, touches, count)
        for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
            T = triangle_of(posed_A, k)
            for m in range(first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)):
                S = triangle_of(posed_B, m)
                if beside(T, S, reach):
                    continue
                bits = meeting(T, S, posed_A.off)
                if bits == NOTHING:
                    continue
                if bits & OVERLAPPING:
                    return Met(True, True, count)
                touches = True
                of_A[k] |= bits & (TOUCH | A_IS_OUT)
                of_B[m] |= bits & (TOUCH | B_IS_OUT)
                count = add_ways(pair, bits, k, m, ways, count)


@compiled
def contact_of(pair: SolidPair, closest: Nearest, ways: Floats, count: int) -> Nearest:
    """Return where A and B touch, by the ways of triangles that do, or ``closest`` without any.

    Among faces that lie on each other, or else among all, it takes the way along which the hulls
    overlap the least.
    """
    best, n, unique = -1, closest.n, True
    for row in range(count):
        other = scale(-1.0, vector_at(ways[row], PUSH_WAY))
        unique = unique and dot(other, closest.n) >= SAME_DIRECTION
        firmer = best < 0 or ways[row, IS_FLUSH] > ways[best, IS_FLUSH]
        as_firm = best < 0 or ways[row, IS_FLUSH] == ways[best, IS_FLUSH]
        if firmer or (as_firm and is_wider(pair, other, n)):
            best, n = row, other
    if best < 0:
        return closest
    k, j = int(ways[best, WAY_A]), int(ways[best, WAY_B])
    at = separation_of_leaves(pair, k, j, n, pair.size)
    return Nearest(TOUCHING, at.upper, min(at.lower, 0.0), n, at.a, at.b, unique)
