"""Change of a table: the rows that it retains, and the places of the new ones.

Tables of scenes are in the order of ids, so most of a changed table is a few runs of the former
one. Copying runs takes a hundredth of the time of deriving all rows again. Columns that only one
table has are changed in place, which takes a tenth of the time of copying them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SPARE = 8  # of the rows of a column: this part of them is allocated for more
MOST_SPARE = 1 << 16  # rows: pools of large meshes get no more


def capacity_for(rows: int) -> int:
    """Return how many rows to allocate for a column that may grow."""
    return rows + min(rows // SPARE + SPARE, MOST_SPARE)


class RowChange(NamedTuple):
    """Mapping of the rows of a former table to those of the present one, in the same order."""

    total: int  # rows now
    runs: list[tuple[int, int, int]]  # former rows [first, last), and the place of the first now
    new: Indices  # (k,) places of the rows that are not in the former table, ascending

    @classmethod
    def of(cls, before: Indices, changed: Indices, has_row: NDArray[np.bool_]) -> RowChange:
        """Return the change of a table by ids ``before`` (n,), ascending.

        ``changed`` (m,), ascending, are the ids whose rows are not retained, and ``has_row`` (m,)
        says which of them have a row now.
        """
        at = np.searchsorted(before, changed)
        is_former = np.append(before, -1)[at] == changed
        runs, new, first, to = [], [], 0, 0
        for place, is_gone, is_new in zip(
            at.tolist(), is_former.tolist(), has_row.tolist(), strict=True
        ):
            if place > first:
                runs.append((first, place, to))
                to += place - first
            first = place + is_gone
            if is_new:
                new.append(to)
                to += 1
        if first < len(before):
            runs.append((first, len(before), to))
            to += len(before) - first
        return cls(to, runs, np.array(new, dtype=np.int64))

    @classmethod
    def appended(cls, before: int, more: int) -> RowChange:
        """Return the change of a table of ``before`` rows that gets ``more`` at its end."""
        runs = [(0, before, 0)] if before else []
        return cls(before + more, runs, np.arange(before, before + more))

    def appends_to(self, count: int) -> bool:
        """Return whether all of ``count`` former rows stay, and all new ones come after them."""
        return self.runs == ([(0, count, 0)] if count else [])

    @property
    def is_in_place(self) -> bool:
        """True if each row that stays is where it was."""
        return all(first == to for first, _, to in self.runs)

    def shared(self, before: NDArray, new: NDArray) -> NDArray:  # type: ignore[type-arg]
        """Return a column as ``merged`` does: the former one if all of its bits are the same."""
        is_same = self.is_in_place and self.total == len(before)
        if is_same and before[self.new].tobytes() == new.astype(before.dtype).tobytes():
            return before
        return self.merged(before, new)

    def merged(self, before: NDArray, new: NDArray | float) -> NDArray:  # type: ignore[type-arg]
        """Return a column (total, ...) from the former one, and from that of the new rows."""
        column = np.empty((self.total, *before.shape[1:]), before.dtype)
        for first, last, to in self.runs:
            column[to : to + last - first] = before[first:last]
        column[self.new] = new
        return column

    def in_place(self, before: NDArray, new: NDArray | float) -> NDArray:  # type: ignore[type-arg]
        """Return a column as ``merged`` does, in the memory of the former one if that has room.

        The former column is not valid any more, so no other table may have it.
        """
        buffer = _rows_behind(before)
        if len(buffer) < self.total:
            buffer = np.empty((capacity_for(self.total), *before.shape[1:]), before.dtype)
            buffer[: len(before)] = before
        if not self.is_in_place:
            # Without an axis of rows that overlap NumPy moves memory, and copies nothing before.
            flat, width = buffer.reshape(-1), buffer.size // len(buffer)
            rising = [run for run in reversed(self.runs) if run[2] > run[0]]
            sinking = [run for run in self.runs if run[2] < run[0]]
            for first, last, to in rising + sinking:
                end = to + last - first
                flat[to * width : end * width] = flat[first * width : last * width]
        buffer[self.new] = new
        return buffer[: self.total]

    def places(self, former_count: int) -> Indices:
        """Return the place now (n,) of each former row, -1 if it is not retained."""
        places = np.full(former_count, -1, dtype=np.int64)
        for first, last, to in self.runs:
            places[first:last] = np.arange(to, to + last - first)
        return places

    def places_of(self, rows: Indices) -> Indices:
        """Return the places now of former rows that are retained, out of a few rows."""
        kept = [
            rows[(first <= rows) & (rows < last)] + (to - first) for first, last, to in self.runs
        ]
        return np.concatenate([*kept, rows[:0]])


def _rows_behind(column: NDArray) -> NDArray:  # type: ignore[type-arg]
    """Return the buffer whose first rows a column is, or the column itself."""
    base = column.base  # may be the bytes that an array was read from
    if isinstance(base, np.ndarray) and base.dtype == column.dtype:
        return base if base.shape[1:] == column.shape[1:] else column
    return column
