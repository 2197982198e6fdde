"""Broad phase: from boxes to the pairs that overlap, by a hierarchy of hashed grids.

Each body is put into the cell that holds its centre, of a grid whose cells are one to four times
as wide as its box (Ericson, *Real-Time Collision Detection*, 2005, section 7.2). Overlapping boxes
of one grid lie in neighbouring cells, and one of a coarser grid in a cell that the finer box
reaches when it is made wider by half a cell. So bodies of any sizes cost as much as bodies of one
size, wherever they are.

Cells that share a bucket are not told apart: to read whose cell a box is in costs more than to see
that it is elsewhere. So a pair may be found twice.

A pair is told by its code, ``i n + j`` for rows i < j of a world of n geometries.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.records import Plain
from drake_geom_ros.geometry._proximity.tolerances import EPS

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Links = NDArray[np.int32]

# A cell is wider than the boxes in it by more than rounding moves a centre: by a sixteenth, and by
# this share [-] of the farthest coordinate, of which a centre's cell is known to 2^-14 of a cell.
LOOSE = 1.0625
FARTHEST_CELL = 2.0**-38
STEP = 4.0  # from grid to grid
ORDINARY = 4.0  # times the mean width: such boxes make the cells of grid 0
MOST_GRIDS = 1200  # more than there are powers of four
GRID = (
    3  # column of ``cells``: the grid's number, whose cells are STEP^number times those of grid 0
)
BODIES, GRIDS, MASK = 0, 1, 2  # of ``counts``
# One of each two opposite neighbours of a cell.
FORWARD = np.array([c for c in np.ndindex(3, 3, 3) if c > (1, 1, 1)], dtype=np.int64) - 1

NOBODY = np.zeros(0, dtype=np.bool_)


class Boxes(NamedTuple):
    """Room for the boxes around n bodies, in hashed cells."""

    rows: Indices  # (n,) of the world
    bounds: (
        Floats  # (n, 6) lower and upper ends [m], in one place: a look at a box is one at memory
    )
    cells: Indices  # (n, 4) the cell along x, y and z, and its GRID
    widths: Floats  # (n,) the largest of each [m]
    nexts: Links  # (n,) the box that was put into the same bucket before; -1: none
    buckets: Links  # the box that was put into a bucket last; -1: none
    grids: Indices  # (MOST_GRIDS,) those that are in use
    counts: Indices  # (3,) of bodies and of grids; one less than the number of buckets
    width: Floats  # (1,) of the cells of grid 0 [m]


def room_for(count: int) -> Plain:
    """Return empty ``Boxes`` with room for some bodies, as a plain tuple."""
    buckets = 1 << max(2 * count - 1, 1).bit_length()
    return tuple(
        Boxes(
            rows=np.zeros(count, dtype=np.int64),
            bounds=np.zeros((count, 6)),
            cells=np.zeros((count, 4), dtype=np.int64),
            widths=np.zeros(count),
            nexts=np.zeros(count, dtype=np.int32),
            buckets=np.full(buckets, -1, dtype=np.int32),
            grids=np.zeros(MOST_GRIDS, dtype=np.int64),
            counts=np.zeros(3, dtype=np.int64),
            width=np.zeros(1),
        )
    )


@inlined
def _bucket(cell, mask):  # type: ignore[no-untyped-def]
    """Return the bucket of a cell (x, y, z, grid), mixed so that neighbours do not share one."""
    x, y, z, grid = cell
    low = 0x1FFFFF  # products of more digits would overflow
    return (
        ((x & low) * 73856093) ^ ((y & low) * 19349663) ^ ((z & low) * 83492791) ^ (grid * 6151)
    ) & mask


@inlined
def _overlap(bounds_a, a, bounds_b, b):  # type: ignore[no-untyped-def]
    """Tell whether two boxes share a point."""
    # Unsigned numbers: the test for negative ones takes as long as the comparison.
    a, b = np.uint64(a), np.uint64(b)
    return (
        bounds_a[a, 0] <= bounds_b[b, 3]
        and bounds_b[b, 0] <= bounds_a[a, 3]
        and bounds_a[a, 1] <= bounds_b[b, 4]
        and bounds_b[b, 1] <= bounds_a[a, 4]
        and bounds_a[a, 2] <= bounds_b[b, 5]
        and bounds_b[b, 2] <= bounds_a[a, 5]
    )


@inlined
def put_code(codes, count, i, j, n):  # type: ignore[no-untyped-def]
    """Append the code of a pair; beyond the room only count it."""
    if count < codes.size:
        codes[count] = min(i, j) * n + max(i, j)
    return count + 1


@inlined
def _grid_of(grids, used, grid):  # type: ignore[no-untyped-def]
    """Return the number of grids in use once this one is."""
    for k in range(used):
        if grids[k] == grid:
            return used
    grids[used] = grid
    return used + 1


@inlined
def _width_of(boxes, grid):  # type: ignore[no-untyped-def]
    """Return how wide the cells of a grid are [m]."""
    return boxes.width[0] * STEP**grid


@compiled
def _put_boxes(boxes, rows, p_WGs, half_extents, paddings):  # type: ignore[no-untyped-def]
    """Put in the boxes themselves, and set the width of cells; return the farthest coordinate."""
    total, farthest = 0.0, 0.0
    for k in range(rows.size):
        g, widest = rows[k], 0.0
        boxes.rows[k] = g
        for c in range(3):
            p, half = p_WGs[g, c], half_extents[g, c] + paddings[g]
            # What rounding may have taken off: a few spacings at the corners.
            half += 4.0 * EPS * (abs(p) + half)
            boxes.bounds[k, c], boxes.bounds[k, 3 + c] = p - half, p + half
            widest, farthest = max(widest, half), max(farthest, abs(p))
        boxes.widths[k] = 2.0 * widest
        total += 2.0 * widest
    base = 0.0
    for k in range(rows.size):
        if boxes.widths[k] * rows.size <= ORDINARY * total:
            base = max(base, boxes.widths[k])
    width = LOOSE * base + FARTHEST_CELL * farthest
    boxes.width[0] = width if width > 0.0 else 1.0
    return farthest


@inlined
def _finest(boxes, box, farthest):  # type: ignore[no-untyped-def]
    """Return the finest grid whose cells are wide enough for a box, and for where bodies are."""
    grid, width = 0, boxes.width[0]
    wanted = max(LOOSE * box, FARTHEST_CELL * farthest)
    while width < wanted:
        grid, width = grid + 1, width * STEP
    while width >= STEP * wanted and wanted > 0.0:
        grid, width = grid - 1, width / STEP
    return grid


@compiled
def put_in(boxes, rows, p_WGs, half_extents, paddings):  # type: ignore[no-untyped-def]
    """Put the boxes of rows (k,) of the world in, and nobody else, each wider by its padding.

    Paddings (n,) [m] are for every side, one for each row of the world.
    """
    boxes = Boxes(*boxes)
    size = 1
    while size < 2 * rows.size:
        size *= 2
    boxes.buckets[:size] = -1
    used, mask = 0, size - 1
    farthest = _put_boxes(boxes, rows, p_WGs, half_extents, paddings)
    for k in range(rows.size):
        grid = _finest(boxes, boxes.widths[k], farthest)
        used = _grid_of(boxes.grids, used, grid)
        width = _width_of(boxes, grid)
        for c in range(3):
            boxes.cells[k, c] = math.floor(p_WGs[rows[k], c] / width)
        boxes.cells[k, GRID] = grid
        cell = boxes.cells[k, 0], boxes.cells[k, 1], boxes.cells[k, 2], grid
        bucket = _bucket(cell, mask)
        boxes.nexts[k], boxes.buckets[bucket] = boxes.buckets[bucket], k
    boxes.counts[BODIES], boxes.counts[GRIDS], boxes.counts[MASK] = rows.size, used, mask


@inlined
def _in_bucket(A, a, B, first, skipped, n, codes, count):  # type: ignore[no-untyped-def]
    """Pair box a of A with those of B in a bucket, from the first one on."""
    b = first
    while b >= 0:
        if _overlap(A.bounds, a, B.bounds, b):
            i, j = A.rows[a], B.rows[b]
            if i != j and not (skipped.size > 0 and skipped[j]):
                count = put_code(codes, count, i, j, n)
        b = B.nexts[np.uint64(b)]
    return count


@inlined
def _cells_along(A, a, axis, width):  # type: ignore[no-untyped-def]
    """Return the first and the last cell along an axis that may hold the centre of a neighbour.

    Boxes in a cell are narrower than it, so their centres are less than half a cell away.
    """
    lower, upper = A.bounds[a, axis] - 0.5 * width, A.bounds[a, 3 + axis] + 0.5 * width
    return np.floor(lower / width), np.floor(upper / width)


@inlined
def _in_grid(A, a, B, grid, skipped, n, codes, count):  # type: ignore[no-untyped-def]
    """Pair box a of A with those of B in a grid."""
    width = _width_of(B, grid)
    x_0, x_1 = _cells_along(A, a, 0, width)
    y_0, y_1 = _cells_along(A, a, 1, width)
    z_0, z_1 = _cells_along(A, a, 2, width)
    mask, bodies = B.counts[MASK], B.counts[BODIES]
    if not (x_1 - x_0 + 1.0) * (y_1 - y_0 + 1.0) * (z_1 - z_0 + 1.0) <= bodies:
        for b in range(bodies):
            if _overlap(A.bounds, a, B.bounds, b) and B.cells[b, GRID] == grid:
                i, j = A.rows[a], B.rows[b]
                if i != j and not (skipped.size > 0 and skipped[j]):
                    count = put_code(codes, count, i, j, n)
        return count
    for x in range(int(x_0), int(x_1) + 1):
        for y in range(int(y_0), int(y_1) + 1):
            for z in range(int(z_0), int(z_1) + 1):
                first = B.buckets[np.uint64(_bucket((x, y, z, grid), mask))]
                count = _in_bucket(A, a, B, first, skipped, n, codes, count)
    return count


@compiled
def pairs_within(boxes, n, codes, count):  # type: ignore[no-untyped-def]
    """Append the pairs of boxes that overlap to the codes; return how many there are then."""
    boxes = Boxes(*boxes)
    cells, mask, nobody = boxes.cells, boxes.counts[MASK], NOBODY
    for a in range(boxes.counts[BODIES]):
        x, y, z, grid = cells[a, 0], cells[a, 1], cells[a, 2], cells[a, GRID]
        # Of its own cell those that were put in before.
        count = _in_bucket(boxes, a, boxes, boxes.nexts[a], nobody, n, codes, count)
        for k in range(FORWARD.shape[0]):
            cell = x + FORWARD[k, 0], y + FORWARD[k, 1], z + FORWARD[k, 2], grid
            first = boxes.buckets[np.uint64(_bucket(cell, mask))]
            count = _in_bucket(boxes, a, boxes, first, nobody, n, codes, count)
        for k in range(boxes.counts[GRIDS]):
            if boxes.grids[k] > grid:
                count = _in_grid(boxes, a, boxes, boxes.grids[k], nobody, n, codes, count)
    return count


@compiled
def pairs_between(some, others, skipped, n, codes, count):  # type: ignore[no-untyped-def]
    """Append the pairs of one of some boxes and one of others; return how many there are then.

    Those of ``others`` for which ``skipped`` (n,) holds are left out; none if it is empty.
    """
    some, others = Boxes(*some), Boxes(*others)
    for a in range(some.counts[BODIES]):
        for k in range(others.counts[GRIDS]):
            count = _in_grid(some, a, others, others.grids[k], skipped, n, codes, count)
    return count
