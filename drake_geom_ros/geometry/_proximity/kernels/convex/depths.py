"""Depth of two overlapping cores, by the cheapest method that certifies it.

The methods are tried in this order, each only if the previous one could not certify its answer:

1. ``remembered``, for two hulls;
2. ``revolution``, for parallel axes;
3. Newton's method (``normals``), whose minimum is proved by balls in both cores (``inner_balls``);
4. ``creases``, for a box or capsule in a cylinder;
5. ``epa`` with few vertices;
6. ``barrels`` and ``slices``, where a ring of directions is almost as good;
7. ``epa`` with many vertices;
8. ``axes``, in symmetric positions and where the difference has no volume.
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

# Limits of EPA's vertices. An ordinary minimum takes 8 to 40 vertices, a hard one 150. Allocating
# arrays of that size costs nothing; arrays ten times larger are returned to the system after each
# call, which costs as much as EPA. Only minima that are almost a ring, of shapes in a nearly
# symmetric position, reach the second limit, which leaves about 1e-6 of the size between bounds.
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
    """Return the depth of two cores, improved by common axes where its bounds are far apart.

    Bounds are far apart in symmetric positions and where the difference has no volume. ``newton``
    is the result of ``nearby_minimum`` for the difference, or only its direction; for two hulls it
    has the width along that. ``near``: the cores are expected to overlap. If hulls turn out to be
    separated, ``upper`` is below 0, and the search ends.
    """
    noise = ROUNDING * EPS * size
    iterated = iterated_depth(pair, difference, newton, near, size, tolerance, memory)
    hulls = pair.kind_A == CONVEX and pair.kind_B == CONVEX
    apart = hulls and near and iterated.upper < -noise
    if apart or iterated.upper - iterated.lower <= 4.0 * max(tolerance, noise):
        return iterated
    h, m, a, b = least_along_axes(pair, iterated.upper)
    if h >= iterated.upper:
        return iterated
    aside = norm(sub(sub(a, b), scale(h, m)))
    unique = iterated.unique and dot(m, iterated.n) >= SAME_DIRECTION
    return Depth(h, min(iterated.lower, h), m, a, b, aside, unique)


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
    """Return the depth of two cores, by the cheapest method that certifies it."""
    kind_A, kind_B, n = pair.kind_A, pair.kind_B, newton.n
    noise = ROUNDING * EPS * size
    if kind_A == CONVEX and kind_B == CONVEX:
        sure, core_depth = depth_of_hulls(pair, Overlap(newton.h, n), memory, size, noise)
        if sure or (near and core_depth.upper < -noise):
            return core_depth
    u, move = common_axis(pair)
    enough = max(tolerance, noise)
    if move <= 0.5 * enough:
        h, floor, n, a, b, aside, unique = depth_of_revolution(pair, u, move, size, tolerance)
        return Depth(h, guarded(difference, floor, noise), n, a, b, aside, unique)
    if newton.kind == NOTHING:  # it may converge from its last direction
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
    core_depth = depth_of_cores(pair, difference, n, near, size, tolerance, FEW_VERTICES)
    # With the origin on the surface of the difference, the bounds may be some tolerances apart.
    if core_depth.upper - core_depth.lower <= 4.0 * enough or core_depth.upper < -noise:
        return core_depth
    upper, lower, n, a, b, aside, unique = core_depth
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
    proved_lower = lower
    upper, lower, n, a, b, aside, unique = depth_of_cores(
        pair, difference, n, near, size, tolerance, MANY_VERTICES
    )
    # For a small body near the centre of a large one, the polytope's bound is the coarser one.
    return Depth(upper, min(max(lower, proved_lower), upper), n, a, b, aside, unique)


@compiled
def guarded(difference: Difference, floor: float, noise: float) -> float:
    """Return a lower bound of h [m], checked by a plane that the search did not choose.

    A search over candidates is valid only if their set is complete. If the width along another
    plane is less, the set was not complete, and that width is the bound. The answer is then wider
    than promised, and counted as such.
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
    least = Least(False, h, floor, n, False)
    barrel = kind_A == CAPSULE or kind_A == CYLINDER
    if kind_B == CONVEX:
        return least_of_hull_in_barrel(pair, enough, noise) if barrel else least
    if barrel:
        least = least_in_long_barrel(difference, SEGMENT, AXES_A, n, h, enough, noise)
    if not least.complete and kind_B == CYLINDER:
        least = least_in_long_barrel(difference, difference.first, AXES_B, n, h, enough, noise)
    if not least.complete and kind_A == CYLINDER and kind_B == CYLINDER:
        least = least_of_barrels(difference, n, floor, enough, noise)
    # A box is excluded because it has edges off the axis.
    if not least.complete and kind_A != BOX and kind_B == ELLIPSOID:
        least = least_over_slices(difference, n, h, enough, noise)
    return least


@compiled
def settled(
    difference: Difference, n: Vector, h: float, noise: float
) -> tuple[Vector, Vector, float]:
    """Return (a, b, aside): points of the cores with ``a - b = h n`` up to ``aside`` [m]."""
    settle(difference, n)
    a, b = witness_points(difference, n)
    aside = norm(sub(sub(a, b), scale(h, n)))
    settle_by_turns(difference, n, noise)
    x, y = witness_points(difference, n)
    aside_by_turns = norm(sub(sub(x, y), scale(h, n)))
    return (x, y, aside_by_turns) if aside_by_turns < aside else (a, b, aside)


@compiled
def points_at(difference: Difference, n: Vector, h: float, enough: float, noise: float) -> Touch:
    """Return the witness points (``Touch``) at a normal n of least width h.

    The points deviate only by rounding where Newton's method converges. Where segments are almost
    parallel, n may be on the crease of one and the points on that of the other, which is as good
    up to a fraction of ``enough`` [m].
    """
    terms, _, last, r_A, r_B = difference
    newton = nearby_minimum(difference, n, noise)
    if newton.kind != NOTHING:
        # Where h is almost level, n may be off by far more than h.
        if abs(newton.h - h) <= noise:
            n, h = newton.n, newton.h
        a, b = witness_points(difference, n)
        return Touch(n, h, a, b, norm(sub(sub(a, b), scale(h, n))))
    a, b, aside = settled(difference, n, h, noise)
    best = Touch(n, h, a, b, aside)
    for k in range(SEGMENT, last):
        if best.aside > LOOSE_SLOPE * noise:
            m = across(n, scale(1.0 / terms[k, LENGTH], vector_in(terms, k)))
            width_there = width(terms, last, r_A + r_B, m)
            # For n along the segment itself there is no such direction, and m is 0.
            if dot(m, m) > 0.5 and width_there <= h + 0.5 * enough:
                a, b, aside = settled(difference, m, width_there, noise)
                if aside < best.aside:
                    best = Touch(m, width_there, a, b, aside)
    return best


@allocating
def points_on_edges(pair: CorePair, n: Vector, h: float, enough: float, noise: float) -> Touch:
    """Return the ``Touch`` of two hulls, by ``points_at`` of their edges next to n.

    The edges are parts of the hulls, so their h is at most that of the hulls, which counts.
    """
    m, _, a, b, _ = points_at(difference_of_edges(pair, n), n, h, enough, noise)
    x, y = support_points(pair, m, 0.0)
    hull_width = dot(sub(x, y), m)
    if hull_width <= h + noise:
        return Touch(m, hull_width, a, b, norm(sub(sub(a, b), scale(hull_width, m))))
    a, b, aside = settled(difference_of_edges(pair, n), n, h, noise)
    return Touch(n, h, a, b, aside)
