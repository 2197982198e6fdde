"""The meeting of a triangle of one solid with a triangle of another, and what follows for both.

T is of A and S of B, three places each (``signs``), counter-clockwise from outside. Just beneath
every triangle is the inside of its body. So two bodies have an inside in common where

- triangles go through each other, or lie on each other and face the same way;
- an edge or a corner of one lies in the other, off its edges, and it goes on beneath that one.

If no two triangles of A and B meet so, then all that is just beneath a triangle, where that is not
on the other's surface, is in the other body, or nothing is: one point beneath it decides. For the
parts of A's surface that lie in S are edges and corners that go on above S, and faces that lie on
S and face it; and along such an edge all that is beneath S is in one wedge between faces of A.
"""

from drake_geom_ros.geometry._proximity.kernels.solids.signs import (
    Signs,
    Triangle,
    apart,
    plane_through,
    side,
    side_of,
    turn,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import cross, dot
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined

# Bits of a meeting.
NOTHING = 0  # they have no point in common
TOUCH = 1  # they have
A_IS_OUT = 2  # just beneath T is nothing of B
B_IS_OUT = 4  # just beneath S is nothing of A
OVERLAPPING = 8  # A and B have an inside in common

# How the parts of two triangles lie on the common line of their planes.
BESIDE = -1
END_TO_END = 0
OVER = 1


@inlined
def has_both(signs: Signs) -> bool:
    """Return whether corners are on both sides of a plane."""
    return min(signs) < 0 and max(signs) > 0


@inlined
def is_flat(signs: Signs) -> bool:
    """Return whether all corners are in a plane."""
    return min(signs) == max(signs) == 0


@inlined
def is_off(signs: Signs) -> bool:
    """Return whether all corners are on one side of a plane, and none is in it."""
    return min(signs) > 0 or max(signs) < 0


@compiled
def alone(signs: Signs) -> tuple[int, bool]:
    """Return (k, up): the corner that is alone on its side of a plane, and whether it is above.

    The others are in the plane or beyond it; where one is in the plane and two are off it, to one
    side, that one is alone.
    """
    for k in range(3):
        first, y, z = signs[k], signs[(k + 1) % 3], signs[(k + 2) % 3]
        if first > 0 and y <= 0 and z <= 0:
            return k, True
        if first < 0 and y >= 0 and z >= 0:
            return k, False
    for k in range(3):
        y, z = signs[(k + 1) % 3], signs[(k + 2) % 3]
        if signs[k] == 0 and y == z and y != 0:
            return k, y < 0
    return 0, True


@inlined
def beginning_with(
    T: Triangle,
    k: int,
) -> Triangle:
    """Return the corners of a triangle, in their turn, from number k on."""
    if k == 0:
        return T
    if k == 1:
        return T[1], T[2], T[0]
    return T[2], T[0], T[1]


@compiled
def order_on_line(
    T: Triangle,
    S: Triangle,
    over_S: Signs,
    over_T: Signs,
    off: float,
) -> int:
    """Return how the parts of T and S lie on the common line of their planes.

    ``over_S`` are the sides of S's plane that T's corners are on. With the corners p and x alone,
    both above, the edges of T leave the line at pr and pq, and those of S at xy and xz, in this
    order along it (Guigue, Devillers, Journal of Graphics Tools 8 (1), 2003).
    """
    k, up = alone(over_S)
    m, high = alone(over_T)
    p, q, r = beginning_with(T, k)
    x, y, z = beginning_with(S, m)
    if not up:
        y, z = z, y
    if not high:
        q, r = r, q
    first = side(p, q, x, y, off)
    if first > 0:
        return BESIDE
    second = side(p, r, z, x, off)
    if second > 0:
        return BESIDE
    return OVER if first < 0 and second < 0 else END_TO_END


@compiled
def areas_overlap(
    T: Triangle,
    S: Triangle,
    axis: int,
    off: float,
) -> bool:
    """Return whether triangles of one plane have an area in common, as seen along an axis.

    They have none if all of one is beyond an edge of the other, or on it.
    """
    for swap in range(2):
        first, second = (T, S) if swap == 0 else (S, T)
        way = turn(first[0], first[1], first[2], axis, off)
        for k in range(3):
            a, b = first[k], first[(k + 1) % 3]
            if (
                way * turn(a, b, second[0], axis, off) <= 0
                and way * turn(a, b, second[1], axis, off) <= 0
                and way * turn(a, b, second[2], axis, off) <= 0
            ):
                return False
    return True


@compiled
def normal_of_places(
    T: Triangle,
) -> Vector:
    """Return the normal of a triangle, rounded, as long as twice its area."""
    u, _ = apart(T[1], T[0])
    v, _ = apart(T[2], T[0])
    return cross(u, v)


@inlined
def axis_along(n: Vector) -> int:
    """Return the axis that is the most along n."""
    x, y, z = abs(n[0]), abs(n[1]), abs(n[2])
    if x >= y and x >= z:
        return 0
    return 1 if y >= z else 2


@compiled
def sides_of(
    T: Triangle,
    S: Triangle,
    off: float,
) -> Signs:
    """Return the sides of T's plane that the corners of S are on."""
    plane = plane_through(T[0], T[1], T[2], off)
    return side_of(plane, S[0], off), side_of(plane, S[1], off), side_of(plane, S[2], off)


@inlined
def is_from(T: Triangle, S: Triangle, k: int) -> bool:
    """Return whether T begins along axis k where S ends, to the last bit, or beyond."""
    begin, end = min(T[0][k], T[1][k], T[2][k]), max(S[0][k], S[1][k], S[2][k])
    if begin != end:
        return begin > end
    for c in range(3):
        if T[c][k + 3] != 0.0 or S[c][k + 3] != 0.0:
            return False
    return True


@inlined
def is_level(T: Triangle, S: Triangle, k: int) -> bool:
    """Return whether all corners have one coordinate along axis k."""
    x, dx = T[0][k], T[0][k + 3]
    for c in range(3):
        if T[c][k] != x or S[c][k] != x or T[c][k + 3] != dx or S[c][k + 3] != dx:
            return False
    return True


@inlined
def are_side_by_side(T: Triangle, S: Triangle) -> bool:
    """Return whether the boxes of triangles in a plane normal to an axis only touch there.

    This holds for most that touch where walls of boxes lie on each other, and needs no sign.
    """
    for k in range(3):
        if is_level(T, S, k):
            i, j = (k + 1) % 3, (k + 2) % 3
            return is_from(T, S, i) or is_from(S, T, i) or is_from(T, S, j) or is_from(S, T, j)
    return False


@compiled
def meeting(
    T: Triangle,
    S: Triangle,
    off: float,
) -> int:
    """Return the bits of the meeting of T and S; places may be off by ``off`` [m]."""
    if are_side_by_side(T, S):
        return TOUCH
    over_T = sides_of(T, S, off)
    if is_off(over_T):
        return NOTHING
    over_S = sides_of(S, T, off)
    if is_off(over_S):
        return NOTHING
    if is_flat(over_T) or is_flat(over_S):
        n = normal_of_places(T)
        if not areas_overlap(T, S, axis_along(n), off):
            return TOUCH
        if dot(n, normal_of_places(S)) > 0.0:
            return OVERLAPPING
        return TOUCH | A_IS_OUT | B_IS_OUT
    order = order_on_line(T, S, over_S, over_T, off)
    if order == BESIDE:
        return NOTHING
    if order == END_TO_END:
        return TOUCH
    if has_both(over_S):
        if has_both(over_T) or min(over_T) < 0:
            return OVERLAPPING
        return TOUCH | B_IS_OUT
    if has_both(over_T):
        return OVERLAPPING if min(over_S) < 0 else TOUCH | A_IS_OUT
    return TOUCH
