"""Pairs of overlapping boxes, by a look at the cells around each: see ``grids``.

The boxes in a row of cells along x are one after the other in memory, and looked at together; the
bits of all rows around a body are one number, which is gone through in the end. (To go through
those of each row at once, a branch was guessed wrong for every other row.)

Whoever looks at each body's neighbours makes no call with ``Boxes`` for each: to hand their arrays
over takes as long as the look (127 instead of 18 ns a body).
"""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry._proximity.near.box_lanes import (
    LANES,
    box_at,
    first_lanes,
    lowest,
    overlapping,
)
from drake_geom_ros.geometry._proximity.near.grids import (
    BODIES,
    BUCKET,
    GRID,
    GRIDS,
    LOWER,
    MASK,
    PLACES,
    STEP_Y,
    STEP_Z,
    UPPER,
    Boxes,
    bucket_of,
    put_code,
    width_of,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Indices, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined

# Rows of cells along x, by their steps in y and z: one of each two that are opposite each other.
FORWARD = np.array([(1, 0), (-1, 1), (0, 1), (1, 1)], dtype=np.int64)


@inlined
def _overlap(bounds_a: Floats, a: int, bounds_b: Floats, b: int) -> bool:
    """Tell whether two boxes share a point."""
    # Unsigned numbers: the test for negative ones takes as long as the comparison.
    a, b = unsigned(a), unsigned(b)
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
def _put_pair(
    A: Boxes, a: int, B: Boxes, b: int, skipped: Booleans, codes: Indices, count: int
) -> int:
    """Append the pair of two boxes if they overlap, are not of one body, and b is not skipped."""
    i, j = A.rows[unsigned(a)], B.rows[unsigned(b)]
    kept = _overlap(A.bounds, a, B.bounds, b) & (i != j)
    if skipped.size > 0:
        kept = kept & (not skipped[j])
    return put_code(codes, count, i, j, kept)


@inlined
def _put_found(
    A: Boxes, a: int, B: Boxes, bits: int, skipped: Booleans, codes: Indices, count: int
) -> int:
    """Pair box a of A with the boxes of B that were found, LANES bits for each of its places."""
    while bits != 0:
        found = lowest(bits)
        b = B.places[unsigned(found // LANES)] + found % LANES
        count = _put_pair(A, a, B, b, skipped, codes, count)
        bits &= bits - 1
    return count


@inlined
def _among(
    A: Boxes,
    a: int,
    box: tuple[float, float, float, float, float, float],
    B: Boxes,
    first: int,
    last: int,
    skipped: Booleans,
    codes: Indices,
    count: int,
) -> int:
    """Pair box a of A with those of B from the first up to the last, without it."""
    while first < last:
        bits = overlapping(B.sides, first, box) & first_lanes(last - first)
        while bits != 0:
            count = _put_pair(A, a, B, first + lowest(bits), skipped, codes, count)
            bits &= bits - 1
        first += LANES
    return count


@inlined
def _look(
    A: Boxes,
    a: int,
    box: tuple[float, float, float, float, float, float],
    B: Boxes,
    first: int,
    end: int,
    used: int,
    skipped: Booleans,
    codes: Indices,
    count: int,
) -> tuple[int, int]:
    """Look at the boxes of B from the first one up to where the bucket ``end`` begins.

    Return the bits of LANES of them, for the place number ``used``, and how many pairs there are
    with what is beyond these.
    """
    buckets = B.counts[MASK] + 1
    last = B.starts[unsigned(min(end, buckets))]
    B.places[unsigned(used)] = first
    bits = overlapping(B.sides, first, box) & first_lanes(max(last - first, 0))
    if last - first > LANES:
        count = _among(A, a, box, B, first + LANES, last, skipped, codes, count)
    if end > buckets:  # the row goes on at the first bucket
        last = B.starts[unsigned(end - buckets)]
        count = _among(A, a, box, B, 0, last, skipped, codes, count)
    return bits << (LANES * used), count


@inlined
def _cells_along(A: Boxes, a: int, axis: int, width: float) -> tuple[float, float]:
    """Return the first and the last cell along an axis that may hold the centre of a neighbour.

    Boxes in a cell are narrower than it, so their centres are less than half a cell away.
    """
    lower, upper = A.bounds[a, LOWER + axis] - 0.5 * width, A.bounds[a, UPPER + axis] + 0.5 * width
    return np.floor(lower / width), np.floor(upper / width)


@inlined
def _in_grid(
    A: Boxes,
    a: int,
    box: tuple[float, float, float, float, float, float],
    B: Boxes,
    grid: int,
    skipped: Booleans,
    codes: Indices,
    count: int,
) -> int:
    """Pair box a of A with those of B in a grid."""
    width = width_of(B, grid)
    x_0, x_1 = _cells_along(A, a, 0, width)
    y_0, y_1 = _cells_along(A, a, 1, width)
    z_0, z_1 = _cells_along(A, a, 2, width)
    bodies = B.counts[BODIES]
    if not (x_1 - x_0 + 1.0) * (y_1 - y_0 + 1.0) * (z_1 - z_0 + 1.0) <= bodies:
        for b in range(bodies):
            if B.cells[b, GRID] == grid:
                count = _put_pair(A, a, B, b, skipped, codes, count)
        return count
    cells, used, bits = int(x_1 - x_0) + 1, 0, 0
    for y in range(int(y_0), int(y_1) + 1):
        for z in range(int(z_0), int(z_1) + 1):
            bucket = bucket_of(B.counts, int(x_0), y, z, grid)
            first, end = B.starts[unsigned(bucket)], bucket + cells
            seen, count = _look(A, a, box, B, first, end, used, skipped, codes, count)
            bits, used = bits | seen, used + 1
            if used == PLACES:
                count = _put_found(A, a, B, bits, skipped, codes, count)
                bits, used = 0, 0
    return _put_found(A, a, B, bits, skipped, codes, count)


@compiled
def pairs_within(boxes: Boxes, nobody: Booleans, codes: Indices, count: int) -> int:
    """Append the pairs of boxes that overlap to the codes; return how many there are then.

    ``nobody`` is empty, and handed over: as a constant it would be of another type than
    ``skipped`` elsewhere, and everything below would be compiled twice.
    """
    cells, counts, starts = boxes.cells, boxes.counts, boxes.starts
    for a in range(counts[BODIES]):
        bucket, grid, box = cells[a, BUCKET], cells[a, GRID], box_at(boxes.sides, a)
        # Those behind it in its own cell, and the next cell, which begins where that one ends.
        bits, count = _look(boxes, a, box, boxes, a + 1, bucket + 2, 0, nobody, codes, count)
        for k in range(FORWARD.shape[0]):
            aside = FORWARD[k, 0] * counts[STEP_Y] + FORWARD[k, 1] * counts[STEP_Z]
            row = (bucket - 1 + aside) & counts[MASK]
            first, end = starts[unsigned(row)], row + 3
            seen, count = _look(boxes, a, box, boxes, first, end, k + 1, nobody, codes, count)
            bits |= seen
        count = _put_found(boxes, a, boxes, bits, nobody, codes, count)
        for k in range(counts[GRIDS]):
            if boxes.grids[k] > grid:
                count = _in_grid(boxes, a, box, boxes, boxes.grids[k], nobody, codes, count)
    return count


@compiled
def pairs_between(
    some: Boxes, others: Boxes, skipped: Booleans, codes: Indices, count: int
) -> int:
    """Append the pairs of one of some boxes and one of others; return how many there are then.

    Those of ``others`` for which ``skipped`` (n,) holds are left out; none if it is empty.
    """
    for a in range(some.counts[BODIES]):
        box = box_at(some.sides, a)
        for k in range(others.counts[GRIDS]):
            count = _in_grid(some, a, box, others, others.grids[k], skipped, codes, count)
    return count
