"""Views of arrays without reference counts, for loops that slice shapes and poses of every pair.

A slice in compiled code keeps its array alive by a reference count. Where Numba cannot prove the
count unnecessary, each slice of each pair costs two atomic operations and a call: half of the
narrow phase of 1000 balls. These views count no references, so their array must outlive them.
Arguments of the loop do; for local arrays, call ``outlive`` at the end.
"""

from typing import Any

import numpy as np

from drake_geom_ros.geometry._proximity.runtime.compiled import view


@view
def row(array: Any, k: int) -> Any:
    """Return a view of array[k]."""
    return array[k]


@view
def part(array: Any, start: int, stop: int) -> Any:
    """Return a view of array[start:stop]."""
    return array[start:stop]


@view
def table(array: Any, start: int, rows: int, columns: int) -> Any:
    """Return the elements of an array from ``start`` on as a table (rows, columns)."""
    return array[start : start + rows * columns].reshape(rows, columns)


@view
def integers(array: Any, start: int) -> Any:
    """Return a view of an array of 64-bit numbers from ``start`` on as 32-bit integers."""
    return array[start:].view(np.int32)


@view
def wide_integers(array: Any, start: int) -> Any:
    """Return a view of an array of 64-bit numbers from ``start`` on as 64-bit integers."""
    return array[start:].view(np.int64)


@view
def outlive(array: Any) -> None:
    """Keep an array alive up to this call, because views of it hold no reference."""
