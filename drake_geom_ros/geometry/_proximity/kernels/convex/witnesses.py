"""Witness points of two cores: b - a is the distance along the normal.

The final points of a solver deviate sideways by some rounding, or by more where h is level. They
are moved by the least amount, and their distance from the surfaces is added to the error bound.
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
    """Return (a, b, miss): a and b moved by the least ``miss`` so that ``b - a = distance n``."""
    centre, away = scale(0.5, add(a, b)), 0.5 * distance
    miss = 0.5 * norm(add_scaled(sub(b, a), -distance, n))
    return add_scaled(centre, -away, n), add_scaled(centre, away, n), miss


@compiled
def witnesses_of_depth(
    pair: CorePair, n: Vector, depth: float, size: float, a: Vector, b: Vector, aside: float
) -> tuple[Vector, Vector, float]:
    """Return (a, b, miss): points with ``a - b = depth n``, off the cores by at most ``miss``.

    The given points deviate by ``aside`` [m]. Where that exceeds what Newton's method leaves, GJK
    searches for points that touch once B has moved out by the depth: the bodies are then separated
    by the square of the error of the normal. Both GJK and EPA compute points from the weights of a
    triangle, which have few digits for a sliver, as of a long capsule and a tiny hull. Edges avoid
    that.
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
        aside_on_edges = norm(sub(sub(x, y), scale(depth, n)))
        if aside_on_edges < aside:
            a, b, aside = x, y, aside_on_edges
    a, b, miss = drawn_to(-depth, n, a, b)
    return a, b, max(miss, aside)  # EPA's points were moved already, by ``aside``


@compiled
def off_surfaces(pair: CorePair, n: Vector, a: Vector, b: Vector, miss: float) -> float:
    """Return the distance [m] of points a and b, moved by ``miss``, from their surfaces."""
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
    r_A, r_B = core_radius(kind_A, shape_A), core_radius(kind_B, shape_B)
    q_A = unrotate(R_WA, add_scaled(a, r_A, n))
    q_B = unrotate(R_WB, add_scaled(sub(b, p), -r_B, n))
    in_A, _ = depth_of_point(kind_A, shape_A, q_A, 0.0)
    in_B, _ = depth_of_point(kind_B, shape_B, q_B, 0.0)
    # A hull has no closed form for it.
    return max(min(abs(in_A + r_A), miss), min(abs(in_B + r_B), miss))
