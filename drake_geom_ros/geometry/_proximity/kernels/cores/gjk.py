"""GJK: the distance of two disjoint cores, with its witness points.

Gilbert, Johnson, Keerthi (IEEE Journal of Robotics and Automation 4 (2), 1988): a simplex of
points ``w = a - b`` of the Minkowski difference moves to the point closest to the origin. Both
bounds of the answer are certified for any rounding of the iteration: ``|v|`` is the distance of
two points of the cores, and ``f(n) = -h_A(n) - h_B(-n)`` is the width of an empty slab between
them.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Separation
from drake_geom_ros.geometry._proximity.kernels.cores.simplices import (
    closest_on_segment,
    closest_on_tetrahedron,
    closest_on_triangle,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import support
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    norm,
    scale,
    sub,
    unit,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    INSIDE,
    RIGHT_ANGLE,
    ROUNDING,
)

# Ends of an iteration.
CLOSED = 0  # the bounds met, to tolerance or to rounding
BEYOND_CUTOFF = 1
OVERLAP = 2  # the origin is in the Minkowski difference, or on it within rounding
CLOSED_ASIDE = 3  # the bounds met, but perhaps not along b - a

# Ordinary pairs take 5 to 20 steps; beyond this, needles and near touches are left to EPA.
GJK_STEPS = 64
WEIGHT = 9  # column of a simplex row: w, a, b, weight


@inlined
def support_points(pair: CorePair, n: Vector, right_angle: float) -> tuple[Vector, Vector]:
    """Return the points (a, b), from Ao, of A extreme along the unit n and of B along -n."""
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB = pair
    a = support(kind_A, shape_A, R_WA, n, right_angle)
    b = add(p_AB, support(kind_B, shape_B, R_WB, scale(-1.0, n), right_angle))
    return a, b


@inlined
def put(points: Floats, k: int, a: Vector, b: Vector) -> None:
    """Store w = a - b, a and b in row k, at the columns 0, 3 and 6."""
    for i in range(3):
        points[k, i] = a[i] - b[i]
        points[k, 3 + i] = a[i]
        points[k, 6 + i] = b[i]


@compiled
def closest_weights(points: Floats, count: int) -> tuple[float, float, float, float]:
    """Return the weights of up to four simplex points, 0 for those from ``count`` on."""
    if count == 1:
        return 1.0, 0.0, 0.0, 0.0
    if count == 2:
        s = closest_on_segment(vector_in(points, 0), vector_in(points, 1))
        return s[0], s[1], 0.0, 0.0
    if count == 3:
        t = closest_on_triangle(vector_in(points, 0), vector_in(points, 1), vector_in(points, 2))
        return t[0], t[1], t[2], 0.0
    return closest_on_tetrahedron(
        vector_in(points, 0), vector_in(points, 1), vector_in(points, 2), vector_in(points, 3)
    )


@compiled
def reduce_simplex(points: Floats, count: int) -> int:
    """Drop simplex points that do not support the closest point; return how many remain."""
    weights = closest_weights(points, count)
    remaining = 0
    for k in range(count):
        if weights[k] > 0.0:
            for i in range(9):
                points[remaining, i] = points[k, i]
            points[remaining, WEIGHT] = weights[k]
            remaining += 1
    return remaining


@compiled
def combine(points: Floats, count: int, column: int) -> Vector:
    """Return the weighted sum of three columns of the simplex points."""
    x, y, z = 0.0, 0.0, 0.0
    for k in range(count):
        x += points[k, WEIGHT] * points[k, column]
        y += points[k, WEIGHT] * points[k, column + 1]
        z += points[k, WEIGHT] * points[k, column + 2]
    return x, y, z


@inlined
def is_in_simplex(points: Floats, count: int, w: Vector) -> bool:
    """Return whether w is already a vertex of the simplex, so that no better one exists."""
    for k in range(count):
        if points[k, 0] == w[0] and points[k, 1] == w[1] and points[k, 2] == w[2]:
            return True
    return False


@allocating
def distance_of_cores(
    pair: CorePair, n: Vector, size: float, tolerance: float, cutoff: float
) -> Separation:
    """Return the separation of two cores, starting from the unit n, with points a and b from Ao.

    With end OVERLAP, upper is 0 within rounding, a and b are a common point, and n is only the
    last direction tried. ``size`` [m] is the scale to which rounding is relative.
    """
    a, b = support_points(pair, n, RIGHT_ANGLE)
    v = sub(a, b)
    upper = norm(v)
    lower = slab = dot(scale(-1.0, v), n)
    n_lower = n
    if lower > cutoff:
        return Separation(BEYOND_CUTOFF, upper, lower, n, a, b, n)
    points, noise = np.empty((4, WEIGHT + 1)), ROUNDING * EPS * size
    put(points, 0, a, b)
    points[0, WEIGHT] = 1.0
    count = 1
    for _ in range(GJK_STEPS):
        if upper <= noise:
            return Separation(OVERLAP, upper, lower, n, a, b, n_lower)
        n = scale(-1.0 / upper, v)
        s_A, s_B = support_points(pair, n, RIGHT_ANGLE)
        w = sub(s_A, s_B)
        slab = -dot(w, n)
        gained = slab > lower
        if gained:
            lower, n_lower = slab, n
        if lower > cutoff:
            return Separation(BEYOND_CUTOFF, upper, lower, n, a, b, n)
        # A gap g of the bounds at distance d leaves an error sqrt(2 g / d) of the direction, so
        # short distances need a smaller gap.
        enough = max(tolerance * min(1.0, upper / size), noise)
        if upper - lower <= enough or is_in_simplex(points, count, w):
            break
        put(points, count, s_A, s_B)
        count = reduce_simplex(points, count + 1)
        v = combine(points, count, 0)
        closer = norm(v)
        inside = count == 4 and closer <= INSIDE * size
        # The length no longer changes in its last digits while the direction still improves.
        if not inside and (count == 4 or (closer >= upper and not gained)):
            break
        upper = closer
        a, b = combine(points, count, 3), combine(points, count, 6)
        if inside:  # within the rounding of a thin simplex
            return Separation(OVERLAP, upper, lower, n, a, b, n_lower)
        slab = -np.inf  # the slab along b - a is not computed yet
    end = CLOSED if upper - slab <= max(tolerance, noise) else CLOSED_ASIDE
    return Separation(end, upper, lower, unit(sub(b, a)), a, b, n_lower)
