"""Which elements of two bodies may meet: a walk over both trees, or over one and a plane."""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FIRST_NODE,
    HALF,
    KIND,
    LEAVES,
    MIDDLE,
    NODE,
    SURFACE,
    Between,
    Bodies,
    Floats,
    Scratch,
    Surfaces,
    first_in_leaf,
    in_node,
)
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled, inlined
from drake_geom_ros.geometry._contact_surfaces.elements import meet
from drake_geom_ros.geometry._contact_surfaces.half_spaces import meet_half_space
from drake_geom_ros.geometry._contact_surfaces.posed import is_beyond_box, pose
from drake_geom_ros.geometry._contact_surfaces.triangles import meet_triangle
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    rotate,
    sub,
    unrotate,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector, unsigned

DEEPEST = 128  # of a walk: three times the depth of trees that fit into memory
SECOND_FIRST = 4.0  # how much larger a box of the first body has to be, to be split first


@inlined
def box_of(bodies: Bodies, body: int, k: int) -> tuple[Vector, Vector]:
    """Return middle and half size of the box of a body's node k."""
    row = NODE * (bodies.table[body, FIRST_NODE] + k)
    return in_node(bodies.nodes, row, MIDDLE), in_node(bodies.nodes, row, HALF)


@inlined
def _spread(R: Floats, k: int, half: Vector) -> float:
    """Return half the extent of a box, turned by R, along axis k."""
    spread: float = abs(R[k, 0]) * half[0] + abs(R[k, 1]) * half[1] + abs(R[k, 2]) * half[2]
    return spread


@inlined
def _spread_back(R: Floats, k: int, half: Vector) -> float:
    """Return half the extent of a box, turned by the inverse of R, along axis k."""
    spread: float = abs(R[0, k]) * half[0] + abs(R[1, k]) * half[1] + abs(R[2, k]) * half[2]
    return spread


@inlined
def _apart(bodies: Bodies, a: int, i: int, b: int, j: int, between: Between) -> bool:
    """Tell whether the boxes of two nodes are kept apart by a side of either."""
    middle, half = box_of(bodies, a, i)
    other, other_half = box_of(bodies, b, j)
    R, near = between.R, between.rounding
    d = sub(add(rotate(R, other), between.p), middle)
    for k in range(3):
        if abs(d[k]) > half[k] + _spread(R, k, other_half) + near:
            return True
    back = unrotate(R, d)
    for k in range(3):
        if abs(back[k]) > other_half[k] + _spread_back(R, k, half) + near:
            return True
    return False


@inlined
def _size(bodies: Bodies, body: int, k: int) -> float:
    """Return how large the box of a node is, for comparison."""
    _, half = box_of(bodies, body, k)
    return half[0] + half[1] + half[2]


@compiled
def meet_bodies(bodies: Bodies, between: Between, scratch: Scratch, out: Surfaces) -> None:
    """Put out where the tetrahedra of the first body meet the elements of the second.

    Both trees are gone down, the second one first, to its single elements: what is kept apart
    from one of them is found by more than boxes.
    """
    a, b, stack = between.a, between.b, scratch.stack
    last_a, last_b = bodies.table[a, LEAVES] - 1, bodies.table[b, LEAVES] - 1
    is_surface = bodies.table[b, KIND] == SURFACE
    stack[0] = stack[1] = 0
    top = 2
    while top > 0:
        top -= 2
        i, j = stack[unsigned(top)], stack[unsigned(top + 1)]
        if _apart(bodies, a, i, b, j, between):
            continue
        if j >= last_b:
            for f in range(
                first_in_leaf(bodies, b, j - last_b), first_in_leaf(bodies, b, j - last_b + 1)
            ):
                if is_surface:
                    meet_triangle(bodies, i, f, between, scratch, top, out)
                else:
                    pose(bodies, f, between, scratch.other)
                    _meet_one(bodies, i, f, between, scratch, top, out)
            continue
        split_a = i < last_a and _size(bodies, a, i) >= SECOND_FIRST * _size(bodies, b, j)
        for k in (2, 1):
            stack[unsigned(top)] = 2 * i + k if split_a else i
            stack[unsigned(top + 1)] = j if split_a else 2 * j + k
            top += 2


@inlined
def _meet_one(
    bodies: Bodies,
    i: int,
    f: int,
    between: Between,
    scratch: Scratch,
    bottom: int,
    out: Surfaces,
) -> None:
    """Put out where tetrahedra of the first body's node i meet element f, which is posed.

    What is on the stack below ``bottom`` stays.
    """
    a, stack = between.a, scratch.stack
    last, top = bodies.table[a, LEAVES] - 1, bottom + 1
    first_node = bodies.table[a, FIRST_NODE]
    stack[unsigned(bottom)] = i
    while top > bottom:
        top -= 1
        k = stack[unsigned(top)]
        if is_beyond_box(bodies, first_node, k, scratch.other, between):
            continue
        if k >= last:
            for e in range(
                first_in_leaf(bodies, a, k - last), first_in_leaf(bodies, a, k - last + 1)
            ):
                meet(bodies, e, f, between, scratch, out)
            continue
        stack[unsigned(top)], stack[unsigned(top + 1)] = 2 * k + 2, 2 * k + 1
        top += 2


@compiled
def meet_plane(
    bodies: Bodies, slope: float, between: Between, scratch: Scratch, out: Surfaces
) -> None:
    """Put out where the elements of the first body meet a half space."""
    a, stack = between.a, scratch.stack
    last = bodies.table[a, LEAVES] - 1
    up = between.R[0, 2], between.R[1, 2], between.R[2, 2]
    stack[0] = 0
    top = 1
    while top > 0:
        top -= 1
        i = stack[top]
        middle, half = box_of(bodies, a, i)
        height = dot(up, sub(middle, between.p))
        spread = abs(up[0]) * half[0] + abs(up[1]) * half[1] + abs(up[2]) * half[2]
        below_all = slope == 0.0 and height < -spread - between.rounding
        if height > spread + between.rounding or below_all:
            continue
        if i >= last:
            for e in range(
                first_in_leaf(bodies, a, i - last), first_in_leaf(bodies, a, i - last + 1)
            ):
                meet_half_space(bodies, e, slope, between, scratch.work, out)
            continue
        for k in (2, 1):
            stack[top] = 2 * i + k
            top += 1
