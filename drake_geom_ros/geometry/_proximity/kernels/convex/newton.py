"""The separation of two cores by Newton's method, from a normal that is near already."""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.caps import widest_cap
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import (
    BEYOND_CUTOFF,
    CLOSED,
    OVERLAP,
)
from drake_geom_ros.geometry._proximity.kernels.cores.normals import (
    NOTHING,
    nearby_minimum,
    nowhere,
    set_shares,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import (
    CorePair,
    Difference,
    Minimum,
    Separation,
)
from drake_geom_ros.geometry._proximity.kernels.cores.starts import (
    separation_along,
)
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    difference_of_edges,
    width,
    witness_points,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    norm,
    scale,
    sub,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import CYLINDER, ELLIPSOID
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined


@compiled
def by_newton(
    difference: Difference, n: Vector, noise: float, tolerance: float, cutoff: float
) -> tuple[Separation, Minimum]:
    """Return the separation of two cores, as ``gjk.distance_of_cores`` does, from the normal n.

    End OVERLAP means that the bounds have not met; cores may overlap where lower is negative. The
    second result is the minimum that the separation is of.
    """
    terms, _, last, r_A, r_B = difference
    lower = -width(terms, last, r_A + r_B, n)
    if lower > cutoff:
        set_shares(terms, last, n)
        a, b = witness_points(difference, n)
        return Separation(BEYOND_CUTOFF, norm(sub(a, b)), lower, n, a, b, n), nowhere(n)
    found = nearby_minimum(difference, n, noise)
    kind, n, h, _ = found
    if kind == NOTHING:
        p = vector_in(terms, 0)
        return Separation(OVERLAP, np.inf, np.inf, n, p, p, n), found
    a, b = witness_points(difference, n)
    upper = norm(sub(a, b))
    end = CLOSED if upper + h <= max(tolerance, noise) else OVERLAP
    if -h > cutoff:
        end = BEYOND_CUTOFF
    return Separation(end, upper, -h, n, a, b, n), found


@compiled
def is_polytope(kind: int) -> bool:
    """Tell whether a core has vertices: EPA comes to an end on such ones, without a tolerance."""
    return kind != CYLINDER and kind != ELLIPSOID


@compiled
def is_strict(difference: Difference, n: Vector, noise: float) -> bool:
    """Tell whether touching cores have no normal but n.

    Normals of a point of a convex body make a cone: one that is alone around itself is alone, but
    for its opposite where the body is flat.
    """
    terms, _, last, r_A, r_B = difference
    if width(terms, last, r_A + r_B, scale(-1.0, n)) <= 2.0 * noise:
        return False
    return widest_cap(difference, nearby_minimum(difference, n, noise), noise) > 0.0


@inlined
def has_its_digits(pair: CorePair, difference: Difference, found: float, noise: float) -> bool:
    """Tell whether bounds ``found`` [m] apart are as close as Newton's method could bring them.

    Of two polytopes, one a hull, where they are rounding apart; beside a round body the normal is
    not as good then.
    """
    polytopes = is_polytope(pair.kind_A) and is_polytope(pair.kind_B)
    return difference.last == 0 and found <= noise and polytopes


@allocating
def sharpened(
    pair: CorePair, difference: Difference, n: Vector, found: float, noise: float, tolerance: float
) -> Separation:
    """Return the separation with its last digits, by Newton's method from near n; CLOSED if done.

    Of hulls it takes the edges next to n: they are no nearer than the hulls, and how near these
    may be tells the slab along the normal.
    """
    hulls = difference.last == 0
    if hulls:
        difference = difference_of_edges(pair, n)
    separation, _ = by_newton(difference, n, noise, tolerance, np.inf)
    end, distance, lower, n, a, b, _ = separation
    if hulls:
        lower = min(lower, separation_along(pair, n))
        if distance - lower > max(found, noise):
            end = OVERLAP
    return Separation(end, distance, lower, n, a, b, n)
