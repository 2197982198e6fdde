"""Boxes in a solid, along the axes of its frame, that together fill much of it.

Planes along the axes cut the space of a solid into cells. A cell that no triangle goes into is in
the solid or out of it, and one point decides which; boxes of cells that are in it are grown until
nothing can be added. They fill a union of boxes; of what is round they fill some.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.solids.containment import (
    bounds_if_box,
)
from drake_geom_ros.geometry._proximity.kernels.solids.rays import INSIDE, Posed, where_is
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    INNER_BOX,
    Tree,
    TreeBody,
    tree_of,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    cross,
    dot,
    sub,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import (
    SOLID,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled

ORDERS = ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))
ORIGIN: Vector = (0.0, 0.0, 0.0)


@compiled
def reach_of(
    u: Vector, v: Vector, w: Vector, axis: Vector, half: Vector
) -> tuple[float, float, float]:
    """Return (least, most, reach) of a triangle along an axis, and of a box about the origin."""
    x, y, z = dot(axis, u), dot(axis, v), dot(axis, w)
    reach = abs(axis[0]) * half[0] + abs(axis[1]) * half[1] + abs(axis[2]) * half[2]
    return min(x, y, z), max(x, y, z), reach


@compiled
def goes_into(a: Vector, b: Vector, c: Vector, low: Vector, high: Vector) -> bool:
    """Return whether a triangle goes into the inside of a box, or may: no axis separates them.

    Along the box's axes coordinates are compared as they are, so a face of it is not its inside.
    """
    for k in range(3):
        if max(a[k], b[k], c[k]) <= low[k] or min(a[k], b[k], c[k]) >= high[k]:
            return False
    middle = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])
    half = 0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2])
    u, v, w = sub(a, middle), sub(b, middle), sub(c, middle)
    edges = sub(v, u), sub(w, v), sub(u, w)
    least, most, reach = reach_of(u, v, w, cross(edges[0], edges[1]), half)
    if least > reach or most < -reach:
        return False
    for e in edges:
        for axis in ((0.0, -e[2], e[1]), (e[2], 0.0, -e[0]), (-e[1], e[0], 0.0)):
            least, most, reach = reach_of(u, v, w, axis, half)
            if least > reach or most < -reach:
                return False
    return True


@compiled
def cell_at(lines: Floats, x: float) -> int:
    """Return the number of the cell between lines (n,) that holds x, or the nearest."""
    k = int(np.searchsorted(lines, x)) - 1
    return min(max(k, 0), lines.size - 2)


@allocating
def cells_within(posed: Posed, xs: Floats, ys: Floats, zs: Floats) -> Indices:
    """Return 1 for cells (l, m, n) between lines along x, y and z that are in a solid, else 0."""
    filled = np.ones((xs.size - 1, ys.size - 1, zs.size - 1), dtype=np.int64)
    shape, tree = posed.shape, posed.tree
    for j in range(tree.triangles):
        at = tree.corners + CORNERS * j
        a, b, c = vector_at(shape, at), vector_at(shape, at + 3), vector_at(shape, at + 6)
        first_x, last_x = cell_at(xs, min(a[0], b[0], c[0])), cell_at(xs, max(a[0], b[0], c[0]))
        first_y, last_y = cell_at(ys, min(a[1], b[1], c[1])), cell_at(ys, max(a[1], b[1], c[1]))
        first_z, last_z = cell_at(zs, min(a[2], b[2], c[2])), cell_at(zs, max(a[2], b[2], c[2]))
        for x in range(first_x, last_x + 1):
            for y in range(first_y, last_y + 1):
                for z in range(first_z, last_z + 1):
                    low, high = (xs[x], ys[y], zs[z]), (xs[x + 1], ys[y + 1], zs[z + 1])
                    if filled[x, y, z] != 0 and goes_into(a, b, c, low, high):
                        filled[x, y, z] = 0
    for x in range(filled.shape[0]):
        for y in range(filled.shape[1]):
            for z in range(filled.shape[2]):
                if filled[x, y, z] != 0:
                    middle = (
                        0.5 * (xs[x] + xs[x + 1]),
                        0.5 * (ys[y] + ys[y + 1]),
                        0.5 * (zs[z] + zs[z + 1]),
                        0.0,
                        0.0,
                        0.0,
                    )
                    filled[x, y, z] = where_is(posed, middle) == INSIDE
    return filled


@compiled
def is_full(sums: Indices, low: Indices, high: Indices) -> bool:
    """Return whether a box of cells is full, by the sums of all cells before each corner."""
    inside = (
        sums[high[0], high[1], high[2]]
        - sums[low[0], high[1], high[2]]
        - sums[high[0], low[1], high[2]]
        - sums[high[0], high[1], low[2]]
        + sums[low[0], low[1], high[2]]
        + sums[low[0], high[1], low[2]]
        + sums[high[0], low[1], low[2]]
        - sums[low[0], low[1], low[2]]
    )
    return inside == (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2])


@allocating
def grow_box(sums: Indices, low: Indices, high: Indices, order: tuple[int, int, int]) -> None:
    """Grow a full box of cells from ``low`` to ``high`` (3,), along one axis after the other."""
    for turn in range(3):
        k = order[turn]
        while low[k] > 0:
            low[k] -= 1
            if not is_full(sums, low, high):
                low[k] += 1
                break
        while high[k] < sums.shape[k] - 1:
            high[k] += 1
            if not is_full(sums, low, high):
                high[k] -= 1
                break


@compiled
def is_contained(boxes: Indices, count: int, low: Indices, high: Indices) -> bool:
    """Return whether a box of cells lies in one of ``boxes`` (n, 6)."""
    for k in range(count):
        holds = True
        for c in range(3):
            holds = holds and boxes[k, c] <= low[c] and boxes[k, c + 3] >= high[c]
        if holds:
            return True
    return False


@allocating
def full_boxes(sums: Indices, boxes: Indices) -> int:
    """Fill ``boxes`` (n, 6) with the largest full boxes of cells, at most n; return how many.

    Each full cell is grown along the axes in all six orders.
    """
    count = 0
    low, high = np.empty(3, dtype=np.int64), np.empty(3, dtype=np.int64)
    n = sums.shape[0] - 1, sums.shape[1] - 1, sums.shape[2] - 1
    for number in range(n[0] * n[1] * n[2]):
        seed = number // (n[1] * n[2]), number // n[2] % n[1], number % n[2]
        for order in ORDERS:
            for c in range(3):
                low[c], high[c] = seed[c], seed[c] + 1
            if not is_full(sums, low, high):
                break
            grow_box(sums, low, high, order)
            if not is_contained(boxes, count, low, high):
                for c in range(3):
                    boxes[count, c], boxes[count, c + 3] = low[c], high[c]
                count += 1
                if count == boxes.shape[0]:
                    return count
    return count


@allocating
def inner_boxes(shape: Floats, xs: Floats, ys: Floats, zs: Floats, boxes: Indices) -> int:
    """Fill ``boxes`` (n, 6) with boxes of cells that are in a solid; return how many there are.

    A box is the numbers of its first lines along x, y, z, and of its last, in
    ``xs``, ``ys`` and ``zs``.
    """
    tree = tree_of(SOLID, shape)
    filled = cells_within(Posed(shape, tree, np.eye(3), ORIGIN, 0.0), xs, ys, zs)
    sums = np.zeros((xs.size, ys.size, zs.size), dtype=np.int64)
    for x in range(filled.shape[0]):
        for y in range(filled.shape[1]):
            for z in range(filled.shape[2]):
                sums[x + 1, y + 1, z + 1] = (
                    filled[x, y, z]
                    + sums[x, y + 1, z + 1]
                    + sums[x + 1, y, z + 1]
                    + sums[x + 1, y + 1, z]
                    - sums[x, y, z + 1]
                    - sums[x, y + 1, z]
                    - sums[x + 1, y, z]
                    + sums[x, y, z]
                )
    return full_boxes(sums, boxes)


@allocating
def boxes_in(shape: Floats, tree: Tree) -> Floats:
    """Return the boxes (k, 6) within a solid."""
    boxes = np.empty((tree.boxes, INNER_BOX))
    for k in range(tree.boxes):
        for c in range(INNER_BOX):
            boxes[k, c] = shape[tree.boxes_at + INNER_BOX * k + c]
    return boxes


@allocating
def boxes_of(A: TreeBody) -> Floats:
    """Return boxes (k, 6) within a body, along its axes: lower and upper corners."""
    if A.kind == SOLID:
        return boxes_in(A.shape, A.tree)
    is_box, low, high = bounds_if_box(A)
    boxes = np.empty((1 if is_box else 0, INNER_BOX))
    for k in range(boxes.shape[0]):
        for c in range(3):
            boxes[k, c], boxes[k, c + 3] = low[c], high[c]
    return boxes
