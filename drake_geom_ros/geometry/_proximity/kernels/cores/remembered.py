"""Warm-started depth of two hulls, from the polytope of an earlier answer, by EPA on vertices.

A vertex of the polytope is a vertex of A minus one of B, a point of the Minkowski difference at
every pose. So the remembered faces are a closed surface in it again, and the bounds of ``epa``
hold: the surface need not be convex or unchanged. If bodies move a little, the same face is
nearest, and one support point shows that nothing is beyond it; if they move more, the polytope
grows further. The memory consists of numbers in a result row (see ``memory``), which are validated
before use: wrong numbers only cost time.

Cases that are not certain or not unique here are left to other methods: flat hulls without a known
ball, touching hulls, and slivers next to the answer.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import MEMORY_WIDTH
from drake_geom_ros.geometry._proximity.kernels.cores.ball_caps import (
    Ball,
    ball_in_difference,
    is_cap_of_ball,
)
from drake_geom_ros.geometry._proximity.kernels.cores.epa_witnesses import (
    closest_in_face,
    moved_to_planes,
)
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import put
from drake_geom_ros.geometry._proximity.kernels.cores.memory import (
    NAMES,
    is_where_it_was,
    keep,
    recall,
    remember_position,
)
from drake_geom_ros.geometry._proximity.kernels.cores.polytope import ZERO
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair, Depth, Overlap
from drake_geom_ros.geometry._proximity.kernels.cores.small_polytope import (
    KEY,
    MOST_GROWN,
    MOST_ROWS,
    NAME,
    OFFSET,
    at,
    corner,
    expand,
    growth_arrays,
    growth_numbers,
    nearest,
    normal_of,
    set_corners,
    set_planes,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import farthest, vertex_at
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    perpendicular,
    rotate,
    scale,
    sub,
    unrotate,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import (
    Floats,
    Indices,
    Integers32,
    Vector,
    unsigned,
)
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import outlive
from drake_geom_ros.geometry._proximity.tolerances import (
    COPLANAR,
    EPS,
    SAME_DIRECTION,
    SLIVER,
    THIN,
)

# The first polytope: number of corners between its tips, and their angle [rad] from a tip.
SIDES = 5
COS_TILT, SIN_TILT = math.cos(0.8), math.sin(0.8)
_ANGLES = 2.0 * np.pi / SIDES * np.arange(SIDES)
TURNS = np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))
MORE = 8


@inlined
def named_support(pair: CorePair, n: Vector) -> tuple[Vector, Vector, float]:
    """Return (a, b, name): the vertices of ``gjk.support_points``, and the name of the pair."""
    _, shape_A, R_WA, _, shape_B, R_WB, p = pair
    x, y, z = unrotate(R_WA, n)
    i = farthest(shape_A, x, y, z)
    x, y, z = unrotate(R_WB, scale(-1.0, n))
    j = farthest(shape_B, x, y, z)
    a, b = (rotate(R_WA, vertex_at(shape_A, i)), add(p, rotate(R_WB, vertex_at(shape_B, j))))
    return a, b, float(i + NAMES * j)


@inlined
def put_named(pair: CorePair, n: Vector, points: Floats, k: int, narrow: Overlap) -> Overlap:
    """Store the support point along n in row k, with its name; return the narrower overlap."""
    a, b, name = named_support(pair, n)
    put(points, k, a, b)
    points[k, NAME] = name
    width = dot(sub(a, b), n)
    return Overlap(width, n) if width < narrow.width else narrow


@compiled
def double_pyramid(
    pair: CorePair, narrow: Overlap, points: Floats, corners: Integers32
) -> Overlap:
    """Make a polytope with tips along n and -n and a ring between; return the narrowest overlap.

    n is that of ``narrow``. Growing it from a tetrahedron takes more steps. It need not be convex.
    """
    n = narrow.n
    e = perpendicular(n)
    f = cross(n, e)
    narrow = put_named(pair, n, points, 0, narrow)
    narrow = put_named(pair, scale(-1.0, n), points, 1, narrow)
    for k in range(SIDES):
        after = (k + 1) % SIDES
        aside = add_scaled(scale(TURNS[k, 0], e), TURNS[k, 1], f)
        m = add_scaled(scale(COS_TILT, n), SIN_TILT, aside)
        narrow = put_named(pair, m, points, 2 + k, narrow)
        set_corners(corners, k, 0, 2 + k, 2 + after)
        set_corners(corners, SIDES + k, 1, 2 + after, 2 + k)
    return narrow


@compiled
def outweighs_slivers(points: Floats, corners: Integers32, f: int, size: float) -> bool:
    """Return whether the solid angle of a face exceeds the rounding of that of all slivers.

    Slivers may have the wrong orientation. The solid angles of all faces add up to a whole number
    of spheres, which is then positive because of this face alone.
    """
    a, b, c = (
        corner(points, corners, 0, f),
        corner(points, corners, 1, f),
        corner(points, corners, 2, f),
    )
    return dot(a, cross(b, c)) > MOST_ROWS * SLIVER * size * size * size


class Grown(NamedTuple):
    """Result of growing a polytope; closed if nothing is beyond its nearest face ``face``.

    ``vertices`` and ``total`` are the numbers of vertices and faces, ``width`` [m] is that of the
    overlap along n. If closed, n is the normal of the face, and a and b are the points extreme
    along it; ``alone``: no other face is as near. If not closed, n is the narrowest direction
    seen.
    """

    closed: bool
    alone: bool
    face: int
    vertices: int
    total: int
    width: float
    n: Vector
    a: Vector
    b: Vector


@inlined
def not_grown(narrow: Overlap) -> Grown:
    """Return a result without a closed polytope, with the narrowest overlap seen."""
    return Grown(False, False, 0, 0, 0, narrow.width, narrow.n, ZERO, ZERO)


@compiled
def grown(
    pair: CorePair,
    growth: tuple[Floats, Integers32, Floats, Indices, Integers32, Integers32],
    ball: Ball,
    count: int,
    total: int,
    most: int,
    narrow: Overlap,
    size: float,
    noise: float,
) -> Grown:
    """Grow a polytope of ``count`` vertices, whose faces have planes, to ``most`` at most.

    Faces farther away than the ``narrow`` overlap are not examined.
    """
    points, corners, planes = growth[:3]
    (least, n), alone = narrow, True
    while True:
        f = nearest(planes, total)
        if f == total or planes[at(KEY, f)] > least + noise:
            break
        m, offset = normal_of(planes, f), planes[at(OFFSET, f)]
        x, y, z = (
            corner(points, corners, 0, f),
            corner(points, corners, 1, f),
            corner(points, corners, 2, f),
        )
        if is_cap_of_ball(x, y, z, m, offset, ball, least + noise):
            planes[at(KEY, f)], alone = np.inf, False
            continue
        s_A, s_B, name = named_support(pair, m)
        w = sub(s_A, s_B)
        width = dot(w, m)
        if width < least:
            least, n = width, m
        if width <= noise:
            break
        if width - offset <= noise:
            planes[at(KEY, f)] = np.inf
            after = nearest(planes, total)
            alone = alone and planes[at(KEY, after)] > width + noise
            return Grown(True, alone, f, count, total, width, m, s_A, s_B)
        if count == most or w == x or w == y or w == z:
            break
        put(points, count, s_A, s_B)
        points[count, NAME] = name
        total, new = expand(growth, count, total, COPLANAR * EPS * size)
        if new == 0:
            break
        set_planes(points, corners, planes, total - new, total, size)
        count += 1
    return not_grown(Overlap(least, n))


@compiled
def is_unique(planes: Floats, total: int, n: Vector, rival: float) -> bool:
    """Return whether all faces within ``rival`` [m], except settled ones, have the normal n."""
    for f in range(unsigned(total)):
        if planes[at(KEY, f)] <= rival and dot(normal_of(planes, f), n) < SAME_DIRECTION:
            return False
    return True


@compiled
def witness(
    points: Floats, corners: Integers32, planes: Floats, total: int, polytope: Grown, rival: float
) -> tuple[Vector, Vector, float]:
    """Return (a, b, aside) as ``epa_witnesses.witness`` does, of a closed polytope.

    If the face is alone, only that face is examined.
    """
    foot, n = scale(polytope.width, polytope.n), polytope.n
    f = unsigned(polytope.face)
    least, a, b = closest_in_face(
        points, corners[at(0, f)], corners[at(1, f)], corners[at(2, f)], foot
    )
    for f in range(unsigned(0 if polytope.alone else total)):
        if planes[at(OFFSET, f)] > rival or dot(normal_of(planes, f), n) < SAME_DIRECTION:
            continue
        away, x, y = closest_in_face(
            points, corners[at(0, f)], corners[at(1, f)], corners[at(2, f)], foot
        )
        if away < least:
            a, b, least = x, y, away
    a, b = moved_to_planes(a, b, n, polytope.width, polytope.a, polytope.b)
    return a, b, least


@inlined
def unsure(polytope: Grown) -> Depth:
    """Return a depth without a lower bound, from the narrowest overlap seen."""
    return Depth(polytope.width, -np.inf, polytope.n, polytope.a, polytope.b, 0.0, False)


@compiled
def closed_depth(
    growth: tuple[Floats, Integers32, Floats, Indices, Integers32, Integers32],
    polytope: Grown,
    size: float,
    noise: float,
) -> tuple[bool, Depth]:
    """Return (sure, depth) of a grown polytope; sure if it is closed and the normal unique."""
    points, corners, planes = growth[:3]
    width, n, rival = polytope.width, polytope.n, polytope.width + noise
    offset = planes[at(OFFSET, polytope.face)]
    sure = polytope.closed and offset > THIN * size
    sure = sure and outweighs_slivers(points, corners, polytope.face, size)
    if not (sure and (polytope.alone or is_unique(planes, polytope.total, n, rival))):
        return False, unsure(polytope)
    a, b, aside = witness(points, corners, planes, polytope.total, polytope, rival)
    return True, Depth(width, offset, n, a, b, aside, True)


@allocating
def remembered_depth(
    pair: CorePair, narrow: Overlap, memory: Floats, size: float, noise: float
) -> tuple[bool, Depth]:
    """Return (sure, depth) of two hulls from the remembered polytope, and forget it if it fails.

    Sure means that the bounds differ by rounding and the normal is unique. ``narrow`` is the
    overlap along the last normal or any other: it is at least the depth, and if it is not positive
    there is no depth.
    """
    ball, polytope = ball_in_difference(pair), not_grown(narrow)
    if not (narrow.width > noise and ball.radius > THIN * size):
        memory[0] = 0.0
        return False, unsure(polytope)
    block = np.empty(growth_numbers())
    growth = growth_arrays(block)
    points, corners, planes, masks, _, _ = growth
    count, total = recall(memory, pair, points, corners, masks)
    if total > 0:
        set_planes(points, corners, planes, 0, total, size)
        polytope = grown(pair, growth, ball, count, total, count + MORE, narrow, size, noise)
    sure, depth = closed_depth(growth, polytope, size, noise)
    remember_position(memory, pair.p_AB)
    if not sure:
        memory[0] = 0.0
    elif polytope.vertices != count:
        keep(memory, points, corners, polytope.total, masks)
    outlive(block)
    return sure, depth


@allocating
def depth_of_hulls(
    pair: CorePair, narrow: Overlap, memory: Floats, size: float, noise: float
) -> tuple[bool, Depth]:
    """Return (sure, depth) of two hulls as ``remembered_depth`` does, from any known overlap.

    The polytope is stored if ``memory`` is large enough. If not sure, the depth is the narrowest
    overlap seen; if that is negative, the hulls are separated.
    """
    ball, polytope = ball_in_difference(pair), not_grown(narrow)
    if not (narrow.width > noise and ball.radius > THIN * size):
        return False, unsure(polytope)
    block = np.empty(growth_numbers())
    growth = growth_arrays(block)
    points, corners, planes, masks, _, _ = growth
    narrow = double_pyramid(pair, narrow, points, corners)
    polytope = not_grown(narrow)
    if narrow.width > noise:
        count, total = 2 + SIDES, 2 * SIDES
        set_planes(points, corners, planes, 0, total, size)
        polytope = grown(pair, growth, ball, count, total, MOST_GROWN, narrow, size, noise)
    sure, depth = closed_depth(growth, polytope, size, noise)
    if sure and memory.size >= MEMORY_WIDTH:
        memory[0] = 0.0
        if is_where_it_was(memory, pair.p_AB, size):  # after a leap it is unlikely to be reused
            keep(memory, points, corners, polytope.total, masks)
        remember_position(memory, pair.p_AB)
    outlive(block)
    return sure, depth
