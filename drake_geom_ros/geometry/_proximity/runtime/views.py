"""Views of arrays that hold no reference: for loops in which every pair has its shapes and poses.

A slice in compiled code keeps its array alive by a count of references. Where Numba cannot prove
that the count is not needed, each slice of each pair costs two atomic operations and a call: half
of the narrow phase of 1000 balls. These views do without; the array that they show must outlive
them, as arguments of the loop do, and arrays of one's own that ``outlive`` is called with at last.
"""

from typing import Any

import numpy as np

from drake_geom_ros.geometry._proximity.runtime.compiled import view


@view
def row(array: Any, k: int) -> Any:
    """Return array[k]."""
    return array[k]


@view
def part(array: Any, start: int, stop: int) -> Any:
    """Return array[start:stop]."""
    return array[start:stop]


@view
def table(array: Any, start: int, rows: int, columns: int) -> Any:
    """Return the elements of an array from start on as so many rows and columns."""
    return array[start : start + rows * columns].reshape(rows, columns)


@view
def integers(array: Any, start: int) -> Any:
    """Return what an array of numbers of 64 bits has from start on as integers of 32 bits."""
    return array[start:].view(np.int32)


@view
def wide_integers(array: Any, start: int) -> Any:
    """Return what an array of numbers of 64 bits has from start on as integers of 64 bits."""
    return array[start:].view(np.int64)


@view
def outlive(array: Any) -> None:
    """Keep an array until here: views of it hold no reference."""
