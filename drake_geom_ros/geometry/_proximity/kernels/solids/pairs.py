"""Signed distance of a core or a solid from a solid: one kernel for every row with a solid.

A solid is the closed body that a mesh bounds, dents, holes and cavities and all. Apart, the answer
is the distance of the surfaces (``distance``), as exact as that of two cores. Overlapping, it is
minus the length of a translation that is verified to separate, and ``error_bound`` is how much
shorter the shortest may be (``overlap``); the method is OPEN where this is much. Where surfaces
do not cross, triangles that touch decide, and one of each piece (``containment``); where these may
be in each other by less than rounding, the error bound includes both cases.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    NORMAL,
    Aim,
    OrientedShape,
    write,
)
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import (
    bounding_radius,
    core_radius,
    local_support,
)
from drake_geom_ros.geometry._proximity.kernels.solids.coarse import coarse_nearest
from drake_geom_ros.geometry._proximity.kernels.solids.containment import (
    APART,
    MAY_OVERLAP,
    OVERLAPS,
    stand_of,
    touch_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.distance import NEVER, Nearest, nearest
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import hull_support
from drake_geom_ros.geometry._proximity.kernels.solids.overlap import (
    BACK_OFF,
    bounds_of_depth,
    certain_separating_move,
)
from drake_geom_ros.geometry._proximity.kernels.solids.reach import nearest_within
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    SolidPair,
    body_of,
    noise_of,
    solid_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.touching import (
    MOST_WAYS,
    WAY_WIDTH,
    contact_of,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, CONVEX, MESH, OPEN, SPHERE
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled

MOST_ASIDE = 64.0  # roundings that bodies which touch may have to be moved to be apart
OPEN_SHARE = 0.1  # of a depth [-] that the least translation may be less by: more leaves it open
LOOSE = 4.0 * BACK_OFF  # roundings that a depth may be off by all the same


@compiled
def first_direction(out: Floats, R_WB: Floats, p: Vector) -> Vector:
    """Return the unit n out of A by the hint in a result row, in B's axes, else towards Bo."""
    n = unit((-out[NORMAL], -out[NORMAL + 1], -out[NORMAL + 2]))
    if dot(n, n) > 0.5:
        return unrotate(R_WB, n)
    n = unit(scale(-1.0, p))
    return n if dot(n, n) > 0.5 else (1.0, 0.0, 0.0)


class Answer(NamedTuple):
    """The contents of a result row, in B: m out of B, points a and b from Bo."""

    m: Vector
    a: Vector
    b: Vector
    distance: float
    error: float
    unique: bool
    method: int


@compiled
def write_row(out: Floats, R_WB: Floats, p: Vector, answer: Answer) -> None:
    """Fill the row with an answer about A, whose origin is at p."""
    write(
        out,
        answer.distance,
        rotate(R_WB, answer.m),
        rotate(R_WB, sub(answer.a, p)),
        rotate(R_WB, sub(answer.b, p)),
        answer.error,
        answer.unique,
        answer.method,
    )


@compiled
def beyond(pair: SolidPair, n: Vector, lower: float) -> Answer:
    """Return the answer about a pair farther apart than ``lower``, which is beyond the cutoff."""
    a = add_scaled(add(pair.p, hull_support(pair.A, n)), pair.radius, n)
    upper = norm(sub(local_support(CONVEX, pair.B.shape, scale(-1.0, n), 0.0), a))
    b = add_scaled(a, lower, n)
    error = max(upper - lower, 0.0) + noise_of(pair)
    return Answer(scale(-1.0, n), a, b, lower, error, True, BOUND_ONLY)


@compiled
def overlap(pair: SolidPair, closest: Nearest, accuracy: float) -> Answer:
    """Return the answer about a pair that overlaps, to an accuracy [m] if the search finds it."""
    (depth, least, t, b), alone = bounds_of_depth(pair, closest, accuracy)
    noise, tolerance = noise_of(pair), pair.tolerance
    m, unique = unit(t), alone and depth - least <= tolerance + LOOSE * noise
    depth = max(depth - BACK_OFF * noise, 0.0)
    error = max(depth - least, 0.0) + (1.0 + BACK_OFF) * noise
    method = OPEN if depth - least > max(OPEN_SHARE * depth, tolerance + LOOSE * noise) else MESH
    return Answer(m, add_scaled(b, -depth, m), b, -depth, error, unique, method)


@compiled
def separation(pair: SolidPair, closest: Nearest, more: float) -> Answer:
    """Return the answer about a pair that is apart, or overlaps by no more than ``more`` [m]."""
    noise, radius, n = noise_of(pair), pair.radius, closest.n
    distance = closest.upper - radius
    a = add_scaled(closest.a, radius, n)
    b = add_scaled(a, distance, n)
    error = max(closest.upper - closest.lower, 0.0) + noise + more
    return Answer(scale(-1.0, n), a, b, distance, error, closest.unique, MESH)


