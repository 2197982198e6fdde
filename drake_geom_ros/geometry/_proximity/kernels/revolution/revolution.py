"""Depth of two bodies of revolution with parallel axes, as a planar problem.

Coaxial cylinders, capsules and spheroids have rings of equally good directions. EPA would have to
cover the whole ring with faces to certify one of them. But the Minkowski difference is a body of
revolution, too, so a nearest point of its surface lies in the half plane through its axis and the
origin, and there EPA's polygon has corners on one arc only.

The quarter of that half plane with both components positive suffices: the width is ``h = f(s, c)
- p . n``, with f even in s and c, so of all n with the same s and c and their mirror images, the
one towards p is least. Every arc of the quarter between two corners is retained with the lower
bound of its chord (``set_chord``). None is excluded by a comparison, and the least of these bounds
is returned.

Almost parallel axes, and an ellipsoid with two almost equal semi-axes, are included if rotating
the one and rounding the other moves no point farther than the tolerance. The move is subtracted
from the lower bound; the upper bound is computed from the actual shapes.

Where the origin is on the axis and all directions about it are equally good, the normal out of B
is the one nearest to the x axis of B.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import support_points
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Depth
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import (
    bounding_radius,
    core_radius,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    column,
    cross,
    dot,
    norm,
    scale,
    sub,
    unit,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_LENGTH,
    SHAPE_RADIUS,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Integers32, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import (
    COPLANAR,
    EPS,
    ROUNDING,
    SAME_DIRECTION,
)

MOST_CORNERS = 64  # a corner halves its arc, and an arc of 1e-8 is flat to rounding
# Columns of a corner: direction, point, width along the direction; then the normal of the chord to
# the next corner, and the lower bound of widths over its arc.
SINE, COSINE, RADIAL, AXIAL, WIDTH, CHORD_SINE, CHORD_COSINE, CHORD_WIDTH = range(8)
CORNER_WIDTH = 8
OFF_AXIS = math.sqrt(1.0 - SAME_DIRECTION**2)  # sine of a clearly different angle


class Planar(NamedTuple):
    """A point in a half plane through the axis [m]."""

    radial: float
    axial: float


@compiled
def axis_of_revolution(kind: int, shape: Floats) -> tuple[int, float]:
    """Return (k, move): the axis of the core, and the deviation [m] from a body of revolution.

    ``move`` is infinite for shapes without an axis.
    """
    if kind == BOX or kind == CONVEX:
        return 2, np.inf
    if kind != ELLIPSOID:
        return 2, 0.0
    ab, bc, ca = (
        abs(shape[0] - shape[1]),
        abs(shape[1] - shape[2]),
        abs(shape[2] - shape[0]),
    )
    if ab <= bc and ab <= ca:
        return 2, ab
    if bc <= ca:
        return 0, bc
    return 1, ca


@compiled
def common_axis(pair: CorePair) -> tuple[Vector, float]:
    """Return (u, move): a common axis of both cores if their surfaces move by ``move`` [m].

    The smaller core is rotated; the core of a ball, a point, has any axis.
    """
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, _ = pair
    k_A, move_A = axis_of_revolution(kind_A, shape_A)
    k_B, move_B = axis_of_revolution(kind_B, shape_B)
    u_A, u_B = column(R_WA, k_A), column(R_WB, k_B)
    if move_A + move_B == np.inf:
        return u_A, np.inf  # early, since the radius of a hull may need every vertex
    reach_A = bounding_radius(kind_A, shape_A) - core_radius(kind_A, shape_A)
    reach_B = bounding_radius(kind_B, shape_B) - core_radius(kind_B, shape_B)
    move = move_A + move_B + 2.0 * norm(cross(u_A, u_B)) * min(reach_A, reach_B)
    return u_B if reach_A < reach_B else u_A, move


@compiled
def profile(kind: int, shape: Floats, s: float, c: float) -> Planar:
    """Return the point of the core's profile with the normal (s, c), both >= 0."""
    if kind == CAPSULE:
        return Planar(0.0, shape[HALF_LENGTH])
    if kind == CYLINDER:
        return Planar(shape[SHAPE_RADIUS], shape[HALF_LENGTH])
    if kind != ELLIPSOID:
        return Planar(0.0, 0.0)
    k, _ = axis_of_revolution(kind, shape)
    x, z = 0.5 * (shape[(k + 1) % 3] + shape[(k + 2) % 3]), shape[k]
    h = math.sqrt((x * s) * (x * s) + (z * c) * (z * c))
    r = core_radius(kind, shape)
    return Planar(s * (x * (x / h) - r), c * (z * (z / h) - r))


