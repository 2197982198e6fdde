"""Intersection of a rigid triangle with the tetrahedra of a compliant mesh.

A long triangle of a fine surface meets most of a coarse body's tetrahedra: so the boxes of many of
them are compared with it in one loop, which LLVM does four at a time.
"""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FIRST_NODE,
    FIRST_POINT,
    HALF,
    LEAVES,
    MIDDLE,
    NODE,
    Between,
    Bodies,
    Field,
    Floats,
    Indices,
    Scratch,
    Surfaces,
    first_in_leaf,
    in_node,
)
from drake_geom_ros.geometry._contact_surfaces.clipping import (
    HEIGHT,
    clipped_by_each,
    without_twins,
)
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled, inlined
from drake_geom_ros.geometry._contact_surfaces.elements import (
    agrees,
    corners_of,
    height_above_face,
    snapped,
)
from drake_geom_ros.geometry._contact_surfaces.emitting import emit
from drake_geom_ros.geometry._contact_surfaces.posed import lowest
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    rotate,
    scale,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector, unsigned

TOGETHER = 64  # leaves whose elements are looked at one by one, without the boxes above them
MOST_TOGETHER = 2 * TOGETHER  # elements: a leaf has one or two


class Triangle(NamedTuple):
    """A triangle in the first body's frame: corners, unit normal, offset [m], and its box."""

    a: Vector
    b: Vector
    c: Vector
    nhat: Vector
    offset: float
    middle: Vector
    half: Vector


@inlined
def _middle(a: float, b: float, c: float) -> float:
    """Return the middle of the range of three numbers."""
    middle: float = 0.5 * (min(a, min(b, c)) + max(a, max(b, c)))
    return middle


@inlined
def _half(a: float, b: float, c: float) -> float:
    """Return half the range of three numbers."""
    half: float = 0.5 * (max(a, max(b, c)) - min(a, min(b, c)))
    return half


@inlined
def posed_triangle(bodies: Bodies, f: int, between: Between) -> Triangle:
    """Return triangle f of the second body in the first one's frame."""
    first, R, p, k = bodies.table[between.b, FIRST_POINT], between.R, between.p, unsigned(f)
    a = add(rotate(R, vector_in(bodies.points, first + bodies.elements[k, 0])), p)
    b = add(rotate(R, vector_in(bodies.points, first + bodies.elements[k, 1])), p)
    c = add(rotate(R, vector_in(bodies.points, first + bodies.elements[k, 2])), p)
    own = bodies.planes[k, 0, 0], bodies.planes[k, 0, 1], bodies.planes[k, 0, 2]
    nhat = rotate(R, own)
    return Triangle(
        a,
        b,
        c,
        nhat,
        bodies.planes[k, 0, 3] + dot(nhat, p),
        (_middle(a[0], b[0], c[0]), _middle(a[1], b[1], c[1]), _middle(a[2], b[2], c[2])),
        (_half(a[0], b[0], c[0]), _half(a[1], b[1], c[1]), _half(a[2], b[2], c[2])),
    )


@inlined
def _is_apart(middle: Vector, half: Vector, triangle: Triangle, near: float) -> bool:
    """Return whether a box is kept apart from a triangle by a side of its box, or by its plane.

    Without a branch: which of them it is nobody can guess.
    """
    x, y, z = middle
    a, b, c = half
    n = triangle.nhat
    spread = abs(n[0]) * a + abs(n[1]) * b + abs(n[2]) * c
    apart: bool = (
        (abs(x - triangle.middle[0]) > a + triangle.half[0] + near)
        | (abs(y - triangle.middle[1]) > b + triangle.half[1] + near)
        | (abs(z - triangle.middle[2]) > c + triangle.half[2] + near)
        | (abs(n[0] * x + n[1] * y + n[2] * z - triangle.offset) > spread + near)
    )
    return apart


@inlined
def _near_ones(
    boxes: Floats, first: int, end: int, triangle: Triangle, near: float, found: Indices
) -> int:
    """Put those of some elements whose boxes a triangle may meet; return how many there are."""
    for e in range(first, end):
        k = unsigned(e)
        middle, half = (
            (boxes[0, k], boxes[1, k], boxes[2, k]),
            (boxes[3, k], boxes[4, k], boxes[5, k]),
        )
        found[unsigned(MOST_TOGETHER + e - first)] = (
            0 if _is_apart(middle, half, triangle, near) else 1
        )
    count = 0
    for e in range(first, end):
        found[unsigned(count)] = e
        count += found[unsigned(MOST_TOGETHER + e - first)]
    return count


