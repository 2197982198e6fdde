"""Columns of tables that grow in place: new rows are appended behind those of a former version.

A version of a column is a view of the first rows of a buffer, and the versions of drafts and
copies share buffers. A row that a version has is never written again. Only the first that appends
to the last row of a buffer gets the rows behind it; every other version gets a buffer of its own.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.world.row_change import RowChange, capacity_for

Shapes = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]  # types, starts, pool


class _Buffer:
    """Rows of which the first ones belong to versions of a column."""

    def __init__(self, column: NDArray[Any], total: int) -> None:
        """Copy a column, and add room up to ``total`` rows, which are claimed, and for more."""
        self.rows = np.empty((capacity_for(total), *column.shape[1:]), column.dtype)
        self.rows[: len(column)] = column
        self._claimed, self._lock = total, threading.Lock()

    def claim(self, first: int, last: int) -> bool:
        """Return whether rows first to last may be written: by one caller only."""
        with self._lock:
            is_free = first == self._claimed and last <= len(self.rows)
            if is_free:
                self._claimed = last
            return is_free


class Columns:
    """The buffers behind the columns of a table, by name."""

    def __init__(self) -> None:
        self._buffers: dict[str, _Buffer] = {}

    def __reduce__(self) -> tuple[type[Columns], tuple[()]]:
        return Columns, ()  # the columns of a copy are elsewhere

    def copy(self) -> Columns:
        """Return the same buffers, for another version of the table."""
        other = Columns()
        other._buffers = dict(self._buffers)
        return other

    def changed(
        self, name: str, before: NDArray[Any], new: NDArray[Any], change: RowChange
    ) -> NDArray[Any]:
        """Return the column of a changed table; that of the former one stays as it is."""
        if change.appends_to(len(before)):
            return self._appended(name, before, new)
        return change.shared(before, new)

    def changed_shapes(self, name: str, before: Shapes, new: Shapes, change: RowChange) -> Shapes:
        """Return types, starts and pool of packed shapes, as ``changed`` does."""
        types, starts, pool = before
        more_types, more_starts, more = new
        types = self.changed(f'{name} types', types, more_types, change)
        if change.appends_to(len(before[0])):
            more_starts = starts[-1] + more_starts[1:]
            starts = self._appended(f'{name} starts', starts, more_starts)
            return types, starts, self._appended(f'{name} pool', pool, more)
        lengths = change.shared(np.diff(starts), np.diff(more_starts))
        new_starts = np.zeros(change.total + 1, dtype=np.int64)
        np.cumsum(lengths, out=new_starts[1:])
        new_pool = np.empty(int(new_starts[-1]))
        for first, last, to in change.runs:
            some = pool[starts[first] : starts[last]]
            new_pool[new_starts[to] : new_starts[to] + len(some)] = some
        for k, row in enumerate(change.new.tolist()):
            shape = more[more_starts[k] : more_starts[k + 1]]
            new_pool[new_starts[row] : new_starts[row + 1]] = shape
        return types, new_starts, new_pool

    def _appended(self, name: str, before: NDArray[Any], new: NDArray[Any]) -> NDArray[Any]:
        """Return a column with more rows at its end, in the buffer of the former one if it can."""
        first, last = len(before), len(before) + len(new)
        buffer = self._buffers.get(name)
        is_of_buffer = buffer is not None and before.base is buffer.rows
        if buffer is None or not (is_of_buffer and buffer.claim(first, last)):
            buffer = self._buffers[name] = _Buffer(before, last)
        buffer.rows[first:last] = new
        return buffer.rows[:last]