@compiled
def put_corner(
    corners: Floats, k: int, pair: CorePair, radial: float, axial: float, s: float, c: float
) -> None:
    """Store direction, point of the difference and width along (s, c) in row k."""
    a, b = profile(pair.kind_A, pair.shape_A, s, c), profile(pair.kind_B, pair.shape_B, s, c)
    x, z = a.radial + b.radial - radial, a.axial + b.axial - axial
    corners[k, SINE], corners[k, COSINE] = s, c
    corners[k, RADIAL], corners[k, AXIAL] = x, z
    corners[k, WIDTH] = s * x + c * z


@compiled
def set_chord(corners: Floats, k: int, following: int) -> None:
    """Store the normal of the chord from corner k to the following one, and the width along it.

    Widths in between are at least the larger of those of the two points. Both are sinusoids,
    concave where positive, so the least is at an end of the arc or where they cross: at the normal
    of the chord, if it is within the arc. Otherwise the width of the chord is infinite.
    """
    x = corners[k, RADIAL] - corners[following, RADIAL]
    y = corners[following, AXIAL] - corners[k, AXIAL]
    length = math.sqrt(x * x + y * y)
    corners[k, CHORD_WIDTH] = np.inf
    if x > 0.0 and y > 0.0:
        s, c = y / length, x / length
        corners[k, CHORD_SINE], corners[k, CHORD_COSINE] = s, c
        corners[k, CHORD_WIDTH] = min(
            s * corners[k, RADIAL] + c * corners[k, AXIAL],
            s * corners[following, RADIAL] + c * corners[following, AXIAL],
        )


@compiled
def touching_points(
    corners: Floats, after: Integers32, best: int, pair: CorePair, radial: float, axial: float
) -> tuple[Planar, Planar]:
    """Return a point of each profile such that both touch along the best normal.

    The best corner's points deviate by ``aside``. Its neighbour on the other side deviates with
    the opposite sign; at the ends of the quarter, the neighbour is its own mirror image.
    """
    s, c = corners[best, SINE], corners[best, COSINE]
    aside = s * corners[best, AXIAL] - c * corners[best, RADIAL]
    other, mirror_radial, mirror_axial = best, 1.0, 1.0
    if aside < 0.0 and after[best] >= 0:
        other = after[best]
    elif aside < 0.0:
        mirror_radial = -1.0
    elif best == 0:
        mirror_axial = -1.0
    else:
        other = 0
        while after[other] != best:
            other = after[other]
    a, b = profile(pair.kind_A, pair.shape_A, s, c), profile(pair.kind_B, pair.shape_B, s, c)
    s_, c_ = corners[other, SINE], corners[other, COSINE]
    a_, b_ = profile(pair.kind_A, pair.shape_A, s_, c_), profile(pair.kind_B, pair.shape_B, s_, c_)
    a_ = Planar(mirror_radial * a_.radial, mirror_axial * a_.axial)
    b_ = Planar(mirror_radial * b_.radial, mirror_axial * b_.axial)
    aside_ = s * (a_.axial + b_.axial - axial) - c * (a_.radial + b_.radial - radial)
    t = 0.0 if aside == aside_ else min(max(aside / (aside - aside_), 0.0), 1.0)
    return (
        Planar(a.radial + t * (a_.radial - a.radial), a.axial + t * (a_.axial - a.axial)),
        Planar(
            radial - b.radial - t * (b_.radial - b.radial),
            axial - b.axial - t * (b_.axial - b.axial),
        ),
    )


class PlanarDepth(NamedTuple):
    """The least width over the directions (s, c) of a quarter, with its points a and b.

    No width is below ``lower`` [m]. ``unique``: no clearly different direction of the quarter is
    as good.
    """

    lower: float
    s: float
    c: float
    a: Planar
    b: Planar
    unique: bool


