"""Pairs of overlapping boxes, from the cells around each box; see ``grids``.

The boxes in a row of cells along x are contiguous in memory and compared together. The bits of all
rows around a body are collected in one number and evaluated at the end: evaluating each row at
once cost a mispredicted branch for every other row.

Loops over bodies make no call with ``Boxes`` per body: passing the arrays takes longer than the
comparison (127 instead of 18 ns per body).
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

# Rows of cells along x, by their steps in y and z: one of each two opposite ones.
FORWARD = np.array([(1, 0), (-1, 1), (0, 1), (1, 1)], dtype=np.int64)


@inlined
def _overlap(bounds_a: Floats, a: int, bounds_b: Floats, b: int) -> bool:
    """Return whether two boxes share a point."""
    # Unsigned indices: the test for negative ones takes as long as the comparison.
    a, b = unsigned(a), unsigned(b)
    # Without branches, which would be mispredicted half of the time.
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
    """Append the pair of two boxes if they overlap, differ in body, and b is not skipped."""
    i, j = A.rows[unsigned(a)], B.rows[unsigned(b)]
    is_pair = _overlap(A.bounds, a, B.bounds, b) & (i != j)
    if skipped.size > 0:
        is_pair = is_pair & (not skipped[j])
    return put_code(codes, count, i, j, is_pair)


@inlined
def _put_overlapping(
    A: Boxes, a: int, B: Boxes, bits: int, skipped: Booleans, codes: Indices, count: int
) -> int:
    """Pair box a of A with the boxes of B whose bits are set, LANES bits per place of B."""
    while bits != 0:
        bit = lowest(bits)
        b = B.places[unsigned(bit // LANES)] + bit % LANES
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
    """Pair box a of A with the boxes of B from ``first`` up to ``last``, exclusive."""
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
    """Compare a box with those of B from ``first`` up to the start of the bucket ``end``.

    Return the bits of the first LANES boxes, shifted to the place number ``used``, and the number
    of codes after the pairs with the remaining boxes were appended.
    """
    buckets = B.counts[MASK] + 1
    last = B.starts[unsigned(min(end, buckets))]
    B.places[unsigned(used)] = first
    bits = overlapping(B.sides, first, box) & first_lanes(max(last - first, 0))
    if last - first > LANES:
        count = _among(A, a, box, B, first + LANES, last, skipped, codes, count)
    if end > buckets:  # the row continues at the first bucket
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
    """Pair box a of A with the boxes of B in one grid."""
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
                count = _put_overlapping(A, a, B, bits, skipped, codes, count)
                bits, used = 0, 0
    return _put_overlapping(A, a, B, bits, skipped, codes, count)


@compiled
def pairs_within(boxes: Boxes, no_bodies: Booleans, codes: Indices, count: int) -> int:
    """Append the pairs of overlapping boxes to the codes; return the new number of codes.

    ``no_bodies`` is an empty array for ``skipped``. It is an argument because a constant would
    have another type, for which everything below would be compiled again.
    """
    cells, counts, starts = boxes.cells, boxes.counts, boxes.starts
    for a in range(counts[BODIES]):
        bucket, grid, box = cells[a, BUCKET], cells[a, GRID], box_at(boxes.sides, a)
        # Later boxes in its own cell, and the next cell, which begins where that one ends.
        bits, count = _look(boxes, a, box, boxes, a + 1, bucket + 2, 0, no_bodies, codes, count)
        for k in range(FORWARD.shape[0]):
            aside = FORWARD[k, 0] * counts[STEP_Y] + FORWARD[k, 1] * counts[STEP_Z]
            row = (bucket - 1 + aside) & counts[MASK]
            first, end = starts[unsigned(row)], row + 3
            seen, count = _look(boxes, a, box, boxes, first, end, k + 1, no_bodies, codes, count)
            bits |= seen
        count = _put_overlapping(boxes, a, boxes, bits, no_bodies, codes, count)
        for k in range(counts[GRIDS]):
            if boxes.grids[k] > grid:
                count = _in_grid(boxes, a, box, boxes, boxes.grids[k], no_bodies, codes, count)
    return count


@compiled
def pairs_between(
    some: Boxes, others: Boxes, skipped: Booleans, codes: Indices, count: int
) -> int:
    """Append the pairs of a box in ``some`` and one in ``others``; return the number of codes.

    Boxes of ``others`` for which ``skipped`` (n,) holds are omitted; none if it is empty.
    """
    for a in range(some.counts[BODIES]):
        box = box_at(some.sides, a)
        for k in range(others.counts[GRIDS]):
            count = _in_grid(some, a, box, others, others.grids[k], skipped, codes, count)
    return count
