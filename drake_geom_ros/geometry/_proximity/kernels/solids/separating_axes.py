"""The axes that may separate a leaf of A from one of B, and the widest slab along them.

Bodies are given as in ``distance``.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.shapes.supports import support
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    Solid,
    TreeBody,
    edge_of,
    normal_of,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    column,
    cross,
    dot,
    rotate,
    scale,
    sub,
    unit,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined


@inlined
def triangle_from(p: Vector, B: Solid, j: int) -> tuple[Vector, Vector, Vector]:
    """Return the corners of B's triangle j, from a point p."""
    at = B.tree.corners + CORNERS * j
    return (
        sub(vector_at(B.shape, at), p),
        sub(vector_at(B.shape, at + 3), p),
        sub(vector_at(B.shape, at + 6), p),
    )


@inlined
def ends_along(n: Vector, a: Vector, b: Vector, c: Vector) -> tuple[float, float]:
    """Return the least and the largest of three points along n."""
    x, y, z = dot(a, n), dot(b, n), dot(c, n)
    return min(x, y, z), max(x, y, z)


@compiled
def slab_axis(A: TreeBody, i: int, B: Solid, j: int, turn: int) -> Vector:
    """Return one of the 11 axes that may separate two leaves, or the zero vector without one.

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
    A: TreeBody, i: int, B: Solid, j: int, p: Vector, noise: float, enough: float
) -> tuple[float, Vector]:
    """Return (width, n) of the widest slab between two leaves along ``slab_axis``.

    The first slab that is wider than ``enough`` [m] ends the search. Among slabs that are as wide
    to rounding n is the first one's, out of A's triangle and into B's: for faces that lie flush
    rounding would choose the side.
    """
    triangle_B = triangle_from(p, B, j)
    triangle_A = triangle_B
    if A.kind == SOLID:
        at = A.tree.corners + CORNERS * i
        triangle_A = (
            rotate(A.R, vector_at(A.shape, at)),
            rotate(A.R, vector_at(A.shape, at + 3)),
            rotate(A.R, vector_at(A.shape, at + 6)),
        )
    widest, best, best_n = -math.inf, -math.inf, (0.0, 0.0, 0.0)
    for turn in range(11):
        n = slab_axis(A, i, B, j, turn)
        if not dot(n, n) > 0.5:
            continue
        if turn == 0:
            n = scale(-1.0, n)
        begin, end = ends_along(n, triangle_B[0], triangle_B[1], triangle_B[2])
        if A.kind == SOLID:
            low, high = ends_along(n, triangle_A[0], triangle_A[1], triangle_A[2])
        else:
            high = dot(support(A.kind, A.shape, A.R, n, 0.0), n)
            low = dot(support(A.kind, A.shape, A.R, scale(-1.0, n), 0.0), n)
        widest = max(widest, begin - high, low - end)
        if begin - high > best + noise:
            best, best_n = begin - high, n
        if low - end > best + noise:
            best, best_n = low - end, scale(-1.0, n)
        if widest > enough:
            break
    return widest, best_n
