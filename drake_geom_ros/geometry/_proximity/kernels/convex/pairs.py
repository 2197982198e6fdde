"""Signed distance of convex pairs without a closed form, by the cheapest method that certifies it.

One function, ``signed_distance_of_cores``, serves every pair and is compiled once. The cores are
those of ``supports``. The methods are tried in this order, each only if the previous one could not
certify its answer:

1. the slab along the hint, or along the line of centres: if wider than the cutoff, BOUND_ONLY;
2. Newton's method on the normal (``normals``): for separated cores, its witness points certify;
3. ``depths`` for overlapping cores, starting from the result of Newton's method;
4. ``gjk`` from the best normal so far, and ``epa`` if that leaves the answer open.

Hulls have no derivatives and start at 3, or at 4 beside another body without a hint.

Where the answer is not unique (UNIQUE is 0), the direction is the first one found. It depends on
the poses and the hint alone, so the same call gives the same answer. UNIQUE is 1 where the bounds
exclude every direction more than 8 degrees away; with a loose tolerance it may be 0 for an answer
that is unique.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    MEMORY_WIDTH,
    SLOT_WIDTH,
    Aim,
    OrientedShape,
    write,
)
from drake_geom_ros.geometry._proximity.kernels.convex.depths import (
    depth_and_bounds,
)
from drake_geom_ros.geometry._proximity.kernels.convex.newton import (
    by_newton,
    has_its_digits,
    is_polytope,
    is_strict,
    sharpened,
)
from drake_geom_ros.geometry._proximity.kernels.convex.witnesses import (
    drawn_to,
    off_surfaces,
    witnesses_of_depth,
)
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import (
    BEYOND_CUTOFF,
    CLOSED,
    CLOSED_ASIDE,
    OVERLAP,
    distance_of_cores,
    support_points,
)
from drake_geom_ros.geometry._proximity.kernels.cores.memory import is_where_it_was
from drake_geom_ros.geometry._proximity.kernels.cores.normals import (
    NOTHING,
    nowhere,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import (
    Bounds,
    CorePair,
    Depth,
    Difference,
    Minimum,
    Overlap,
    Separation,
)
from drake_geom_ros.geometry._proximity.kernels.cores.remembered import remembered_depth
from drake_geom_ros.geometry._proximity.kernels.cores.starts import (
    along_centres,
    hint_of,
    narrower,
    narrower_on_line,
    separation_along,
    start_of_hulls,
    start_of_sums,
)
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    difference_of,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.rings import (
    least_of_hull_in_barrel,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import hull_defect
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import (
    bounding_radius,
    core_radius,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    dot,
    norm,
    scale,
    sub,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOUND_ONLY,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ITERATIVE,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    NEAR_TOUCH,
    RIGHT_ANGLE,
    ROUNDING,
    SHARPER,
    SHARPER_DEPTH,
)


@allocating
def beside_an_axis(
    pair: CorePair, difference: Difference, bounds: Bounds, noise: float, tolerance: float
) -> Bounds:
    """Return closer bounds for a tiny hull just beside a long axis, or ``bounds`` otherwise.

    The simplex of GJK is a sliver there, with a normal of few digits. The least width normal to
    the axis, which is minus the distance where it is negative, has a closed form with a good
    normal.
    """
    if bounds.lower <= noise or bounds.upper - bounds.lower <= max(tolerance, noise):
        return bounds
    axis = pair.kind_A == CAPSULE or pair.kind_A == CYLINDER
    if not axis or pair.kind_B != CONVEX:
        return bounds
    enough = SHARPER * tolerance
    ring = least_of_hull_in_barrel(pair, max(enough, noise), noise)
    end, distance, lower, n, a, b, _ = sharpened(pair, difference, ring.n, np.inf, noise, enough)
    if not ring.complete or end != CLOSED or lower <= noise:
        return bounds
    a, b, miss = drawn_to(distance, n, a, b)
    return Bounds(CLOSED, distance, distance, lower, n, a, b, miss, True, n)


@inlined
def bounds_of_depth(pair: CorePair, depth: Depth, size: float) -> Bounds:
    """Return the bounds of two cores whose depth is certified to be positive."""
    h, lower, n, a, b, aside, unique = depth
    a, b, miss = witnesses_of_depth(pair, n, h, size, a, b, aside)
    return Bounds(CLOSED, -h, -lower, -h, n, a, b, miss, unique, n)


@allocating
def bounds_of_both(
    pair: CorePair,
    difference: Difference,
    separation: Separation,
    overlap: bool,
    size: float,
    tolerance: float,
    noise: float,
    memory: Floats,
) -> Bounds:
    """Return the combined bounds of EPA, or axes, and of an open ``separation`` by GJK.

    ``overlap``: the cores are expected to overlap; ``tolerance`` [m] is that of a depth.
    """
    start = nowhere(separation.n)
    if pair.kind_A == CONVEX and pair.kind_B == CONVEX:
        narrow = narrower_on_line(
            pair, narrower(pair, separation.n, Overlap(np.inf, separation.n))
        )
        start = Minimum(NOTHING, narrow.n, narrow.width, 0.0)
    depth, least, n_in, a_in, b_in, aside, unique_in = depth_and_bounds(
        pair, difference, start, overlap, size, SHARPER_DEPTH * tolerance, memory
    )
    end, upper, lower, n, a, b, n_lower = separation
    open_, distance, unique, miss = upper - lower, upper, True, 0.0
    upper = min(upper, -least)
    if end == OVERLAP or upper + depth <= open_ + noise:  # else the bounds of GJK are tighter
        distance, n = -depth, n_in
        if -depth > lower:
            lower, n_lower = -depth, n_in
        unique = unique_in or distance > noise
        # EPA's points for fat cores; GJK's for separated cores or an overlap that is flat.
        apart = norm(sub(sub(a, b), scale(depth, n)))
        if aside <= apart:
            a, b, apart = a_in, b_in, aside
        a, b, miss = witnesses_of_depth(pair, n, depth, size, a, b, apart)
        # Where h is level, the points of GJK may span the distance unchanged, along another n
        # whose separation lacks less than the points had to be moved.
        moved = end == CLOSED_ASIDE and distance > noise and miss > noise
        if moved and separation.upper - separation_along(pair, separation.n) < miss:
            distance, n, a, b, miss = (
                separation.upper,
                separation.n,
                separation.a,
                separation.b,
                0.0,
            )
    elif separation_along(pair, n) < -depth:
        # The vector b - a of GJK may be too short to have a direction; EPA's faces have normals.
        n, unique = n_in, unique_in or distance > noise
        a, b, miss = drawn_to(distance, n, a, b)
    return Bounds(CLOSED, distance, upper, lower, n, a, b, miss, unique, n_lower)


@allocating
def bounds_of_cores(
    pair: CorePair,
    n: Vector,
    hinted: bool,
    size: float,
    tolerance: float,
    cutoff: float,
    memory: Floats,
) -> Bounds:
    """Return the bounds of the signed distance of two cores; see ``remembered`` for ``memory``."""
    noise = ROUNDING * EPS * size
    depth_tolerance = 0.0 if is_polytope(pair.kind_A) and is_polytope(pair.kind_B) else tolerance
    difference = difference_of(pair)
    hulls = pair.kind_A == CONVEX and pair.kind_B == CONVEX
    if difference.last > 0:
        n = start_of_sums(difference, pair.p_AB, n, hinted)
        separation, newton = by_newton(difference, n, noise, SHARPER * tolerance, cutoff)
        end, upper, lower, n, a, b, _ = separation
        if end == BEYOND_CUTOFF:
            return Bounds(end, lower, upper, lower, n, a, b, 0.0, True, n)
        if end == CLOSED:
            distance = upper if lower > 0.0 else lower
            unique = lower > noise or is_strict(difference, n, noise)
            a, b, miss = drawn_to(distance, n, a, b)
            return Bounds(end, distance, upper, lower, n, a, b, miss, unique, n)
        overlap = lower < 0.0
    else:
        narrow, overlap = start_of_hulls(pair, n, hinted, noise)
        n, newton = narrow.n, nowhere(narrow.n)
        if hulls:
            newton = Minimum(NOTHING, narrow.n, narrow.width, 0.0)
    if overlap:  # expected, but certain only when a ball is in the difference
        # Not the literal True, for which Numba would compile all of EPA again.
        depth = depth_and_bounds(
            pair, difference, newton, overlap, size, SHARPER_DEPTH * depth_tolerance, memory
        )
        overlap = depth.lower > 0.0
        if overlap:
            return bounds_of_depth(pair, depth, size)
        if hulls and depth.upper < -noise:  # its normal separates them
            n = depth.n
    separation = distance_of_cores(pair, n, size, SHARPER * tolerance, cutoff)
    end, upper, lower, n, a, b, n_lower = separation
    near = upper <= NEAR_TOUCH * size or upper - lower > max(tolerance, noise)
    if end == BEYOND_CUTOFF:
        return Bounds(end, upper, upper, lower, n, a, b, 0.0, True, n)
    if end != OVERLAP and not near:
        if not has_its_digits(pair, difference, upper - lower, noise):
            sharper = sharpened(pair, difference, n, upper - lower, noise, SHARPER * tolerance)
            if sharper.end == CLOSED:
                _, distance, lower, n, a, b, _ = sharper
                a, b, miss = drawn_to(distance, n, a, b)
                return Bounds(CLOSED, distance, distance, lower, n, a, b, miss, True, n)
        if end == CLOSED or separation_along(pair, n) >= upper - max(tolerance, noise):
            return Bounds(CLOSED, upper, upper, lower, n, a, b, 0.0, True, n_lower)
    both = bounds_of_both(
        pair, difference, separation, overlap, size, depth_tolerance, noise, memory
    )
    return beside_an_axis(pair, difference, both, noise, tolerance)


@inlined
def bounds_along(pair: CorePair, n: Vector) -> Bounds:
    """Return the bounds from the support points along n."""
    a, b = support_points(pair, n, RIGHT_ANGLE)
    lower, upper = dot(sub(b, a), n), norm(sub(b, a))
    return Bounds(BEYOND_CUTOFF, lower, upper, lower, n, a, b, 0.0, True, n)


@inlined
def is_loose(bounds: Bounds, enough: float) -> bool:
    """Return whether the bounds of ``bounds_of_cores`` are far apart, or its points deviate."""
    return bounds.end != BEYOND_CUTOFF and width_of(bounds) > 4.0 * enough


@inlined
def width_of(bounds: Bounds) -> float:
    """Return the gap [m] of the bounds of ``bounds_of_cores``, or the deviation of its points."""
    return max(bounds.upper - bounds.lower, bounds.miss)


@inlined
def bounds_of_best_start(
    pair: CorePair,
    n: Vector,
    width: float,
    hinted: bool,
    size: float,
    tolerance: float,
    cutoff: float,
    memory: Floats,
) -> Bounds:
    """Return the bounds of the signed distance of two cores, from several starts if necessary.

    ``width`` [m] is that of their overlap along n.

    A bad hint, or the line of centres of a needle, can lead to bounds that are far apart. The
    normal of such bounds is usually a good hint.
    """
    noise = ROUNDING * EPS * size
    remembers = memory.size >= MEMORY_WIDTH and memory[0] > 0.0
    if remembers and is_where_it_was(memory, pair.p_AB, size):
        sure, depth = remembered_depth(pair, Overlap(width, n), memory, size, noise)
        if sure:
            return bounds_of_depth(pair, depth, size)
    best = bounds_of_cores(pair, n, hinted, size, tolerance, cutoff, memory)
    enough = max(tolerance, noise)
    for again in range(2):
        if not is_loose(best, enough):
            break
        cold = hinted and again == 0
        start = along_centres(pair.p_AB) if cold else best.n
        other = bounds_of_cores(pair, start, not cold, size, tolerance, cutoff, memory)
        if width_of(other) < width_of(best):
            best = other
    return best


@allocating
def proved_by_normal(
    pair: CorePair, bounds: Bounds, error_bound: float, size: float
) -> tuple[Vector, Vector, Vector, float]:
    """Return (n, a, b, error_bound): a slab along n proves the distance minus the error bound.

    So the answer itself is the proof. The vector b - a of bodies close together has few digits;
    the normal of the lower bound replaces it where that gives a smaller error bound.
    """
    n, a, b = bounds.n, bounds.a, bounds.b
    # A separation changes by no more than the pair's size times what its normal does.
    if bounds.distance - bounds.lower + norm(sub(n, bounds.n_lower)) * size <= error_bound:
        return n, a, b, error_bound
    lacking = bounds.distance - separation_along(pair, n)
    if not lacking > error_bound:  # also for NaN: a vanishing ellipsoid has no support point
        return n, a, b, error_bound
    a, b, miss = drawn_to(bounds.distance, bounds.n_lower, a, b)
    off = max(error_bound, bounds.distance - separation_along(pair, bounds.n_lower))
    if miss > off:
        off = max(off, off_surfaces(pair, bounds.n_lower, a, b, miss))
    if off < lacking:
        return bounds.n_lower, a, b, off
    return n, bounds.a, bounds.b, lacking + ROUNDING * EPS * size


@compiled
def signed_distance_of_cores(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of two convex shapes, given by type number and parameters."""
    r_A, r_B = core_radius(A.kind, A.shape), core_radius(B.kind, B.shape)
    p = (p_AB_W[0], p_AB_W[1], p_AB_W[2])
    size = bounding_radius(A.kind, A.shape) + bounding_radius(B.kind, B.shape) + norm(p)
    n, hinted = hint_of(out, p)
    noise = ROUNDING * EPS * size
    pair = CorePair(A.kind, A.shape, A.R_W, B.kind, B.shape, B.R_W, p)
    hulls = A.kind == CONVEX and B.kind == CONVEX
    memory = part(out, min(SLOT_WIDTH, out.size) if hulls else out.size, out.size)
    tolerance, cutoff = aim.tolerance, aim.cutoff + r_A + r_B
    bounds = bounds_along(pair, n)
    if not bounds.lower > cutoff:
        bounds = bounds_of_best_start(
            pair, n, -bounds.lower, hinted, size, tolerance, cutoff, memory
        )
    end, distance, upper, lower, n, a, b, miss, unique, _ = bounds
    method = ITERATIVE
    if end == BEYOND_CUTOFF:
        method, distance, b = BOUND_ONLY, lower, add_scaled(a, lower, n)
    if memory.size >= MEMORY_WIDTH and distance >= 0.0:
        memory[0] = 0.0
    error_bound = max(upper - distance, distance - lower) + noise
    if miss > error_bound:
        error_bound = max(error_bound, off_surfaces(pair, n, a, b, miss))
    if end != BEYOND_CUTOFF:
        n, a, b, error_bound = proved_by_normal(pair, bounds, error_bound, size)
    if A.kind == CONVEX:
        error_bound += hull_defect(A.shape)
    if B.kind == CONVEX:
        error_bound += hull_defect(B.shape)
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
