"""Compiled passes over the points of a cloud, one for each operation.

NumPy made a dozen arrays of the size of the cloud, which took 0.1 s for 300 000 points, mostly
waiting for memory. These passes also run without the interpreter's lock.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.compiling import compiled
from drake_geom_ros.math.array_types import Flags, Floats, Indices

Columns = tuple[NDArray[Any], NDArray[Any], NDArray[Any]]

BITS = 21  # of a key along each axis, so that all three fit into 64 bits
MOST_STEPS = 1 << (BITS - 1)  # cells from the origin along an axis
NO_KEY = -1
_MIX = 0x2545F4914F6CDD1D  # an odd multiplier that spreads keys
_DROPPED = 40  # low bits of a product, which depend on few bits of a key


class Reached(NamedTuple):
    """Numbers of finite points, and of those that were kept."""

    finite: int
    kept: int


class Cubes(NamedTuple):
    """A grid of cubes with edge [m] from a corner (3,) [m], with flags of selected cubes."""

    low: Floats
    edge: float
    flags: Flags  # (a, b, c)


@compiled
def put_within_reach(
    columns: Columns, R: Floats, p: Floats, reach: float, p_WQs: Floats
) -> Reached:
    """Write finite points within reach [m] of their origin, rotated by R and moved by p.

    ``columns`` are their x, y and z (a, b) [m], see ``as_columns``. The order is preserved. The
    nearest point is always written, however far it is.
    """
    # Numba's float() does not widen a float32, and in single precision a point just beyond the
    # reach would count.
    xs, ys, zs = columns
    finite, nearest = 0, math.inf
    for i in range(xs.shape[0]):
        for j in range(xs.shape[1]):
            x, y, z = np.float64(xs[i, j]), np.float64(ys[i, j]), np.float64(zs[i, j])
            if math.isfinite(x) and math.isfinite(y) and math.isfinite(z):
                finite += 1
                nearest = min(nearest, math.sqrt(x * x + y * y + z * z))
    limit, written = max(reach, nearest), 0
    for i in range(xs.shape[0]):
        for j in range(xs.shape[1]):
            x, y, z = np.float64(xs[i, j]), np.float64(ys[i, j]), np.float64(zs[i, j])
            if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
                continue
            if math.sqrt(x * x + y * y + z * z) > limit:
                continue
            for k in range(3):
                p_WQs[written, k] = R[k, 0] * x + R[k, 1] * y + R[k, 2] * z + p[k]
            written += 1
    return Reached(finite, written)


@compiled
def find_in_cubes(points: Floats, cubes: Cubes, rows: Indices) -> int:
    """Write the rows of the points (n, 3) [m] in flagged cubes; return their number."""
    low, edge, flags = cubes.low, cubes.edge, cubes.flags
    # Most points are far from all cubes, which this test finds without divisions. One cube is
    # added for rounding at the border.
    far_x, far_y, far_z = (
        edge * (flags.shape[0] + 1),
        edge * (flags.shape[1] + 1),
        edge * (flags.shape[2] + 1),
    )
    count = 0
    for i in range(points.shape[0]):
        x, y, z = points[i, 0] - low[0], points[i, 1] - low[1], points[i, 2] - low[2]
        if not (0.0 <= x <= far_x and 0.0 <= y <= far_y and 0.0 <= z <= far_z):
            continue
        x, y, z = np.floor(x / edge), np.floor(y / edge), np.floor(z / edge)
        if not (0 <= x < flags.shape[0] and 0 <= y < flags.shape[1] and 0 <= z < flags.shape[2]):
            continue
        if flags[int(x), int(y), int(z)]:
            rows[count] = i
            count += 1
    return count


@compiled
def keep_in_box(points: Floats, left_out: Flags, low: Floats, high: Floats) -> Reached:
    """Move the points (n, 3) [m] in a box with corners (3,) to the front, except those left out.

    If none is in the box, the nearest point to it that is not left out is kept. ``finite`` counts
    all points that are not left out. The order is preserved.
    """
    count, moved, nearest, best = 0, 0, math.inf, -1
    for i in range(points.shape[0]):
        if left_out[i]:
            continue
        count += 1
        beyond = 0.0
        for k in range(3):
            beyond = max(beyond, low[k] - points[i, k], points[i, k] - high[k])
        if beyond > 0.0:
            if best < 0 or beyond < nearest:
                nearest, best = beyond, i
            continue
        for k in range(3):
            points[moved, k] = points[i, k]
        moved += 1
    if moved == 0 and best >= 0:
        for k in range(3):
            points[0, k] = points[best, k]
        moved = 1
    return Reached(count, moved)


@compiled
def count_in_cells(points: Floats, resolution: float, table: Indices) -> int:
    """Fill a hash table with the number of points (n, 3) [m] in each cell of a grid.

    The rows of ``table`` (2^k, 2) are a key and a count, initially NO_KEY and 0. Returns the
    number of counted points: all, unless the next one is outside the grid, or the table is half
    full.
    """
    mask, filled = len(table) - 1, 0
    last, at = NO_KEY, 0  # consecutive points of a cloud are mostly in one cell
    for i in range(len(points)):
        x = np.floor(points[i, 0] / resolution)
        y = np.floor(points[i, 1] / resolution)
        z = np.floor(points[i, 2] / resolution)
        if not is_step(x) or not is_step(y) or not is_step(z) or 2 * filled > mask:
            return i
        key = (int(x) + MOST_STEPS) << (2 * BITS)
        key |= (int(y) + MOST_STEPS) << BITS | (int(z) + MOST_STEPS)
        if key != last:
            last, at = key, (key * _MIX >> _DROPPED) & mask
            while table[at, 0] != key and table[at, 0] != NO_KEY:
                at = (at + 1) & mask
            if table[at, 0] == NO_KEY:
                table[at, 0] = key
                filled += 1
        table[at, 1] += 1
    return len(points)


@compiled
def is_step(x: float) -> bool:
    """Return whether a number of cells from the origin fits into a key."""
    return -MOST_STEPS < x < MOST_STEPS


def compile_passes() -> None:
    """Compile all passes, or load them from the cache, so that the first cloud does not wait."""
    points = np.zeros((1, 3))
    for number in (np.float32, np.float64):
        grid = np.zeros((2, 2), dtype=number)
        columns = as_columns((grid, grid, grid))
        put_within_reach(columns, np.eye(3), np.zeros(3), 1.0, np.empty((4, 3)))
    cubes = Cubes(np.zeros(3), 1.0, np.ones((1, 1, 1), dtype=np.bool_))
    find_in_cubes(points, cubes, np.empty(1, dtype=np.int64))
    keep_in_box(points, np.zeros(1, dtype=np.bool_), np.zeros(3), np.zeros(3))
    count_in_cells(points, 1.0, empty_table(2))


def as_columns(columns: Columns) -> Columns:
    """Return x, y and z (a, b) in the array type that ``put_within_reach`` is compiled for.

    All are float32 or all float64, strided and read-only; any other type of array would compile
    another version. Copies may have more rows and columns, of NaNs.
    """
    kind = np.float32 if np.result_type(*columns) == np.float32 else np.float64
    shown = []
    for column in columns:
        seen = column.view()
        if column.dtype != kind or column.flags.forc:
            a, b = column.shape
            apart = np.full((max(a, 2), max(b, 2), 2), np.nan, dtype=kind)
            with np.errstate(invalid='ignore'):  # some NaNs warn when they are widened
                apart[:a, :b, 0] = column
            seen = apart[..., 0]
        seen.flags.writeable = False
        shown.append(seen)
    return shown[0], shown[1], shown[2]


def empty_table(size: int) -> Indices:
    """Return a table for ``count_in_cells`` with ``size`` rows, a power of two."""
    table = np.zeros((size, 2), dtype=np.int64)
    table[:, 0] = NO_KEY
    return table
