"""Depth of two overlapping cores, by the cheapest way that is certain.

In this order, each only where the one before could not certify its answer: ``remembered`` for two
hulls; ``revolution`` for parallel axes; Newton's method (``normals``), whose minimum is proven by
balls within both cores (``inner_balls``); ``creases`` for a box or capsule in a cylinder; ``epa``
with few vertices; ``barrels`` and ``slices`` where a ring of directions is almost as good; ``epa``
with many. What is left open then, in symmetric positions and where the difference has no volume,
``axes`` may close.
"""

from drake_geom_ros.geometry._proximity.kernels.cores.axes import least_along_axes
from drake_geom_ros.geometry._proximity.kernels.cores.epa import depth_of_cores, guarded_hulls
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import support_points
from drake_geom_ros.geometry._proximity.kernels.cores.inner_balls import (
    deepest,
    depth_between,
)
from drake_geom_ros.geometry._proximity.kernels.cores.normals import (
    NOTHING,
    nearby_minimum,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import (
    CorePair,
    Depth,
    Difference,
    Least,
    Minimum,
    Overlap,
    Touch,
)
from drake_geom_ros.geometry._proximity.kernels.cores.remembered import depth_of_hulls
from drake_geom_ros.geometry._proximity.kernels.cores.settling import settle, settle_by_turns
from drake_geom_ros.geometry._proximity.kernels.cores.sums import (
    AXES_A,
    AXES_B,
    LENGTH,
    SEGMENT,
    difference_of_edges,
    likely_normal,
    share_a_point,
    width,
    witness_points,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.barrels import (
    least_in_long_barrel,
    least_of_barrels,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.circles import across
from drake_geom_ros.geometry._proximity.kernels.revolution.creases import least_on_creases
from drake_geom_ros.geometry._proximity.kernels.revolution.revolution import (
    common_axis,
    depth_of_revolution,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.rings import (
    least_of_hull_in_barrel,
)
from drake_geom_ros.geometry._proximity.kernels.revolution.slices import least_over_slices
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    dot,
    norm,
    scale,
    sub,
    unit,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    LOOSE_SLOPE,
    ROUNDING,
    SAME_DIRECTION,
)

# Caps of EPA. An ordinary minimum takes 8 to 40 vertices, a hard one 150, and arrays of that size
# cost nothing to get: ten times larger ones go back to the system after each call, which
# costs as much as EPA does. Only minima that are almost a ring, of shapes almost in a symmetric
# position, get to the second cap, which leaves about 1e-6 of the size between the bounds.
FEW_VERTICES = 160
MANY_VERTICES = 3000


@compiled
def depth_and_bounds(
    pair: CorePair,
    difference: Difference,
    newton: Minimum,
    near: bool,
    size: float,
    tolerance: float,
    memory: Floats,
) -> Depth:
    """Return the depth of two cores; where its bounds are far apart, axes may do better.

    That is the case in symmetric positions and where the difference has no volume. ``newton`` is
    what ``nearby_minimum`` of the difference has just found, or its direction alone; of two hulls
    it has the width along that. ``near`` tells that cores are thought to overlap: if hulls turn
    out not to, ``upper`` is below 0, and nothing else is looked for.
    """
    noise = ROUNDING * EPS * size
    found = iterated_depth(pair, difference, newton, near, size, tolerance, memory)
    hulls = pair.kind_A == CONVEX and pair.kind_B == CONVEX
    apart = hulls and near and found.upper < -noise
    if apart or found.upper - found.lower <= 4.0 * max(tolerance, noise):
        return found
    h, m, a, b = least_along_axes(pair, found.upper)
    if h >= found.upper:
        return found
    aside = norm(sub(sub(a, b), scale(h, m)))
    unique = found.unique and dot(m, found.n) >= SAME_DIRECTION
    return Depth(h, min(found.lower, h), m, a, b, aside, unique)


@compiled
def iterated_depth(
    pair: CorePair,
    difference: Difference,
    newton: Minimum,
    near: bool,
    size: float,
    tolerance: float,
    memory: Floats,
) -> Depth:
    """Return the depth of two cores, by the cheapest way there is for the pair."""
    kind_A, kind_B, n = pair.kind_A, pair.kind_B, newton.n
    noise = ROUNDING * EPS * size
    if kind_A == CONVEX and kind_B == CONVEX:
        sure, found = depth_of_hulls(pair, Overlap(newton.h, n), memory, size, noise)
        if sure or (near and found.upper < -noise):
            return found
    u, move = common_axis(pair)
    enough = max(tolerance, noise)
    if move <= 0.5 * enough:
        h, floor, n, a, b, aside, unique = depth_of_revolution(pair, u, move, size, tolerance)
        return Depth(h, guarded(difference, floor, noise), n, a, b, aside, unique)
    if newton.kind == NOTHING:  # from where that came to an end it may get on
        newton = nearby_minimum(difference, n, noise)
    if newton.kind != NOTHING and newton.h > 0.0:
        a, b = witness_points(difference, newton.n)
        depth, unique, _ = depth_between(pair, a, b, enough)
        if unique and newton.h - depth <= enough:
            return Depth(newton.h, min(depth, newton.h) - noise, newton.n, a, b, 0.0, True)
    if (kind_A == BOX or kind_A == CAPSULE) and kind_B == CYLINDER:
        complete, h, floor, n, unique = least_on_creases(difference, newton, enough, noise)
        if complete and h > 0.0:
            n, h, a, b, aside = points_at(difference, n, h, enough, noise)
            if share_a_point(pair, a, b):
                return Depth(h, floor, n, a, b, aside, unique)
    found = depth_of_cores(pair, difference, n, near, size, tolerance, FEW_VERTICES)
    # Where the difference has the origin on its surface the bounds add up to some tolerances.
    if found.upper - found.lower <= 4.0 * enough or found.upper < -noise:
        return found
    upper, lower, n, a, b, aside, unique = found
    lower = max(lower, deepest(pair, a, b, size) - noise)
    if upper - lower <= 4.0 * enough:
        return Depth(upper, min(lower, upper), n, a, b, aside, unique)
    if lower > 0.0:
        hulls = difference.last == 0
        complete, h, floor, m, unique = least_of_ring(
            pair, difference, n, upper, lower, enough, noise
        )
        complete = complete and h >= lower - noise  # two proofs that contradict prove nothing
        if complete and hulls:
            m, h, a, b, aside = points_on_edges(pair, m, h, enough, noise)
            return guarded_hulls(pair, Depth(h, min(floor, h), m, a, b, aside, unique), noise)
        if complete:
            m, h, a, b, aside = points_at(difference, m, h, enough, noise)
            return Depth(h, guarded(difference, min(floor, h), noise), m, a, b, aside, unique)
    known = lower
    upper, lower, n, a, b, aside, unique = depth_of_cores(
        pair, difference, n, near, size, tolerance, MANY_VERTICES
    )
    # Of a small body near the centre of a large one the polytope is the coarser of the two.
    return Depth(upper, min(max(lower, known), upper), n, a, b, aside, unique)


@compiled
def guarded(difference: Difference, floor: float, noise: float) -> float:
    """Return what no h is below, [m], after a look at planes that a search did not choose.

    A search over candidates is right where their set is complete. Any plane may show that it was
    not: then its width is the bound, which so is wider than promised, and counted as such.
    """
    terms, _, last, r_A, r_B = difference
    across = unit(vector_in(terms, 0))
    n = likely_normal(difference, across if dot(across, across) > 0.5 else (1.0, 0.0, 0.0))
    least = width(terms, last, r_A + r_B, n)
    return least if least < floor - noise else floor


@compiled
def least_of_ring(
    pair: CorePair,
    difference: Difference,
    n: Vector,
    h: float,
    floor: float,
    enough: float,
    noise: float,
) -> Least:
    """Return the least h where a ring of directions is almost as good as n."""
    kind_A, kind_B = pair.kind_A, pair.kind_B
    found = Least(False, h, floor, n, False)
    barrel = kind_A == CAPSULE or kind_A == CYLINDER
    if kind_B == CONVEX:
        return least_of_hull_in_barrel(pair, enough, noise) if barrel else found
    if barrel:
        found = least_in_long_barrel(difference, SEGMENT, AXES_A, n, h, enough, noise)
    if not found.complete and kind_B == CYLINDER:
        found = least_in_long_barrel(difference, difference.first, AXES_B, n, h, enough, noise)
    if not found.complete and kind_A == CYLINDER and kind_B == CYLINDER:
        found = least_of_barrels(difference, n, floor, enough, noise)
    # A box has edges off the axis.
    if not found.complete and kind_A != BOX and kind_B == ELLIPSOID:
        found = least_over_slices(difference, n, h, enough, noise)
    return found


@compiled
def settled(
    difference: Difference, n: Vector, h: float, noise: float
) -> tuple[Vector, Vector, float]:
    """Return (a, b, aside): points of the cores with ``a - b = h n`` but for ``aside`` [m]."""
    settle(difference, n)
    a, b = witness_points(difference, n)
    aside = norm(sub(sub(a, b), scale(h, n)))
    settle_by_turns(difference, n, noise)
    x, y = witness_points(difference, n)
    aside_by_turns = norm(sub(sub(x, y), scale(h, n)))
    return (x, y, aside_by_turns) if aside_by_turns < aside else (a, b, aside)


@compiled
def points_at(difference: Difference, n: Vector, h: float, enough: float, noise: float) -> Touch:
    """Return the ``Touch`` at a normal n of least width h.

    Its points are aside by rounding where Newton's method knows the minimum. Where segments are
    almost parallel, n may be on the crease of one and the points on that of the other, which is
    as good but for a part of ``enough`` [m].
    """
    terms, _, last, r_A, r_B = difference
    newton = nearby_minimum(difference, n, noise)
    if newton.kind != NOTHING:
        # Where h is almost level, n may be off by far more than its h.
        if abs(newton.h - h) <= noise:
            n, h = newton.n, newton.h
        a, b = witness_points(difference, n)
        return Touch(n, h, a, b, norm(sub(sub(a, b), scale(h, n))))
    a, b, aside = settled(difference, n, h, noise)
    best = Touch(n, h, a, b, aside)
    for k in range(SEGMENT, last):
        if best.aside > LOOSE_SLOPE * noise:
            m = across(n, scale(1.0 / terms[k, LENGTH], vector_in(terms, k)))
            there = width(terms, last, r_A + r_B, m)
            # Along the segment itself there is no such direction, and m is 0.
            if dot(m, m) > 0.5 and there <= h + 0.5 * enough:
                a, b, aside = settled(difference, m, there, noise)
                if aside < best.aside:
                    best = Touch(m, there, a, b, aside)
    return best


@allocating
def points_on_edges(pair: CorePair, n: Vector, h: float, enough: float, noise: float) -> Touch:
    """Return what ``points_at`` does of hulls, by their edges next to n.

    The edges are in the hulls, so their h is at most that of these, which counts.
    """
    m, _, a, b, _ = points_at(difference_of_edges(pair, n), n, h, enough, noise)
    x, y = support_points(pair, m, 0.0)
    there = dot(sub(x, y), m)
    if there <= h + noise:
        return Touch(m, there, a, b, norm(sub(sub(a, b), scale(there, m))))
    a, b, aside = settled(difference_of_edges(pair, n), n, h, noise)
    return Touch(n, h, a, b, aside)
