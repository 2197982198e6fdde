"""Hierarchy of hashed grids of boxes, for the broad phase of many bodies.

Each body is put into the cell that holds its centre, of a grid whose cells are one to four times
as wide as its box (Ericson, *Real-Time Collision Detection*, 2005, section 7.2). Overlapping boxes
of one grid lie in neighbouring cells, and one of a coarser grid in a cell that the finer box
reaches when extended by half a cell. So bodies of mixed sizes cost as much as bodies of one size,
wherever they are.

Boxes are stored in the order of their buckets, and neighbouring cells along x have neighbouring
buckets: near bodies are near in memory, and three cells are one comparison. Cells that share a
bucket are not distinguished, since comparing the boxes costs no more. So a pair may be found
twice.

``grid_pairs`` finds the boxes that overlap. A pair is identified by its code, ``i 2^32 + j`` for
rows i < j of the world.
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

# A cell is wider than its boxes by more than rounding moves a centre: by a sixteenth, and by this
# fraction [-] of the farthest coordinate, with which the position in a cell is known to 2^-14.
LOOSE = 1.0625
FARTHEST_CELL = 2.0**-38
WIDEST = 1e300  # [m] a wider cell holds every coordinate, and may overflow
STEP = 4.0  # ratio of cell widths from grid to grid
ORDINARY = 4.0  # times the mean width: boxes up to this set the cell width of grid 0
MOST_GRIDS = 1200  # more than there are powers of four
MOST_BUCKETS = 2**21
ROW_BITS, SECOND_ROW = 32, 2**32 - 1  # of a code
# Columns of ``cells``. Cells of a grid are STEP^number times as wide as those of grid 0.
BUCKET, GRID = 0, 1
BODIES, GRIDS, MASK, STEP_Y, STEP_Z = 0, 1, 2, 3, 4  # of ``counts``
PLACES = 63 // LANES  # rows of cells whose bits fit into one number
LOWER, UPPER = 0, 3  # columns of ``bounds``, 3 each


class Boxes(NamedTuple):
    """Arrays for the boxes around n bodies, in hashed cells, sorted by bucket."""

    rows: Integers  # (n,) of the world
    bounds: Bounds  # (n, 6) LOWER and UPPER ends [m], contiguous per box
    sides: SingleRows  # (6, n + LANES) the same in single precision, see ``box_lanes``
    cells: IndexPairs  # (n, 2) BUCKET and GRID of each cell
    starts: Integers  # (buckets + 1,) where the boxes of each bucket begin
    grids: Integers  # (MOST_GRIDS,) numbers of the grids in use
    # (5,) numbers of bodies and of grids; number of buckets minus 1; buckets from one cell to the
    # next along y and z
    counts: Integers
    places: Integers  # (PLACES,) starts of the rows of cells that are compared together
    width: Reals  # (1,) of the cells of grid 0 [m]
    # Scratch of ``put_in``, in the order of its rows.
    widths: Reals  # (n,) the largest of each [m]
    unsorted_cells: IndexPairs  # (n, 2) BUCKET and GRID


def room_for(count: int) -> Boxes:
    """Return empty ``Boxes`` with capacity for ``count`` bodies."""
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
        unsorted_cells=np.zeros((count, 2), dtype=np.int64),
    )


def rename_rows(boxes: Boxes, places: Indices) -> None:
    """Give bodies their rows of now, ``places`` (n,) by those before; -1: a body is gone."""
    count = int(boxes.counts[BODIES])
    rows = places[boxes.rows[:count]]
    gone = np.flatnonzero(rows < 0)
    rows[gone] = 0
    boxes.rows[:count] = rows
    for side, nowhere in ((LOWER, math.inf), (UPPER, -math.inf)):
        boxes.bounds[gone, side : side + 3] = nowhere
        boxes.sides[side : side + 3, gone] = nowhere


@inlined
def bucket_of(counts: Indices, x: int, y: int, z: int, grid: int) -> int:
    """Return the bucket of a cell; buckets are consecutive along x."""
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
def put_code(codes: Indices, count: int, i: int, j: int, is_pair: bool) -> int:
    """Append the code of a pair if ``is_pair``; return the new number of codes.

    There is no branch, which would often be mispredicted for neighbours. So the last place of the
    codes, which must exist, takes codes of rejected pairs and of pairs that do not fit.
    """
    codes[unsigned(min(count, codes.size - 1))] = code_of(i, j)
    return count + is_pair


@inlined
def _grid_of(grids: Indices, used: int, grid: int) -> int:
    """Return the number of grids in use after adding this one."""
    for k in range(used):
        if grids[k] == grid:
            return used
    grids[used] = grid
    return used + 1


@inlined
def width_of(boxes: Boxes, grid: int) -> float:
    """Return the width of the cells of a grid [m]."""
    return boxes.width[0] * STEP**grid


@inlined
def _half(p_WGs: Floats, half_extents: Floats, paddings: Floats, g: int, c: int) -> float:
    """Return half the extent [m] of a padded box along an axis."""
    half = half_extents[g, c] + paddings[g]
    # Rounding may have reduced it by a few spacings at the corners.
    return half + 4.0 * EPS * (abs(p_WGs[g, c]) + half)


@compiled
def _choose_width(
    boxes: Boxes, rows: Indices, p_WGs: Floats, half_extents: Floats, paddings: Floats
) -> tuple[Vector, Vector, float]:
    """Set the widths of cells and boxes; return least, largest and farthest coordinates [m]."""
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
    """Choose the number of buckets, and the steps between rows of cells in them.

    Where every cell of the bodies' bounding box can have its own bucket, rows are in order, with
    an empty cell between two: near bodies are near in memory. Otherwise rows are hashed.
    """
    width, size = boxes.width[0], 1
    while size < min(2 * count, MOST_BUCKETS):
        size *= 2
    nx = np.floor(largest[0] / width) - np.floor(least[0] / width) + 2.0
    ny = np.floor(largest[1] / width) - np.floor(least[1] / width) + 2.0
    nz = np.floor(largest[2] / width) - np.floor(least[2] / width) + 2.0
    cells, step_y, step_z = nx * ny * nz, 19349663, 83492791
    if 0.0 < cells <= min(2.0 * size, MOST_BUCKETS):  # infinite without bodies
        step_y, step_z = int(nx), int(nx * ny)
        if cells > size:
            size *= 2
    boxes.counts[MASK], boxes.counts[STEP_Y], boxes.counts[STEP_Z] = size - 1, step_y, step_z


@inlined
def _finest(boxes: Boxes, box: float, farthest: float) -> tuple[int, float]:
    """Return the finest grid whose cells are wide enough for a box, and their width [m].

    They also have to be wide enough for the farthest coordinate [m].
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
    """Find the cell and bucket of each body, and count the bodies in each bucket."""
    used = 0
    boxes.starts[: boxes.counts[MASK] + 2] = 0
    for k in range(rows.size):
        grid, width = _finest(boxes, boxes.widths[k], farthest)
        used = _grid_of(boxes.grids, used, grid)
        g = rows[k]
        x, y = math.floor(p_WGs[g, 0] / width), math.floor(p_WGs[g, 1] / width)
        bucket = bucket_of(boxes.counts, x, y, math.floor(p_WGs[g, 2] / width), grid)
        boxes.unsorted_cells[k, BUCKET], boxes.unsorted_cells[k, GRID] = bucket, grid
        boxes.starts[bucket] += 1
    boxes.counts[BODIES], boxes.counts[GRIDS] = rows.size, used


