"""Depth of two hulls from the polytope of an earlier answer, by EPA on vertices alone.

A vertex of the polytope is a vertex of A less one of B: a point of the Minkowski difference at
every pose. The faces of last time so are a closed surface in it again, and what ``epa`` says of
its bounds holds: it need not be convex, nor as it was. Where bodies move a little, the face that
is nearest is nearest again, and one support point shows that nothing is beyond it; where they move
more, it grows on. What is remembered are numbers in a result row, which are looked at before they
are believed: no more than time is lost by others.

``memory`` holds the numbers of vertices and of faces, where B was from A, MOST_VERTICES names and
MOST_FACES faces. A name is the place of A's vertex (see ``hulls``) and, times NAMES, that of B's.
A face is, in eight bits each, its three vertices and the *sides* across its own: four times a
face, and which of its edges. Nothing is remembered where the first number is 0.

What is not certain here, or not unique, is left to the others: flat hulls, of which no ball is
known, touching ones, and slivers next to the answer.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import MEMORY_WIDTH
from drake_geom_ros.geometry._proximity.kernels.calling.views import outlive
from drake_geom_ros.geometry._proximity.kernels.cores.ball_caps import (
    ball_in_difference,
    is_in_ball_cap,
)
from drake_geom_ros.geometry._proximity.kernels.cores.epa import witness
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import put
from drake_geom_ros.geometry._proximity.kernels.cores.hulls import farthest, vertex_at
from drake_geom_ros.geometry._proximity.kernels.cores.polytope import (
    ACROSS,
    ALIVE,
    FACE_WIDTH,
    OFFSET,
    ZERO,
    expand,
    growth_arrays,
    growth_numbers,
    is_corner,
    pop_living,
    push_nearest,
    set_planes,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import Depth
from drake_geom_ros.geometry._proximity.kernels.cores.starts import gap_along
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    Vector,
    add,
    add_scaled,
    cross,
    dot,
    perpendicular,
    rotate,
    scale,
    sub,
    unit,
    unrotate,
    vector_at,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import VERTEX_COUNT
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION, SLIVER, THIN

MOST_VERTICES = 24
MOST_FACES = 2 * MOST_VERTICES - 4
POSITION = 2  # 3: of B from A [m]
FIRST_NAME = 5
FIRST_FACE = FIRST_NAME + MOST_VERTICES
FAR = 0.125  # of the size: what moved as far since is not looked for where it was
NAMES = 2**24
FACE_NUMBERS = 2**48
NAME = 9  # column of the points
# Of the first polytope: corners between its tips, and how far [rad] they are looked for from one.
SIDES = 5
COS_TILT, SIN_TILT = math.cos(0.8), math.sin(0.8)
_ANGLES = 2.0 * np.pi / SIDES * np.arange(SIDES)
TURNS = np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))
SETTLED = 2  # of a face that is alive, but need not be looked at
# Vertices that a polytope may grow to here; most take 10 to 25.
MOST_GROWN = 40
MOST_ROWS = 8 * MOST_GROWN
MORE = 6  # of them after those that are remembered


@inlined
def is_where_it_was(memory, p, size):
    """Tell whether B is about where it was from A when it was remembered."""
    moved = sub(p, vector_at(memory, POSITION))
    return dot(moved, moved) <= (FAR * size) * (FAR * size)


@inlined
def remember_position(memory, p):
    """Remember where B is from A."""
    for k in range(3):
        memory[POSITION + k] = p[k]


@inlined
def named_support(pair, n):
    """Return (a, b, name): the vertices of ``gjk.support_points`` and the name of their pair."""
    _, shape_A, R_WA, _, shape_B, R_WB, p = pair
    x, y, z = unrotate(R_WA, n)
    i = farthest(shape_A, x, y, z)
    x, y, z = unrotate(R_WB, scale(-1.0, n))
    j = farthest(shape_B, x, y, z)
    a, b = (rotate(R_WA, vertex_at(shape_A, i)), add(p, rotate(R_WB, vertex_at(shape_B, j))))
    return a, b, float(i + NAMES * j)


@compiled
def is_closed(faces, count, total):
    """Tell whether faces, their sides in the columns from ACROSS, are linked to closed surfaces.

    Then each side has another one across it, which goes to and fro between the same vertices.
    """
    one, two = np.uint64(1), np.uint64(2)
    for f in range(total):
        for k in range(3):
            here = np.uint64(f)
            start, end, side = (faces[here, k], faces[here, (k + 1) % 3], faces[here, ACROSS + k])
            g, q = np.uint64(side >> 2), np.uint64(side & 3)
            if start >= count or start == end or side >= 4 * total or q > two:
                return False
            after = q + one if q < two else np.uint64(0)
            if faces[g, q] != end or faces[g, after] != start:
                return False
            if faces[g, q + np.uint64(ACROSS)] != 4 * f + k:
                return False
    return True


@compiled
def recall(memory, pair, points, faces):
    """Fill in the vertices at their poses, and the faces; return (count, total), 0 for nothing."""
    _, shape_A, R_WA, _, shape_B, R_WB, p = pair
    if not (4.0 <= memory[0] <= MOST_VERTICES and 4.0 <= memory[1] <= MOST_FACES):
        return 0, 0
    count, total = int(memory[0]), int(memory[1])
    for f in range(total):
        number = memory[FIRST_FACE + f]
        if not 0.0 <= number < FACE_NUMBERS:
            return 0, 0
        bits, here = int(number), np.uint64(f)
        for k in range(6):
            faces[here, k] = (bits >> (8 * k)) & 255
        faces[here, ALIVE] = 1
    if not is_closed(faces, count, total):
        return 0, 0
    for f in range(np.uint64(total)):
        for k in range(3):
            faces[f, ACROSS + k] >>= 2
    for k in range(count):
        name = memory[FIRST_NAME + k]
        if not 0.0 <= name < FACE_NUMBERS:
            return 0, 0
        i, j = int(name) % NAMES, int(name) // NAMES
        if not (1 <= i <= shape_A[VERTEX_COUNT] and 1 <= j <= shape_B[VERTEX_COUNT]):
            return 0, 0
        a, b = (rotate(R_WA, vertex_at(shape_A, i)), add(p, rotate(R_WB, vertex_at(shape_B, j))))
        put(points, k, a, b)
        points[k, NAME] = float(i + NAMES * j)
    return count, total


@compiled
def keep(memory, points, faces, total, vertex_numbers, face_numbers):
    """Remember the living faces and their vertices; nothing where they are too many.

    The last two are scratch, for the numbers of vertices and of faces.
    """
    memory[0] = 0.0
    count, living = 0, 0
    for f in range(np.uint64(total)):
        if faces[f, ALIVE] != 0:
            face_numbers[f] = living
            living += 1
            for k in range(3):
                vertex_numbers[np.uint64(faces[f, k])] = -1
    if living > MOST_FACES:
        return
    for f in range(np.uint64(total)):
        if faces[f, ALIVE] == 0:
            continue
        bits = 0
        for k in range(3):
            v, end, g = (
                np.uint64(faces[f, k]),
                faces[f, (k + 1) % 3],
                np.uint64(faces[f, ACROSS + k]),
            )
            if vertex_numbers[v] < 0:
                if count == MOST_VERTICES:
                    return
                vertex_numbers[v] = count
                memory[FIRST_NAME + count] = points[v, NAME]
                count += 1
            # The side that begins where this one ends.
            side = 0 if faces[g, 0] == end else (1 if faces[g, 1] == end else 2)
            bits |= int(vertex_numbers[v]) << (8 * k)
            bits |= (4 * int(face_numbers[g]) + side) << (24 + 8 * k)
        memory[FIRST_FACE + int(face_numbers[f])] = float(bits)
    memory[0], memory[1] = float(count), float(living)


@compiled
def put_named(pair, n, points, k):
    """Store the support point along n in row k, with its name; return how far it is along n."""
    a, b, name = named_support(pair, n)
    put(points, k, a, b)
    points[k, NAME] = name
    return dot(sub(a, b), n)


@compiled
def double_pyramid(pair, n, points, faces):
    """Make a polytope with tips along n and -n, a ring between; return the least width [m] there.

    A tetrahedron grows to it in more steps. It need not be convex.
    """
    e = perpendicular(n)
    f = cross(n, e)
    least = min(put_named(pair, n, points, 0), put_named(pair, scale(-1.0, n), points, 1))
    for k in range(SIDES):
        after, before = (k + 1) % SIDES, (k - 1) % SIDES
        aside = add_scaled(scale(TURNS[k, 0], e), TURNS[k, 1], f)
        m = add_scaled(scale(COS_TILT, n), SIN_TILT, aside)
        least = min(least, put_named(pair, m, points, 2 + k))
        upper = (0, 2 + k, 2 + after, before, SIDES + k, after, 1)
        lower = (1, 2 + after, 2 + k, SIDES + after, k, SIDES + before, 1)
        for c in range(FACE_WIDTH):
            faces[k, c], faces[SIDES + k, c] = upper[c], lower[c]
    return least


@compiled
def outweighs_slivers(points, faces, f, size):
    """Tell whether a face is seen from the origin under more than what rounding makes of others.

    Slivers may be turned the wrong way. The solid angles of all faces add up to a whole number of
    spheres: more than 0 by this face alone.
    """
    a, b, c = (
        vector_in(points, faces[f, 0]),
        vector_in(points, faces[f, 1]),
        vector_in(points, faces[f, 2]),
    )
    return dot(a, cross(b, c)) > MOST_ROWS * SLIVER * size * size * size


class Grown(NamedTuple):
    """How far a polytope was grown: whether until its nearest face ``face`` has nothing beyond.

    ``total`` is the number of faces, ``width`` [m] that of the overlap along the normal n of the
    face, with a and b the points extreme along it. Then no other face is as near if it is alone.
    """

    closed: bool
    alone: bool
    face: int
    total: int
    width: float
    n: Vector
    a: Vector
    b: Vector


@compiled
def grown(pair, growth, ball, count, total, most, least, size, noise):
    """Grow a polytope of ``count`` vertices, whose faces have planes, to ``most`` vertices.

    Faces that are farther away than the ``least`` width that is known [m] need not be looked at.
    """
    points, faces, planes, horizon, stack, starting_at, heap = growth
    waiting, alone = push_nearest(heap, planes, 0, total, 0, least + noise), True
    while True:
        f, waiting = pop_living(faces, planes, heap, waiting)
        if f < 0:
            return Grown(False, False, 0, total, 0.0, ZERO, ZERO, ZERO)
        if is_in_ball_cap(points, faces, planes, f, ball, least + noise):
            faces[f, ALIVE], alone = SETTLED, False
            continue
        m, offset = vector_in(planes, f), planes[f, OFFSET]
        a, b, name = named_support(pair, m)
        width = dot(sub(a, b), m)
        least = min(least, width)
        if width > noise and width - offset <= noise:
            after, _ = pop_living(faces, planes, heap, waiting)
            alone = alone and (after < 0 or planes[after, OFFSET] > width + noise)
            return Grown(True, alone, f, total, width, m, a, b)
        after = total
        if width > noise and count < most and not is_corner(points, faces, f, sub(a, b)):
            after = expand(
                points, faces, planes, horizon, stack, starting_at, f, a, b, count, total, size
            )
            set_planes(points, faces, planes, total, after, size)
            waiting = push_nearest(heap, planes, total, after, waiting, least + noise)
        if after == total:
            return Grown(False, False, f, total, width, m, a, b)
        points[count, NAME] = name
        count, total = count + 1, after


@compiled
def is_unique(faces, planes, total, n, rival):
    """Tell whether all unsettled faces as near as ``rival`` [m] have the normal n."""
    for f in range(np.uint64(total)):
        near = planes[f, OFFSET] <= rival and faces[f, ALIVE] == 1
        if near and dot(vector_in(planes, f), n) < SAME_DIRECTION:
            return False
    return True


@compiled
def closed_depth(growth, found, size, noise):
    """Return (sure, depth) of a polytope that was grown: sure if closed and the normal unique."""
    points, faces, planes = growth[:3]
    closed, alone, f, total, width, n, a, b = found
    offset, rival = planes[f, OFFSET], width + noise
    sure = closed and offset > THIN * size and outweighs_slivers(points, faces, f, size)
    if not (sure and (alone or is_unique(faces, planes, total, n, rival))):
        return False, Depth(width, -np.inf, n, a, b, 0.0, False)
    first, last = (f, f + 1) if alone else (0, total)
    a, b, aside = witness(points, faces, planes, first, last, n, width, rival, a, b)
    return True, Depth(width, offset, n, a, b, aside, True)


@allocating
def remembered_depth(pair, n, memory, size, noise):
    """Return (sure, depth) of two hulls by the polytope that is remembered; forget one that fails.

    Sure are bounds that are rounding apart, and a unique normal. The overlap along the unit n, the
    normal of last time, is no less than the depth, and where there is none there is no depth.
    """
    least, ball = -gap_along(pair, n), ball_in_difference(pair)
    if not (least > noise and ball.radius > THIN * size):
        memory[0] = 0.0
        return False, Depth(least, -np.inf, n, n, n, 0.0, False)
    block = np.empty(growth_numbers(MOST_GROWN))
    growth = growth_arrays(block, MOST_GROWN)
    points, faces, planes, _, stack, starting_at, _ = growth
    count, total = recall(memory, pair, points, faces)
    found = Grown(False, False, 0, 0, 0.0, ZERO, ZERO, ZERO)
    if total > 0 and set_planes(points, faces, planes, 0, total, size) > 0.0:
        found = grown(pair, growth, ball, count, total, count + MORE, least, size, noise)
    sure, depth = closed_depth(growth, found, size, noise)
    remember_position(memory, pair.p_AB)
    if not sure:
        memory[0] = 0.0
    elif found.total != total:
        keep(memory, points, faces, found.total, starting_at, stack)
    outlive(block)
    return sure, depth


@allocating
def depth_of_hulls(pair, n, memory, size, noise):
    """Return (sure, depth) of two hulls as ``remembered_depth`` does, from any unit n.

    The polytope is remembered where there is room in ``memory``.
    """
    ball = ball_in_difference(pair)
    line = unit(scale(-1.0, ball.centre))
    if dot(line, line) > 0.5:
        a, b, _ = named_support(pair, n)
        c, d, _ = named_support(pair, line)
        n = line if dot(sub(c, d), line) < dot(sub(a, b), n) else n
    block = np.empty(growth_numbers(MOST_GROWN))
    growth = growth_arrays(block, MOST_GROWN)
    points, faces, planes, _, stack, starting_at, _ = growth
    found = Grown(False, False, 0, 0, 0.0, n, n, n)
    least = double_pyramid(pair, n, points, faces) if ball.radius > THIN * size else 0.0
    if least > noise:
        count, total = 2 + SIDES, 2 * SIDES
        set_planes(points, faces, planes, 0, total, size)
        found = grown(pair, growth, ball, count, total, MOST_GROWN, least, size, noise)
    sure, depth = closed_depth(growth, found, size, noise)
    if sure and memory.size >= MEMORY_WIDTH:
        memory[0] = 0.0
        if is_where_it_was(memory, pair.p_AB, size):  # else it leaps, and is not likely to be
            keep(memory, points, faces, found.total, starting_at, stack)
        remember_position(memory, pair.p_AB)
    outlive(block)
    return sure, depth
