"""Separation of two cores by Newton's method, from a normal near the solution."""

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
    """Return the separation of two cores from the normal n, and the minimum that it belongs to.

    The separation is as that of ``gjk.distance_of_cores``. The end OVERLAP means that the bounds
    have not met; the cores may overlap where the lower bound is negative.
    """
    terms, _, last, r_A, r_B = difference
    lower = -width(terms, last, r_A + r_B, n)
    if lower > cutoff:
        set_shares(terms, last, n)
        a, b = witness_points(difference, n)
        return Separation(BEYOND_CUTOFF, norm(sub(a, b)), lower, n, a, b, n), nowhere(n)
    minimum = nearby_minimum(difference, n, noise)
    kind, n, h, _ = minimum
    if kind == NOTHING:
        p = vector_in(terms, 0)
        return Separation(OVERLAP, np.inf, np.inf, n, p, p, n), minimum
    a, b = witness_points(difference, n)
    upper = norm(sub(a, b))
    end = CLOSED if upper + h <= max(tolerance, noise) else OVERLAP
    if -h > cutoff:
        end = BEYOND_CUTOFF
    return Separation(end, upper, -h, n, a, b, n), minimum


@compiled
def is_polytope(kind: int) -> bool:
    """Return whether a core is a polytope, on which EPA ends even without a tolerance."""
    return kind != CYLINDER and kind != ELLIPSOID


@compiled
def is_strict(difference: Difference, n: Vector, noise: float) -> bool:
    """Return whether n is the only normal of touching cores.

    The normals at a point of a convex body are a cone. So a locally unique normal is unique,
    except for its opposite where the body is flat.
    """
    terms, _, last, r_A, r_B = difference
    if width(terms, last, r_A + r_B, scale(-1.0, n)) <= 2.0 * noise:
        return False
    return widest_cap(difference, nearby_minimum(difference, n, noise), noise) > 0.0


@inlined
def has_its_digits(pair: CorePair, difference: Difference, gap: float, noise: float) -> bool:
    """Return whether bounds ``gap`` [m] apart are as close as Newton's method could bring them.

    This holds for two polytopes, one of them a hull, whose bounds differ by rounding; beside a
    round body the normal is less accurate.
    """
    polytopes = is_polytope(pair.kind_A) and is_polytope(pair.kind_B)
    return difference.last == 0 and gap <= noise and polytopes


@allocating
def sharpened(
    pair: CorePair, difference: Difference, n: Vector, gap: float, noise: float, tolerance: float
) -> Separation:
    """Return the separation to its last digits, by Newton's method from n; CLOSED if successful.

    For hulls it uses the edges next to n. These are no nearer than the hulls, and the slab along
    the normal bounds the distance of the hulls from below. The given bounds are ``gap`` [m] apart.
    """
    hulls = difference.last == 0
    if hulls:
        difference = difference_of_edges(pair, n)
    separation, _ = by_newton(difference, n, noise, tolerance, np.inf)
    end, distance, lower, n, a, b, _ = separation
    if hulls:
        lower = min(lower, separation_along(pair, n))
        if distance - lower > max(gap, noise):
            end = OVERLAP
    return Separation(end, distance, lower, n, a, b, n)