@compiled
def put_in(
    boxes: Boxes, rows: Indices, p_WGs: Floats, half_extents: Floats, paddings: Floats
) -> None:
    """Fill ``boxes`` with those of rows (k,) of the world, each extended by its padding.

    Paddings (n,) [m], one per row of the world, extend every side.
    """
    least, largest, farthest = _choose_width(boxes, rows, p_WGs, half_extents, paddings)
    _choose_buckets(boxes, rows.size, least, largest)
    _find_cells(boxes, rows, p_WGs, farthest)
    total = 0
    for bucket in range(boxes.counts[MASK] + 2):
        total += boxes.starts[bucket]
        boxes.starts[bucket] = total
    # Filled backwards from the ends of the buckets, which turns the ends into starts.
    for k in range(rows.size - 1, -1, -1):
        bucket = boxes.unsorted_cells[k, BUCKET]
        boxes.starts[bucket] -= 1
        at, g = boxes.starts[bucket], rows[k]
        boxes.rows[at] = g
        for c in range(3):
            p, half = p_WGs[g, c], _half(p_WGs, half_extents, paddings, g, c)
            boxes.bounds[at, LOWER + c], boxes.bounds[at, UPPER + c] = p - half, p + half
        boxes.cells[at, BUCKET], boxes.cells[at, GRID] = bucket, boxes.unsorted_cells[k, GRID]
    # In the order of memory: writing six distant places per body takes longer.
    for c in range(3):
        for at in range(rows.size):
            boxes.sides[LOWER + c, at] = below(boxes.bounds[at, LOWER + c])
            boxes.sides[UPPER + c, at] = above(boxes.bounds[at, UPPER + c])
