"""Witness points of a polytope, from the point of its faces nearest to the minimum."""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.polytope import (
    ALIVE,
    OFFSET,
)
from drake_geom_ros.geometry._proximity.kernels.cores.simplices import (
    closest_on_triangle,
    weighted,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    dot,
    norm,
    scale,
    sub,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Integers32, Vector, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import (
    SAME_DIRECTION,
)


@compiled
def closest_in_face(
    points: Floats, i: int, j: int, k: int, foot: Vector
) -> tuple[float, Vector, Vector]:
    """Return (away, a, b): the distance of ``foot`` from the triangle of vertices i, j, k.

    a and b are the points of A and B whose difference is the nearest point of the triangle.
    """
    x = sub(vector_in(points, i), foot)
    y, z = sub(vector_in(points, j), foot), sub(vector_in(points, k), foot)
    t = closest_on_triangle(x, y, z)
    a = weighted(vector_in(points, i, 3), vector_in(points, j, 3), vector_in(points, k, 3), t)
    b = weighted(vector_in(points, i, 6), vector_in(points, j, 6), vector_in(points, k, 6), t)
    return norm(weighted(x, y, z, t)), a, b


@inlined
def moved_to_planes(
    a: Vector, b: Vector, n: Vector, upper: float, s_A: Vector, s_B: Vector
) -> tuple[Vector, Vector]:
    """Return (a, b) moved along n to the planes through s_A and s_B, with a - b = upper n."""
    rise = dot(sub(s_A, a), n) + dot(sub(s_B, b), n)
    centre = scale(0.5, add_scaled(add(a, b), rise, n))
    return add_scaled(centre, 0.5 * upper, n), add_scaled(centre, -0.5 * upper, n)


@compiled
def witness(
    points: Floats,
    faces: Integers32,
    planes: Floats,
    total: int,
    n: Vector,
    upper: float,
    rival: float,
    s_A: Vector,
    s_B: Vector,
) -> tuple[Vector, Vector, float]:
    """Return (a, b, aside): points on the supporting planes of A and B with a - b = upper n.

    They come from the point of the faces nearest to upper n, moved out to the planes. On a flat
    part of the difference it may be in any face, not only in the one that was expanded. ``aside``
    is the distance of that point from upper n, and bounds how far a and b are off their surfaces.
    """
    foot = scale(upper, n)
    a, b, least = s_A, s_B, np.inf
    for f in range(unsigned(total)):
        if planes[f, OFFSET] > rival or faces[f, ALIVE] == 0:  # most are too far away
            continue
        if dot((planes[f, 0], planes[f, 1], planes[f, 2]), n) < SAME_DIRECTION:
            continue
        away, x, y = closest_in_face(points, faces[f, 0], faces[f, 1], faces[f, 2], foot)
        if away < least:
            a, b, least = x, y, away
    a, b = moved_to_planes(a, b, n, upper, s_A, s_B)
    return a, b, least