@compiled
def meet_triangle(
    bodies: Bodies, i: int, f: int, between: Between, scratch: Scratch, bottom: int, out: Surfaces
) -> int:
    """Put out where tetrahedra of the first body's node i meet triangle f of the second.

    What is on the stack below ``bottom`` stays. Return how many steps that took.
    """
    a, stack, near = between.a, scratch.stack, between.rounding
    triangle = posed_triangle(bodies, f, between)
    last, first_node, top = bodies.table[a, LEAVES] - 1, bodies.table[a, FIRST_NODE], bottom + 1
    stack[unsigned(bottom)] = i
    steps = 0
    while top > bottom:
        top -= 1
        steps += 1
        k = stack[unsigned(top)]
        low = high = k
        while low < last:
            low, high = 2 * low + 1, 2 * high + 2
        if high - low < TOGETHER:
            first, end = (
                first_in_leaf(bodies, a, low - last),
                first_in_leaf(bodies, a, high - last + 1),
            )
            count = _near_ones(bodies.boxes, first, end, triangle, near, scratch.found)
            steps += ((end - first) >> 2) + count  # boxes are compared four at a time
            for number in range(count):
                _meet(
                    bodies, scratch.found[unsigned(number)], triangle, between, scratch.work, out
                )
            continue
        row = NODE * (first_node + k)
        middle, half = in_node(bodies.nodes, row, MIDDLE), in_node(bodies.nodes, row, HALF)
        if _is_apart(middle, half, triangle, near):
            continue
        stack[unsigned(top)], stack[unsigned(top + 1)] = 2 * k + 2, 2 * k + 1
        top += 2
    return steps


@inlined
def _put_cutting(
    bodies: Bodies, e: int, triangle: Triangle, near: float, work: Floats
) -> tuple[int, int]:
    """Put the heights of a triangle's corners above the faces that they are not all below.

    Return how many faces these are, -1 where the triangle is outside of one, and which, in two
    bits each, the first lowest.
    """
    planes = faces = 0
    for k in range(4):
        a = snapped(height_above_face(bodies, e, k, triangle.a), near)
        b = snapped(height_above_face(bodies, e, k, triangle.b), near)
        c = snapped(height_above_face(bodies, e, k, triangle.c), near)
        least, most = min(a, min(b, c)), max(a, max(b, c))
        if least >= 0.0 and most > 0.0:
            return -1, 0
        if most > 0.0 or least == 0.0:
            column = unsigned(HEIGHT + planes)
            work[0, column], work[1, column], work[2, column] = a, b, c
            faces |= k << (2 * planes)
            planes += 1
    return planes, faces


@inlined
def _meet(
    bodies: Bodies, e: int, triangle: Triangle, between: Between, work: Floats, out: Surfaces
) -> None:
    """Put out which part of a triangle is in tetrahedron e of the first body."""
    k, nhat, near = unsigned(e), triangle.nhat, between.rounding
    g = vector_in(bodies.fields, k)
    if not (agrees(nhat, g, bodies.fields[k, 4]) or between.anyway):
        return
    planes, faces = _put_cutting(bodies, k, triangle, near, work)
    if planes < 0:
        return
    work[0, 0], work[0, 1], work[0, 2] = triangle.a
    work[1, 0], work[1, 1], work[1, 2] = triangle.b
    work[2, 0], work[2, 1], work[2, 2] = triangle.c
    at, count, face = clipped_by_each(work, 0, 3, planes, -1)
    if face >= 0:
        twin = bodies.beyond[k, unsigned((faces >> (2 * face)) & 3)]
        if twin < 0:
            return
        its = vector_in(bodies.fields, twin)
        if twin < e and (between.anyway or agrees(nhat, its, bodies.fields[twin, 4])):
            return
        at, count, face = clipped_by_each(work, at, count, planes, face)
    if count == 0:
        return
    own = corners_of(bodies, bodies.table[between.a, FIRST_POINT], e)
    if lowest(nhat, own) - triangle.offset > near:
        return
    if lowest(scale(-1.0, nhat), own) + triangle.offset > near:
        return
    count = without_twins(work, at, count, near)
    if count:
        field = Field(g, bodies.fields[k, 3], bodies.fields[k, 4])
        emit(work, at, count, nhat, field, (g, (0.0, 0.0, 0.0)), between, out)
