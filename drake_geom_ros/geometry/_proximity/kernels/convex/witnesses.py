"""Points of two cores that span an answer: b - a is the distance along the normal.

Those that a solver ends with are aside of one another by some rounding, or, where the normal is
level, by more. They are moved by as little as there is, and what they are off their surfaces then
is in the error bound.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.convex.depths import points_on_edges
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import distance_of_cores
from drake_geom_ros.geometry._proximity.kernels.cores.inner_balls import depth_of_point
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import core_radius
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    norm,
    scale,
    sub,
    unrotate,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import EPS, LOOSE_SLOPE, ROUNDING


@compiled
def drawn_to(distance: float, n: Vector, a: Vector, b: Vector) -> tuple[Vector, Vector, float]:
    """Return (a, b, miss): a and b moved by ``miss``, the least with ``b - a = distance n``."""
    centre, away = scale(0.5, add(a, b)), 0.5 * distance
    miss = 0.5 * norm(add_scaled(sub(b, a), -distance, n))
    return add_scaled(centre, -away, n), add_scaled(centre, away, n), miss


@compiled
def witnesses_of_depth(
    pair: CorePair, n: Vector, depth: float, size: float, a: Vector, b: Vector, aside: float
) -> tuple[Vector, Vector, float]:
    """Return (a, b, miss): points of A and B with ``a - b = depth n``, off the cores by ``miss``.

    Those given are ``aside`` [m] of one another. Where that is more than Newton's method leaves,
    GJK looks for points that touch once B has moved out by the depth: the bodies then are apart
    by the square of what the normal is off. Both tell points by the weights of a triangle, which
    keep few digits where it is a sliver, as of a long capsule and a tiny hull. Edges have none.
    """
    noise = ROUNDING * EPS * size
    if aside > LOOSE_SLOPE * noise:
        kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
        moved = CorePair(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, add_scaled(p, depth, n))
        _, separation, _, _, x, y, _ = distance_of_cores(moved, n, size, 0.0, np.inf)
        if separation < aside:
            a, b, aside = x, add_scaled(y, -depth, n), 0.5 * separation
    if aside > noise:
        on_edges = points_on_edges(pair, n, depth, noise, noise)
        x, y = on_edges.a, on_edges.b
        there = norm(sub(sub(x, y), scale(depth, n)))
        if there < aside:
            a, b, aside = x, y, there
    a, b, miss = drawn_to(-depth, n, a, b)
    return a, b, max(miss, aside)  # EPA's were moved already, by as much as they are aside


@compiled
def off_surfaces(pair: CorePair, n: Vector, a: Vector, b: Vector, miss: float) -> float:
    """Return how far [m] points a and b, which were moved by ``miss``, are off both surfaces."""
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
    r_A, r_B = core_radius(kind_A, shape_A), core_radius(kind_B, shape_B)
    q_A = unrotate(R_WA, add_scaled(a, r_A, n))
    q_B = unrotate(R_WB, add_scaled(sub(b, p), -r_B, n))
    in_A, _ = depth_of_point(kind_A, shape_A, q_A, 0.0)
    in_B, _ = depth_of_point(kind_B, shape_B, q_B, 0.0)
    # Of a hull no closed form tells it.
    return max(min(abs(in_A + r_A), miss), min(abs(in_B + r_B), miss))
