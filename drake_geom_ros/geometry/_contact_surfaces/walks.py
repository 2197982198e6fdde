"""Candidate pairs of elements of two bodies: a walk over both trees, or over one and a plane.

A walk stops where it has used up its steps or the room for polygons, and goes on in the next call.
"""

from __future__ import annotations

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    CORNERS,
    FACES_BEFORE,
    FIRST_NODE,
    FULL,
    HALF,
    KIND,
    LEAVES,
    MIDDLE,
    NODE,
    POLYGONS,
    STEPS,
    SUMS,
    SURFACE,
    TOP,
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
OF_A_POLYGON = 16  # steps that take as long as to put one out
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
    """Return whether the boxes of two nodes are kept apart by a side of either."""
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


@inlined
def _begin_step(between: Between, scratch: Scratch, out: Surfaces) -> tuple[int, int]:
    """Return how many polygons and corners there are, and keep the integrals beside them."""
    for k in range(SUMS):
        scratch.sums[k] = out.sums[between.row, k]
    return out.counts[POLYGONS], out.counts[CORNERS]


@inlined
def _end_step(
    before: tuple[int, int], steps: int, between: Between, scratch: Scratch, out: Surfaces
) -> bool:
    """Count the steps; return False, all being as at the beginning, where there was no room."""
    counts = out.counts
    counts[STEPS] -= steps + OF_A_POLYGON * (counts[POLYGONS] - before[0])
    if counts[POLYGONS] <= len(out.ends) and counts[CORNERS] <= len(out.points):
        return True
    counts[POLYGONS], counts[CORNERS] = before
    for k in range(SUMS):
        out.sums[between.row, k] = scratch.sums[k]
    counts[FULL] = 1
    return False


@inlined
def _is_decided(between: Between, out: Surfaces) -> bool:
    """Return whether faces count whatever their normals are, and there is one: it is enough."""
    decided: bool = between.anyway and out.counts[POLYGONS] > out.counts[FACES_BEFORE]
    return decided


@compiled
def meet_bodies(bodies: Bodies, between: Between, scratch: Scratch, out: Surfaces) -> bool:
    """Put out where the tetrahedra of the first body meet the elements of the second.

    Both trees are gone down, the second one first, to its single elements: what is kept apart
    from one of them is found by more than boxes. Return whether the walk has come to its end.
    """
    a, b, stack, counts = between.a, between.b, scratch.stack, out.counts
    last_a, last_b = bodies.table[a, LEAVES] - 1, bodies.table[b, LEAVES] - 1
    is_surface = bodies.table[b, KIND] == SURFACE
    top = counts[TOP]
    if top < 0:
        stack[0] = stack[1] = 0
        top = 2
    while top > 0 and counts[STEPS] > 0:
        top -= 2
        i, j = stack[unsigned(top)], stack[unsigned(top + 1)]
        counts[STEPS] -= 1
        if _apart(bodies, a, i, b, j, between):
            continue
        if j >= last_b:
            before, steps = _begin_step(between, scratch, out), 0
            for f in range(
                first_in_leaf(bodies, b, j - last_b), first_in_leaf(bodies, b, j - last_b + 1)
            ):
                if is_surface:
                    steps += meet_triangle(bodies, i, f, between, scratch, top, out)
                else:
                    pose(bodies, f, between, scratch.other)
                    steps += _meet_one(bodies, i, f, between, scratch, top, out)
            if _is_decided(between, out):
                top = 0
            elif not _end_step(before, steps, between, scratch, out):
                stack[unsigned(top)], stack[unsigned(top + 1)] = i, j
                top += 2
                break
            continue
        split_a = i < last_a and _size(bodies, a, i) >= SECOND_FIRST * _size(bodies, b, j)
        for k in (2, 1):
            stack[unsigned(top)] = 2 * i + k if split_a else i
            stack[unsigned(top + 1)] = j if split_a else 2 * j + k
            top += 2
    counts[TOP] = top
    return bool(top == 0)


@inlined
def _meet_one(
    bodies: Bodies,
    i: int,
    f: int,
    between: Between,
    scratch: Scratch,
    bottom: int,
    out: Surfaces,
) -> int:
    """Put out where tetrahedra of the first body's node i meet element f, which is posed.

    What is on the stack below ``bottom`` stays. Return how many steps that took.
    """
    a, stack = between.a, scratch.stack
    last, top = bodies.table[a, LEAVES] - 1, bottom + 1
    first_node, steps = bodies.table[a, FIRST_NODE], 0
    stack[unsigned(bottom)] = i
    while top > bottom:
        top -= 1
        steps += 1
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
    return steps


@compiled
def meet_plane(
    bodies: Bodies, slope: float, between: Between, scratch: Scratch, out: Surfaces
) -> bool:
    """Put out where the elements of the first body meet a half space.

    Return whether the walk has come to its end.
    """
    a, stack, counts = between.a, scratch.stack, out.counts
    last = bodies.table[a, LEAVES] - 1
    up = between.R[0, 2], between.R[1, 2], between.R[2, 2]
    top = counts[TOP]
    if top < 0:
        stack[0] = 0
        top = 1
    while top > 0 and counts[STEPS] > 0:
        top -= 1
        i = stack[top]
        counts[STEPS] -= 1
        middle, half = box_of(bodies, a, i)
        height = dot(up, sub(middle, between.p))
        spread = abs(up[0]) * half[0] + abs(up[1]) * half[1] + abs(up[2]) * half[2]
        below_all = slope == 0.0 and height < -spread - between.rounding
        if height > spread + between.rounding or below_all:
            continue
        if i >= last:
            before = _begin_step(between, scratch, out)
            for e in range(
                first_in_leaf(bodies, a, i - last), first_in_leaf(bodies, a, i - last + 1)
            ):
                meet_half_space(bodies, e, slope, between, scratch.work, out)
            if _is_decided(between, out):
                top = 0
            elif not _end_step(before, 0, between, scratch, out):
                stack[top] = i
                top += 1
                break
            continue
        for k in (2, 1):
            stack[top] = 2 * i + k
            top += 1
    counts[TOP] = top
    return bool(top == 0)
