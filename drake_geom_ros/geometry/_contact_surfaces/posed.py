"""An element of the second body in the first one's frame, and what is kept apart from it."""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FIRST_POINT,
    HALF,
    LEVEL,
    MIDDLE,
    NODE,
    SLOPE,
    Between,
    Bodies,
    Floats,
    in_node,
)
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.vectors import add, dot, rotate, sub, vector_in
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector

# Rows: the corners of a tetrahedron; planes as those of ``Bodies``; the box; gradient and pressure
# at the origin, and the gradient's length.
CORNER, PLANE, LOWEST, HIGHEST, FIELD, LENGTH = 0, 4, 8, 9, 10, 11
OTHER = 12
PLANES = 4


@compiled
def pose(bodies: Bodies, f: int, between: Between, other: Floats) -> None:
    """Put tetrahedron f of the second body in the first one's frame."""
    first, R, p = bodies.table[between.b, FIRST_POINT], between.R, between.p
    for k in range(4):
        row = first + bodies.elements[f, k]
        corner = add(rotate(R, vector_in(bodies.points, row)), p)
        for i in range(3):
            other[CORNER + k, i] = corner[i]
    for i in range(3):
        a, b, c, d = other[CORNER, i], other[CORNER + 1, i], other[CORNER + 2, i], other[3, i]
        other[LOWEST, i] = min(min(a, b), min(c, d))
        other[HIGHEST, i] = max(max(a, b), max(c, d))
    for k in range(PLANES):
        normal = rotate(
            R, (bodies.planes[f, k, 0], bodies.planes[f, k, 1], bodies.planes[f, k, 2])
        )
        for i in range(3):
            other[PLANE + k, i] = normal[i]
        other[PLANE + k, 3] = bodies.planes[f, k, 3] + dot(normal, p)
    h = rotate(R, vector_in(bodies.fields, f))
    for i in range(3):
        other[FIELD, i] = h[i]
    other[FIELD, 3] = bodies.fields[f, 3] - dot(h, p)
    other[LENGTH, 0] = bodies.fields[f, 4]


@inlined
def _spread(n: Vector, half: Vector) -> float:
    """Return half the extent of a box along a vector, times its length."""
    spread: float = abs(n[0]) * half[0] + abs(n[1]) * half[1] + abs(n[2]) * half[2]
    return spread


@inlined
def is_beyond_box(
    bodies: Bodies, first_node: int, k: int, other: Floats, between: Between
) -> bool:
    """Return whether no element under node k of the first body, whose nodes begin there, meets it.

    Either its box is kept apart from that, or the pressures are nowhere the same in it.
    """
    nodes, near = bodies.nodes, between.rounding
    row = NODE * (first_node + k)
    middle, half = in_node(nodes, row, MIDDLE), in_node(nodes, row, HALF)
    for i in range(3):
        if other[LOWEST, i] - middle[i] > half[i] + near:
            return True
        if middle[i] - other[HIGHEST, i] > half[i] + near:
            return True
    for i in range(PLANES):
        normal = vector_in(other, PLANE + i)
        if dot(normal, middle) - other[PLANE + i, 3] > _spread(normal, half) + near:
            return True
    n = sub(in_node(nodes, row, SLOPE), vector_in(other, FIELD))
    level, spread, steepest = in_node(nodes, row, LEVEL)
    value = dot(n, middle) + (level - other[FIELD, 3])
    rounding = near * (steepest + other[LENGTH, 0])
    differ: bool = abs(value) > _spread(n, half) + spread + rounding
    return differ


@inlined
def corner_of(other: Floats, k: int) -> Vector:
    """Return a corner of the element that is posed."""
    return vector_in(other, CORNER + k)


@inlined
def is_beyond(other: Floats, corners: tuple[Vector, Vector, Vector, Vector], near: float) -> bool:
    """Return whether corners are all farther than ``near`` outside one face of the posed one."""
    for k in range(PLANES):
        if lowest(vector_in(other, PLANE + k), corners) > other[PLANE + k, 3] + near:
            return True
    return False


@inlined
def lowest(n: Vector, corners: tuple[Vector, Vector, Vector, Vector]) -> float:
    """Return the least of the products of a vector with four corners."""
    c0, c1, c2, c3 = corners
    least: float = min(min(dot(n, c0), dot(n, c1)), min(dot(n, c2), dot(n, c3)))
    return least
