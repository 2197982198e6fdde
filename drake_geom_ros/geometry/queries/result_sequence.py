"""Sequences over arrays that make records when they are indexed.

A record costs about 1 us of Python; records of all pairs of a large scene would cost more than the
query. So a query returns a read-only sequence of arrays, and indexing makes a record.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar, overload

from drake_geom_ros.geometry._proximity.pairs.answer_rows import PairBatch, PointBatch
from drake_geom_ros.math.array_types import Floats

Record = TypeVar('Record')
Batch = TypeVar('Batch', PairBatch, PointBatch)


class ResultSequence(Sequence[Record], Generic[Record, Batch]):
    """Read-only sequence of records over arrays; subclasses name the arrays.

    Only the order can be changed, by ``sort``, which also sorts the arrays. It can be compared
    with lists of records and added to them; the sum is a list.
    """

    _rows: Floats

    @property
    def _batch(self) -> Batch:
        """All arrays."""
        raise NotImplementedError

    def _take(self, batch: Batch) -> None:
        """Replace the arrays."""
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Record: ...
    @overload
    def __getitem__(self, index: slice) -> list[Record]: ...
    def __getitem__(self, index: int | slice) -> Record | list[Record]:
        count = len(self)
        if isinstance(index, slice):
            return [self._record(k) for k in range(*index.indices(count))]
        if not -count <= index < count:
            raise IndexError(f'result {index} of {count} results was asked for')
        return self._record(index % count)

    def sort(self, *, key: Callable[[Record], Any], reverse: bool = False) -> None:
        """Order the results by ``key(record)``, as ``list.sort`` does; the arrays follow."""
        order = sorted(range(len(self)), key=[*map(key, self)].__getitem__, reverse=reverse)
        arrays: list[Any] = [array[order] for array in self._batch]
        for array in arrays:
            array.flags.writeable = False
        self._take(type(self._batch)(*arrays))

    def __add__(self, other: Sequence[Any]) -> list[Any]:
        if not isinstance(other, (list, ResultSequence)):
            return NotImplemented
        return [*self, *other]

    def __radd__(self, other: list[Any]) -> list[Any]:
        return [*other, *self] if isinstance(other, list) else NotImplemented

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, (list, ResultSequence)):
            return NotImplemented
        return len(self) == len(other) and all(map(operator.eq, self, other))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f'<{type(self).__name__} of {len(self)} results>'

    def _record(self, k: int) -> Record:
        raise NotImplementedError