@compiled
def contact(pair: SolidPair, closest: Nearest, ways: Floats, count: int) -> Answer:
    """Return the answer about a pair that touches and, to rounding, may overlap.

    Where a move by some roundings separates it, the answer is a touch, else an OPEN depth. The
    tolerance of a level never makes a touch of an overlap, for ``plain_overlap`` would see it all
    the same. The upper end is no less than the distance of the nearest points.
    """
    depth, t, b = certain_separating_move(pair, closest, ways, count)
    noise = noise_of(pair)
    if depth <= MOST_ASIDE * noise:
        return separation(pair, contact_of(pair, closest, ways, count), depth)
    m, depth = unit(t), depth - BACK_OFF * noise
    a = add_scaled(b, -depth, m)
    error = depth + max(closest.upper - pair.radius, 0.0) + (1.0 + BACK_OFF) * noise
    return Answer(m, a, b, -depth, error, False, OPEN)


@compiled
def point(pair: SolidPair, closest: Nearest, stand: int) -> Answer:
    """Return the answer about a point: it is out where the surface is nearest."""
    n, noise = closest.n, noise_of(pair)
    if stand == OVERLAPS:
        return Answer(n, closest.a, closest.b, -closest.lower, noise, closest.unique, MESH)
    answer = separation(pair, closest, 0.0)
    if stand == APART:
        return answer
    error = answer.error + 2.0 * closest.upper  # it may be on the other side
    return Answer(answer.m, answer.a, answer.b, answer.distance, error, answer.unique, MESH)


@allocating
def answer_of(pair: SolidPair, n: Vector, cutoff: float, accuracy: float) -> Answer:
    """Return the answer about a pair, a bound alone if it is beyond the cutoff [m].

    The ``accuracy`` [m] is that of depths.
    """
    noise, radius = noise_of(pair), pair.radius
    closest = nearest_within(pair, n, max(cutoff, 0.0) + radius + noise, touch_of(pair))
    ways = np.empty((MOST_WAYS, WAY_WIDTH))
    stand, count = stand_of(pair, closest, ways)
    if stand == MAY_OVERLAP and closest.upper - closest.lower > noise:
        # The tolerance of the level hides whether they overlap: only rounding may.
        pair = SolidPair(pair.A, pair.B, pair.p, pair.size, noise, radius)
        closest = nearest(pair, n, math.inf, touch_of(pair))
        stand, count = stand_of(pair, closest, ways)
    if stand == OVERLAPS and closest.end == BEYOND_CUTOFF:
        closest = nearest(pair, n, math.inf, NEVER)
    if pair.A.kind == SPHERE and radius == 0.0 and closest.end != BEYOND_CUTOFF:
        return point(pair, closest, stand)
    if stand == OVERLAPS:
        return overlap(pair, closest, accuracy)
    if closest.end == BEYOND_CUTOFF:
        return beyond(pair, closest.n, closest.lower - radius - noise)
    if stand == MAY_OVERLAP:
        return contact(pair, closest, ways, count)
    return separation(pair, contact_of(pair, closest, ways, count), 0.0)


@allocating
def answer_to(pair: SolidPair, n: Vector, cutoff: float, accuracy: float) -> Answer:
    """Return the answer about a pair to an accuracy [m], 0 for that of the pair's tolerance.

    Where it is not shown that the bodies are apart, ``exact`` answers about their distance, and
    its bound is as wide as that of coins at least: a larger accuracy has no narrower one.
    """
    coarse = coarse_nearest(pair, n, accuracy)
    if coarse.is_apart:
        return separation(pair, coarse.closest, 0.0)
    answer = answer_of(pair, n, cutoff, accuracy)
    if answer.distance <= 0.0 or answer.method != MESH:
        return answer
    m, a, b, distance, error, unique, method = answer
    return Answer(m, a, b, distance, max(error, 0.5 * coarse.length), unique, method)


@allocating
def posed_pair(
    shaped_A: OrientedShape, shaped_B: OrientedShape, p_AB_W: Floats, tolerance: float
) -> SolidPair:
    """Return any bounded shape and a solid in their relative pose, in the solid's frame."""
    kind_A, shape_A, R_WA = shaped_A
    kind_B, shape_B, R_WB = shaped_B
    p = scale(-1.0, unrotate(R_WB, vector_at(p_AB_W, 0)))
    size = bounding_radius(kind_A, shape_A) + bounding_radius(kind_B, shape_B) + norm(p)
    R = np.empty((3, 3))
    for j in range(3):
        R[0, j], R[1, j], R[2, j] = unrotate(R_WB, (R_WA[0, j], R_WA[1, j], R_WA[2, j]))
    A, B = body_of(kind_A, shape_A, R), solid_of(shape_B)
    return SolidPair(A, B, p, size, tolerance, core_radius(kind_A, shape_A))


@allocating
def signed_distance_to_solid(
    shaped_A: OrientedShape, shaped_B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the result row of any bounded shape and a solid."""
    pair, R_WB = posed_pair(shaped_A, shaped_B, p_AB_W, aim.tolerance), shaped_B.R_W
    n = first_direction(out, R_WB, pair.p)
    write_row(out, R_WB, pair.p, answer_to(pair, n, aim.cutoff, aim.accuracy))
