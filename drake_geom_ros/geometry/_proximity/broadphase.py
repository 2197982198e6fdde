"""Broad phase: from boxes to the pairs that overlap, by a hierarchy of hashed grids.

Each body is put into the cell that holds its centre, of a grid whose cells are one to four times
as wide as its box (Ericson, *Real-Time Collision Detection*, 2005, section 7.2). Overlapping boxes
of one grid lie in neighbouring cells, and one of a coarser grid in a cell that the finer box
reaches when it is made wider by half a cell. So bodies of any sizes cost as much as bodies of one
size, wherever they are.

Boxes are stored in the order of their buckets, and cells beside each other along x have buckets
beside each other: what is near is near in memory, and three cells are one look. Cells that share
a bucket are not told apart, for to see that a box is elsewhere costs no more. So a pair may be
found twice.

Whoever looks at each body's neighbours makes no call with ``Boxes`` for each: to hand their arrays
over takes as long as the look (127 instead of 18 ns a body).

A pair is told by its code, ``i 2^32 + j`` for rows i < j of the world.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.handing import (
    Bounds,
    Cells,
    Integers,
    Reals,
    SingleRows,
)
from drake_geom_ros.geometry._proximity.kernels.side_by_side import (
    LANES,
    above,
    below,
    empty_sides,
    first_lanes,
    lowest,
    overlapping,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS

# A cell is wider than the boxes in it by more than rounding moves a centre: by a sixteenth, and by
# this share [-] of the farthest coordinate, of which a centre's cell is known to 2^-14 of a cell.
LOOSE = 1.0625
FARTHEST_CELL = 2.0**-38
WIDEST = 1e300  # [m] cells wider than this hold every coordinate that there is, and may overflow
STEP = 4.0  # from grid to grid
ORDINARY = 4.0  # times the mean width: such boxes make the cells of grid 0
MOST_GRIDS = 1200  # more than there are powers of four
MOST_BUCKETS = 2**21
ROW_BITS, SECOND_ROW = 32, 2**32 - 1  # of a code
GRID = 3  # column of ``cells``: the grid's number; its cells are STEP^number those of grid 0
BODIES, GRIDS, MASK, STEP_Y, STEP_Z = 0, 1, 2, 3, 4  # of ``counts``
LOWER, UPPER = 0, 3  # columns of ``bounds``, 3 each
# Rows of cells along x, by their steps in y and z: one of each two that are opposite each other.
FORWARD = np.array([(1, 0), (-1, 1), (0, 1), (1, 1)], dtype=np.int64)


class Boxes(NamedTuple):
    """Room for the boxes around n bodies, in hashed cells, by their buckets."""

    rows: Integers  # (n,) of the world
    bounds: Bounds  # (n, 6) LOWER and UPPER ends [m], in one place of memory
    sides: SingleRows  # (6, n + LANES) the same, see ``kernels.side_by_side``
    cells: Cells  # (n, 4) the cell along x, y and z, and its GRID
    starts: Integers  # (buckets + 1,) where the boxes of each bucket begin
    grids: Integers  # (MOST_GRIDS,) those that are in use
    # (5,) of bodies and of grids; one less than the number of buckets; buckets from one cell to
    # the next along y and z
    counts: Integers
    width: Reals  # (1,) of the cells of grid 0 [m]
    # While boxes are put in, in the order of the rows that are given.
    widths: Reals  # (n,) the largest of each [m]
    found: Cells  # (n, 4) the cells
    buckets: Integers  # (n,)


def room_for(count: int) -> Boxes:
    """Return empty ``Boxes`` with room for some bodies."""
    buckets = 2 << max(2 * count - 1, 1).bit_length()  # twice what ``put_in`` begins with
    return Boxes(
        rows=np.zeros(count, dtype=np.int64),
        bounds=np.zeros((count, 6)),
        sides=empty_sides(count),
        cells=np.zeros((count, 4), dtype=np.int64),
        starts=np.zeros(buckets + 1, dtype=np.int64),
        grids=np.zeros(MOST_GRIDS, dtype=np.int64),
        counts=np.zeros(5, dtype=np.int64),
        width=np.zeros(1),
        widths=np.zeros(count),
        found=np.zeros((count, 4), dtype=np.int64),
        buckets=np.zeros(count, dtype=np.int64),
    )


@inlined
def _bucket(counts, x, y, z, grid):  # type: ignore[no-untyped-def]
    """Return the bucket of a cell: in a row along x one follows the other."""
    low = MOST_BUCKETS - 1  # products of more digits would overflow
    row = (y & low) * counts[STEP_Y] + (z & low) * counts[STEP_Z] + grid * 6151
    return (row + x) & counts[MASK]


@inlined
def _overlap(bounds_a, a, bounds_b, b):  # type: ignore[no-untyped-def]
    """Tell whether two boxes share a point."""
    # Unsigned numbers: the test for negative ones takes as long as the comparison.
    a, b = np.uint64(a), np.uint64(b)
    # Without branches, of which each but the last would be guessed wrong as often as not.
    return (
        (bounds_a[a, LOWER] <= bounds_b[b, UPPER])
        & (bounds_b[b, LOWER] <= bounds_a[a, UPPER])
        & (bounds_a[a, LOWER + 1] <= bounds_b[b, UPPER + 1])
        & (bounds_b[b, LOWER + 1] <= bounds_a[a, UPPER + 1])
        & (bounds_a[a, LOWER + 2] <= bounds_b[b, UPPER + 2])
        & (bounds_b[b, LOWER + 2] <= bounds_a[a, UPPER + 2])
    )


@inlined
def code_of(i, j):  # type: ignore[no-untyped-def]
    """Return the code of a pair of rows."""
    return (min(i, j) << ROW_BITS) | max(i, j)


@inlined
def rows_of(code):  # type: ignore[no-untyped-def]
    """Return the rows i < j of a code."""
    return code >> ROW_BITS, code & SECOND_ROW


@inlined
def put_code(codes, count, i, j, kept):  # type: ignore[no-untyped-def]
    """Append the code of a pair if it is ``kept``; return how many there are then.

    There is no branch, which for a pair of neighbours would be guessed wrong too often. So the
    last place of the codes, of which there is one at least, is for those that are not kept, and
    for those that there is no room for.
    """
    codes[np.uint64(min(count, codes.size - 1))] = code_of(i, j)
    return count + kept


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


@inlined
def _half(p_WGs, half_extents, paddings, g, c):  # type: ignore[no-untyped-def]
    """Return half the extent [m] of a padded box along an axis."""
    half = half_extents[g, c] + paddings[g]
    # What rounding may have taken off: a few spacings at the corners.
    return half + 4.0 * EPS * (abs(p_WGs[g, c]) + half)


@compiled
def _choose_width(boxes, rows, p_WGs, half_extents, paddings):  # type: ignore[no-untyped-def]
    """Set the width of cells, and of each box; return the least and largest coordinates [m]."""
    total, farthest, base = 0.0, 0.0, 0.0
    least, largest = (math.inf, math.inf, math.inf), (-math.inf, -math.inf, -math.inf)
    for k in range(rows.size):
        g, widest = rows[k], 0.0
        x, y, z = p_WGs[g, 0], p_WGs[g, 1], p_WGs[g, 2]
        least = min(least[0], x), min(least[1], y), min(least[2], z)
        largest = max(largest[0], x), max(largest[1], y), max(largest[2], z)
        for c in range(3):
            widest = max(widest, _half(p_WGs, half_extents, paddings, g, c))
        boxes.widths[k] = min(2.0 * widest, WIDEST)
        total += boxes.widths[k]
    for k in range(rows.size):
        if boxes.widths[k] * rows.size <= ORDINARY * total:
            base = max(base, boxes.widths[k])
    for c in range(3):
        farthest = max(farthest, -least[c], largest[c])
    width = LOOSE * base + FARTHEST_CELL * farthest
    boxes.width[0] = width if width > 0.0 else 1.0
    return least, largest, farthest


@inlined
def _choose_buckets(boxes, count, least, largest):  # type: ignore[no-untyped-def]
    """Choose how many buckets there are, and how far apart in them rows of cells are.

    Where there can be a bucket for each cell of the room that the bodies are in, rows stand in
    order, with an empty cell between two: what is near is near in memory. Else they are mixed.
    """
    width, size = boxes.width[0], 1
    while size < min(2 * count, MOST_BUCKETS):
        size *= 2
    nx = np.floor(largest[0] / width) - np.floor(least[0] / width) + 2.0
    ny = np.floor(largest[1] / width) - np.floor(least[1] / width) + 2.0
    nz = np.floor(largest[2] / width) - np.floor(least[2] / width) + 2.0
    cells, step_y, step_z = nx * ny * nz, 19349663, 83492791
    if 0.0 < cells <= min(2.0 * size, MOST_BUCKETS):  # of nobody it is infinite
        step_y, step_z = int(nx), int(nx * ny)
        if cells > size:
            size *= 2
    boxes.counts[MASK], boxes.counts[STEP_Y], boxes.counts[STEP_Z] = size - 1, step_y, step_z


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
def _find_cells(boxes, rows, p_WGs, farthest):  # type: ignore[no-untyped-def]
    """Find the cell and the bucket of each, and count those in each bucket at its place."""
    used = 0
    boxes.starts[: boxes.counts[MASK] + 2] = 0
    for k in range(rows.size):
        grid = _finest(boxes, boxes.widths[k], farthest)
        used = _grid_of(boxes.grids, used, grid)
        width = _width_of(boxes, grid)
        for c in range(3):
            boxes.found[k, c] = math.floor(p_WGs[rows[k], c] / width)
        boxes.found[k, GRID] = grid
        x, y, z = boxes.found[k, 0], boxes.found[k, 1], boxes.found[k, 2]
        bucket = _bucket(boxes.counts, x, y, z, grid)
        boxes.buckets[k] = bucket
        boxes.starts[bucket] += 1
    boxes.counts[BODIES], boxes.counts[GRIDS] = rows.size, used


@compiled
def put_in(boxes, rows, p_WGs, half_extents, paddings):  # type: ignore[no-untyped-def]
    """Put the boxes of rows (k,) of the world in, and nobody else, each wider by its padding.

    Paddings (n,) [m] are for every side, one for each row of the world.
    """
    least, largest, farthest = _choose_width(boxes, rows, p_WGs, half_extents, paddings)
    _choose_buckets(boxes, rows.size, least, largest)
    _find_cells(boxes, rows, p_WGs, farthest)
    total = 0
    for bucket in range(boxes.counts[MASK] + 2):
        total += boxes.starts[bucket]
        boxes.starts[bucket] = total
    # From the ends of the buckets back: then their starts are what is left.
    for k in range(rows.size - 1, -1, -1):
        boxes.starts[boxes.buckets[k]] -= 1
        at, g = boxes.starts[boxes.buckets[k]], rows[k]
        boxes.rows[at] = g
        for c in range(3):
            p, half = p_WGs[g, c], _half(p_WGs, half_extents, paddings, g, c)
            boxes.bounds[at, LOWER + c], boxes.bounds[at, UPPER + c] = p - half, p + half
            boxes.sides[LOWER + c, at] = below(p - half)
            boxes.sides[UPPER + c, at] = above(p + half)
        for c in range(4):
            boxes.cells[at, c] = boxes.found[k, c]


@inlined
def _box_of(A, a):  # type: ignore[no-untyped-def]
    """Return the six sides of box a of A, as those are that it is compared with."""
    sides = A.sides
    return sides[0, a], sides[1, a], sides[2, a], sides[3, a], sides[4, a], sides[5, a]


@inlined
def _put_pair(A, a, B, b, skipped, codes, count):  # type: ignore[no-untyped-def]
    """Append the pair of two boxes if they overlap, are not of one body, and b is not skipped."""
    i, j = A.rows[np.uint64(a)], B.rows[np.uint64(b)]
    kept = _overlap(A.bounds, a, B.bounds, b) & (i != j)
    if skipped.size > 0:
        kept = kept & (not skipped[j])
    return put_code(codes, count, i, j, kept)


@inlined
def _among(A, a, box, B, first, last, skipped, codes, count):  # type: ignore[no-untyped-def]
    """Pair box a of A with those of B from the first up to the last, without it."""
    while first < last:
        bits = overlapping(B.sides, first, box) & first_lanes(last - first)
        while bits != 0:
            count = _put_pair(A, a, B, first + lowest(bits), skipped, codes, count)
            bits &= bits - 1
        first += LANES
    return count


@inlined
def _in_row(A, a, box, B, bucket, cells, skipped, codes, count):  # type: ignore[no-untyped-def]
    """Pair box a of A with those of B in some cells along x, the first of which has a bucket."""
    over = bucket + cells - 1 - B.counts[MASK]
    if over <= 0:
        first, last = B.starts[np.uint64(bucket)], B.starts[np.uint64(bucket + cells)]
        return _among(A, a, box, B, first, last, skipped, codes, count)
    # The row goes on at the first bucket.
    first, last = B.starts[np.uint64(bucket)], B.counts[BODIES]
    count = _among(A, a, box, B, first, last, skipped, codes, count)
    return _among(A, a, box, B, 0, B.starts[np.uint64(over)], skipped, codes, count)


@inlined
def _cells_along(A, a, axis, width):  # type: ignore[no-untyped-def]
    """Return the first and the last cell along an axis that may hold the centre of a neighbour.

    Boxes in a cell are narrower than it, so their centres are less than half a cell away.
    """
    lower, upper = A.bounds[a, LOWER + axis] - 0.5 * width, A.bounds[a, UPPER + axis] + 0.5 * width
    return np.floor(lower / width), np.floor(upper / width)


@inlined
def _in_grid(A, a, box, B, grid, skipped, codes, count):  # type: ignore[no-untyped-def]
    """Pair box a of A with those of B in a grid."""
    width = _width_of(B, grid)
    x_0, x_1 = _cells_along(A, a, 0, width)
    y_0, y_1 = _cells_along(A, a, 1, width)
    z_0, z_1 = _cells_along(A, a, 2, width)
    bodies = B.counts[BODIES]
    if not (x_1 - x_0 + 1.0) * (y_1 - y_0 + 1.0) * (z_1 - z_0 + 1.0) <= bodies:
        for b in range(bodies):
            if B.cells[b, GRID] == grid:
                count = _put_pair(A, a, B, b, skipped, codes, count)
        return count
    for y in range(int(y_0), int(y_1) + 1):
        for z in range(int(z_0), int(z_1) + 1):
            bucket, cells = _bucket(B.counts, int(x_0), y, z, grid), int(x_1 - x_0) + 1
            count = _in_row(A, a, box, B, bucket, cells, skipped, codes, count)
    return count


@compiled
def pairs_within(boxes, nobody, codes, count):  # type: ignore[no-untyped-def]
    """Append the pairs of boxes that overlap to the codes; return how many there are then.

    ``nobody`` is empty, and handed over: as a constant it would be of another type than
    ``skipped`` elsewhere, and everything below would be compiled twice.
    """
    cells, counts, starts = boxes.cells, boxes.counts, boxes.starts
    mask, bodies = counts[MASK], counts[BODIES]
    for a in range(bodies):
        grid, box = cells[a, GRID], _box_of(boxes, a)
        bucket = _bucket(counts, cells[a, 0], cells[a, 1], cells[a, 2], grid)
        # Those behind it in its own cell, and the next cell, which begins where that one ends.
        last = starts[np.uint64(min(bucket + 2, mask + 1))]
        count = _among(boxes, a, box, boxes, a + 1, last, nobody, codes, count)
        if bucket == mask:
            count = _among(boxes, a, box, boxes, 0, starts[1], nobody, codes, count)
        for k in range(FORWARD.shape[0]):
            aside = FORWARD[k, 0] * counts[STEP_Y] + FORWARD[k, 1] * counts[STEP_Z]
            row = (bucket - 1 + aside) & mask
            count = _in_row(boxes, a, box, boxes, row, 3, nobody, codes, count)
        for k in range(counts[GRIDS]):
            if boxes.grids[k] > grid:
                count = _in_grid(boxes, a, box, boxes, boxes.grids[k], nobody, codes, count)
    return count


@compiled
def pairs_between(some, others, skipped, codes, count):  # type: ignore[no-untyped-def]
    """Append the pairs of one of some boxes and one of others; return how many there are then.

    Those of ``others`` for which ``skipped`` (n,) holds are left out; none if it is empty.
    """
    for a in range(some.counts[BODIES]):
        box = _box_of(some, a)
        for k in range(others.counts[GRIDS]):
            count = _in_grid(some, a, box, others, others.grids[k], skipped, codes, count)
    return count
