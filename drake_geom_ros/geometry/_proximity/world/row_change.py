"""Change of a table: the rows that it retains, and the places of the new ones.

Tables of scenes are in the order of ids, so most of a changed table is a few runs of the former
one. Copying runs takes a hundredth of the time of deriving all rows again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Shapes = tuple[Indices, Indices, Floats]  # types (n,), starts (n + 1,), pool


class RowChange(NamedTuple):
    """How the rows of a table come from those of the former one, in the same order."""

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

    @property
    def is_in_place(self) -> bool:
        """Whether each row that stays is where it was."""
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

    def merged_shapes(self, before: Shapes, new: Shapes) -> Shapes:
        """Return types, starts and pool of packed shapes, as ``merged`` does."""
        starts = np.zeros(self.total + 1, dtype=np.int64)
        np.cumsum(self.merged(np.diff(before[1]), np.diff(new[1])), out=starts[1:])
        pool = np.empty(int(starts[-1]))
        for first, last, to in self.runs:
            some = before[2][before[1][first] : before[1][last]]
            pool[starts[to] : starts[to] + len(some)] = some
        for k, row in enumerate(self.new.tolist()):
            pool[starts[row] : starts[row + 1]] = new[2][new[1][k] : new[1][k + 1]]
        return self.merged(before[0], new[0]), starts, pool

    def places(self, former_count: int) -> Indices:
        """Return the place now (n,) of each former row, -1 if it is not retained."""
        places = np.full(former_count, -1, dtype=np.int64)
        for first, last, to in self.runs:
            places[first:last] = np.arange(to, to + last - first)
        return places
