"""Signed distance of convex pairs that have no closed form: GJK apart, EPA overlapping.

One function, ``signed_distance_of_cores``, serves every pair and is compiled once; a kernel is its
name with two type numbers. See ``supports`` for the cores and ``gjk`` and ``epa`` for the bounds.

Where the answer is not unique (UNIQUE is 0) the direction is the one that EPA came to first, which
depends on the poses alone: the same call gives the same answer. UNIQUE is 1 where the bounds
exclude every direction more than 8 degrees away, so with a loose tolerance it may be 0 for an
answer that is unique.
"""

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.calling import BOUND_ONLY, ITERATIVE, write
from drake_geom_ros.geometry._proximity.kernels.epa import depth_of_cores
from drake_geom_ros.geometry._proximity.kernels.gjk import (
    BEYOND_CUTOFF,
    CLOSED,
    OVERLAP,
    distance_of_cores,
)
from drake_geom_ros.geometry._proximity.kernels.revolution import common_axis, depth_of_revolution
from drake_geom_ros.geometry._proximity.kernels.supports import (
    bounding_radius,
    core_radius,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import add, add_scaled, norm, scale, sub
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    NEAR_TOUCH,
    ROUNDING,
    SHARPER,
    SHARPER_DEPTH,
)

# Caps of EPA. An ordinary smooth minimum takes 20 to 150 vertices to 1e-10, and arrays of that
# size cost nothing to get: ten times larger ones go back to the system after each call, which
# costs as much as EPA does. Only minima that are almost a ring, of shapes almost in a symmetric
# position, get to the second cap, which leaves about 1e-6 of the size between the bounds.
FEW_VERTICES = 160
MANY_VERTICES = 3000


@compiled
def depth_and_bounds(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p, size, tolerance):
    """Return what ``epa.depth_of_cores`` does, by the cheaper way."""
    u, move = common_axis(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB)
    enough = max(tolerance, ROUNDING * EPS * size)
    if move <= 0.5 * enough:
        return depth_of_revolution(
            kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p, u, move, size, tolerance
        )
    most_vertices = FEW_VERTICES
    while True:
        found = depth_of_cores(
            kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p, size, tolerance, most_vertices
        )
        # Where the difference has the origin on its surface the bounds add up to some tolerances.
        if found[0] - found[1] <= 4.0 * enough or most_vertices == MANY_VERTICES:
            return found
        most_vertices = MANY_VERTICES


@compiled
def signed_distance_of_cores(
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out
):
    """Write the result row of two convex shapes, given by type number and parameters."""
    r_A, r_B = core_radius(kind_A, shape_A), core_radius(kind_B, shape_B)
    p = (p_AB_W[0], p_AB_W[1], p_AB_W[2])
    size = bounding_radius(kind_A, shape_A) + bounding_radius(kind_B, shape_B) + norm(p)
    noise = ROUNDING * EPS * size
    end, upper, lower, n, a, b = distance_of_cores(
        kind_A,
        shape_A,
        R_WA,
        kind_B,
        shape_B,
        R_WB,
        p,
        size,
        SHARPER * tolerance,
        cutoff + r_A + r_B,
    )
    distance, unique, method = upper, True, ITERATIVE
    if end == BEYOND_CUTOFF:
        method = BOUND_ONLY
        distance = lower
        b = add_scaled(a, lower, n)
    elif end != CLOSED or upper <= NEAR_TOUCH * size or upper - lower > max(tolerance, noise):
        depth, least, n_in, a_in, b_in, aside, unique_in = depth_and_bounds(
            kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p, size, SHARPER_DEPTH * tolerance
        )
        gap, upper = upper - lower, min(upper, -least)
        if end == OVERLAP or upper + depth <= gap + noise:  # else the bounds of GJK are tighter
            distance, lower, n = -depth, max(lower, -depth), n_in
            unique = unique_in or distance > noise
            # The pair of points that is less aside of n: EPA's where the cores are fat, GJK's
            # where they are apart or EPA saw a flat from one end.
            if aside <= norm(sub(sub(a, b), scale(depth, n))):
                a, b = a_in, b_in
            centre = scale(0.5, add(a, b))
            a, b = add_scaled(centre, 0.5 * depth, n), add_scaled(centre, -0.5 * depth, n)
    error_bound = max(upper - distance, distance - lower) + noise
    write(
        out,
        distance - r_A - r_B,
        scale(-1.0, n),
        add_scaled(a, r_A, n),
        add_scaled(b, -r_B, n),
        error_bound,
        unique,
        method,
    )