@allocating
def planar_depth(
    pair: CorePair, radial: float, axial: float, enough: float, noise: float
) -> PlanarDepth:
    """Return the least width over directions s, c >= 0."""
    corners = np.empty((MOST_CORNERS, CORNER_WIDTH))
    after = np.empty(MOST_CORNERS, dtype=np.int32)
    put_corner(corners, 0, pair, radial, axial, 1.0, 0.0)
    put_corner(corners, 1, pair, radial, axial, 0.0, 1.0)
    after[0], after[1], count = 1, -1, 2
    set_chord(corners, 0, 1)
    best = 0 if corners[0, WIDTH] <= corners[1, WIDTH] else 1
    arc, lower = 0, min(corners[best, WIDTH], corners[0, CHORD_WIDTH])
    while corners[best, WIDTH] - lower > enough and count < MOST_CORNERS:
        s, c = corners[arc, CHORD_SINE], corners[arc, CHORD_COSINE]
        put_corner(corners, count, pair, radial, axial, s, c)
        after[count] = after[arc]
        after[arc] = count
        set_chord(corners, arc, count)
        set_chord(corners, count, after[count])
        if corners[count, WIDTH] < corners[best, WIDTH] - noise:
            best = count
        count += 1
        lower = corners[best, WIDTH]
        for k in range(count):
            if after[k] >= 0 and corners[k, CHORD_WIDTH] < lower:
                arc, lower = k, corners[k, CHORD_WIDTH]
    s, c, rival = corners[best, SINE], corners[best, COSINE], corners[best, WIDTH] + enough
    unique = True
    for k in range(count):
        if after[k] >= 0 and corners[k, CHORD_WIDTH] <= rival:
            cosine = corners[k, CHORD_SINE] * s + corners[k, CHORD_COSINE] * c
            unique = unique and cosine >= SAME_DIRECTION
        if corners[k, WIDTH] <= rival:
            cosine = corners[k, SINE] * s + corners[k, COSINE] * c
            unique = unique and cosine >= SAME_DIRECTION
    a, b = touching_points(corners, after, best, pair, radial, axial)
    return PlanarDepth(lower, s, c, a, b, unique)


@compiled
def depth_of_revolution(
    pair: CorePair, u: Vector, move: float, size: float, tolerance: float
) -> Depth:
    """Return the depth of two bodies of revolution about the common axis u."""
    enough = max(0.5 * tolerance, ROUNDING * EPS * size)
    u = unit(u)  # orientations are rotations only within rounding
    axial = dot(pair.p_AB, u)
    if axial < 0.0:
        axial, u = -axial, scale(-1.0, u)
    across = add_scaled(pair.p_AB, -axial, u)
    radial = norm(across)
    e = unit(across)
    e = unit(add_scaled(e, -dot(e, u), u))
    if radial <= 4.0 * EPS * size:  # rounding only: all directions about the axis are equal
        side = cross(u, column(pair.R_WB, 0))
        e = unit(cross(u, side if norm(side) > 0.5 else cross(u, column(pair.R_WB, 1))))
        radial = 0.0
    lower, s, c, at_A, at_B, unique = planar_depth(
        pair, radial, axial, enough, COPLANAR * EPS * size
    )
    n = unit(add_scaled(scale(s, e), c, u))
    s_A, s_B = support_points(pair, n, 0.0)
    upper = dot(sub(s_A, s_B), n)
    a = add_scaled(scale(at_A.radial, e), at_A.axial, u)
    b = add_scaled(scale(at_B.radial, e), at_B.axial, u)
    lower = (lower if lower > 0.0 else -norm(sub(a, b))) - move
    rise = dot(sub(s_A, a), n) + dot(sub(s_B, b), n)
    # Where h is level along the quarter, the points of the best corner deviate sideways.
    apart = sub(a, b)
    aside = norm(add_scaled(apart, -dot(apart, n), n))
    centre = scale(0.5, add_scaled(add(a, b), rise, n))
    slack = move + 2.0 * enough
    turn, flip = (1.0 - SAME_DIRECTION) * radial * s <= slack, 2.0 * axial * c <= slack
    unique = unique and not (s > OFF_AXIS and turn) and not (c > OFF_AXIS and flip)
    a, b = add_scaled(centre, 0.5 * upper, n), add_scaled(centre, -0.5 * upper, n)
    return Depth(upper, lower, n, a, b, max(move, aside), unique)
