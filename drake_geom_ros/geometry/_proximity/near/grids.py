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

``grid_pairs`` finds which boxes overlap.

A pair is told by its code, ``i 2^32 + j`` for rows i < j of the world.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.near.box_lanes import (
    LANES,
    above,
    below,
    empty_sides,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Bounds,
    IndexPairs,
    Integers,
    Reals,
    SingleRows,
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
# Columns of ``cells``. A grid's number tells how wide its cells are: STEP^number those of grid 0.
BUCKET, GRID = 0, 1
BODIES, GRIDS, MASK, STEP_Y, STEP_Z = 0, 1, 2, 3, 4  # of ``counts``
PLACES = 63 // LANES  # whose boxes' bits are one number
LOWER, UPPER = 0, 3  # columns of ``bounds``, 3 each


class Boxes(NamedTuple):
    """Room for the boxes around n bodies, in hashed cells, by their buckets."""

    rows: Integers  # (n,) of the world
    bounds: Bounds  # (n, 6) LOWER and UPPER ends [m], in one place of memory
    sides: SingleRows  # (6, n + LANES) the same, see ``box_lanes``
    cells: IndexPairs  # (n, 2) BUCKET and GRID of each cell
    starts: Integers  # (buckets + 1,) where the boxes of each bucket begin
    grids: Integers  # (MOST_GRIDS,) those that are in use
    # (5,) of bodies and of grids; one less than the number of buckets; buckets from one cell to
    # the next along y and z
    counts: Integers
    places: Integers  # (PLACES,) where rows of cells begin whose boxes are looked at together
    width: Reals  # (1,) of the cells of grid 0 [m]
    # While boxes are put in, in the order of the rows that are given.
    widths: Reals  # (n,) the largest of each [m]
    found: IndexPairs  # (n, 2) the cells


def room_for(count: int) -> Boxes:
    """Return empty ``Boxes`` with room for some bodies."""
    buckets = 2 << max(2 * count - 1, 1).bit_length()  # twice what ``put_in`` begins with
    return Boxes(
        rows=np.zeros(count, dtype=np.int64),
        bounds=np.zeros((count, 6)),
        sides=empty_sides(count),
        cells=np.zeros((count, 2), dtype=np.int64),
        starts=np.zeros(buckets + 1, dtype=np.int64),
        grids=np.zeros(MOST_GRIDS, dtype=np.int64),
        counts=np.zeros(5, dtype=np.int64),
        places=np.zeros(PLACES, dtype=np.int64),
        width=np.zeros(1),
        widths=np.zeros(count),
        found=np.zeros((count, 2), dtype=np.int64),
    )


@inlined
def bucket_of(counts: Indices, x: int, y: int, z: int, grid: int) -> int:
    """Return the bucket of a cell: in a row along x one follows the other."""
    low = MOST_BUCKETS - 1  # products of more digits would overflow
    row = (y & low) * counts[STEP_Y] + (z & low) * counts[STEP_Z] + grid * 6151
    return (row + x) & counts[MASK]


@inlined
def code_of(i: int, j: int) -> int:
    """Return the code of a pair of rows."""
    return (min(i, j) << ROW_BITS) | max(i, j)


@inlined
def rows_of(code: int) -> tuple[int, int]:
    """Return the rows i < j of a code."""
    return code >> ROW_BITS, code & SECOND_ROW


@inlined
def put_code(codes: Indices, count: int, i: int, j: int, kept: bool) -> int:
    """Append the code of a pair if it is ``kept``; return how many there are then.

    There is no branch, which for a pair of neighbours would be guessed wrong too often. So the
    last place of the codes, of which there is one at least, is for those that are not kept, and
    for those that there is no room for.
    """
    codes[unsigned(min(count, codes.size - 1))] = code_of(i, j)
    return count + kept


@inlined
def _grid_of(grids: Indices, used: int, grid: int) -> int:
    """Return the number of grids in use once this one is."""
    for k in range(used):
        if grids[k] == grid:
            return used
    grids[used] = grid
    return used + 1


@inlined
def width_of(boxes: Boxes, grid: int) -> float:
    """Return how wide the cells of a grid are [m]."""
    return boxes.width[0] * STEP**grid


@inlined
def _half(p_WGs: Floats, half_extents: Floats, paddings: Floats, g: int, c: int) -> float:
    """Return half the extent [m] of a padded box along an axis."""
    half = half_extents[g, c] + paddings[g]
    # What rounding may have taken off: a few spacings at the corners.
    return half + 4.0 * EPS * (abs(p_WGs[g, c]) + half)


@compiled
def _choose_width(
    boxes: Boxes, rows: Indices, p_WGs: Floats, half_extents: Floats, paddings: Floats
) -> tuple[Vector, Vector, float]:
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
def _choose_buckets(boxes: Boxes, count: int, least: Vector, largest: Vector) -> None:
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
def _finest(boxes: Boxes, box: float, farthest: float) -> tuple[int, float]:
    """Return the finest grid whose cells are wide enough for a box, and for where bodies are.

    And how wide they are [m].
    """
    grid, width = 0, boxes.width[0]
    wanted = max(LOOSE * box, FARTHEST_CELL * farthest)
    while width < wanted:
        grid, width = grid + 1, width * STEP
    while width >= STEP * wanted and wanted > 0.0:
        grid, width = grid - 1, width / STEP
    return grid, width


@compiled
def _find_cells(boxes: Boxes, rows: Indices, p_WGs: Floats, farthest: float) -> None:
    """Find the cell and the bucket of each, and count those in each bucket at its place."""
    used = 0
    boxes.starts[: boxes.counts[MASK] + 2] = 0
    for k in range(rows.size):
        grid, width = _finest(boxes, boxes.widths[k], farthest)
        used = _grid_of(boxes.grids, used, grid)
        g = rows[k]
        x, y = math.floor(p_WGs[g, 0] / width), math.floor(p_WGs[g, 1] / width)
        bucket = bucket_of(boxes.counts, x, y, math.floor(p_WGs[g, 2] / width), grid)
        boxes.found[k, BUCKET], boxes.found[k, GRID] = bucket, grid
        boxes.starts[bucket] += 1
    boxes.counts[BODIES], boxes.counts[GRIDS] = rows.size, used


@compiled
def put_in(
    boxes: Boxes, rows: Indices, p_WGs: Floats, half_extents: Floats, paddings: Floats
) -> None:
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
        bucket = boxes.found[k, BUCKET]
        boxes.starts[bucket] -= 1
        at, g = boxes.starts[bucket], rows[k]
        boxes.rows[at] = g
        for c in range(3):
            p, half = p_WGs[g, c], _half(p_WGs, half_extents, paddings, g, c)
            boxes.bounds[at, LOWER + c], boxes.bounds[at, UPPER + c] = p - half, p + half
        boxes.cells[at, BUCKET], boxes.cells[at, GRID] = bucket, boxes.found[k, GRID]
    # In order, side by side: six places far apart for each in the order of the rows take longer.
    for c in range(3):
        for at in range(rows.size):
            boxes.sides[LOWER + c, at] = below(boxes.bounds[at, LOWER + c])
            boxes.sides[UPPER + c, at] = above(boxes.bounds[at, UPPER + c])
