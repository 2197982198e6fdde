"""Sequences over arrays that make records when they are indexed.

A record costs about 1 us of Python; records of all pairs of a large scene would cost more than the
query. So a query returns a read-only sequence of arrays, and indexing makes a record.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.tables import Columns, Tabular
from drake_geom_ros.geometry._proximity.pairs.answer_rows import PairBatch, PointBatch
from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.math.array_types import Floats, Indices

Record = TypeVar('Record')
Batch = TypeVar('Batch', PairBatch, PointBatch)
# Returns the names of geometries by their id values (k,).
NamesOfIds = Callable[[Indices], list[str]]


class NamedResults(Tabular):
    """Base of results as arrays that can look up the names of geometries."""

    _names_of_ids: NamesOfIds | None = None
    _listed: tuple[str, ...] = ()  # the properties that ``columns`` has

    def know_names(self, names_of_ids: NamesOfIds) -> None:
        """Take a function that returns the names of geometries, by their id values (k,)."""
        self._names_of_ids = names_of_ids

    def names_of(self, ids: Indices) -> NDArray[np.str_]:
        """Return the names (k,) of geometries now, ``source::frame/geometry``, by id values.

        Raises GeometryError for a geometry that was removed, and for results that do not know
        their scene, such as those of a prepared query.
        """
        if self._names_of_ids is None:
            raise GeometryError(
                'these results know no scene to look up names in: '
                'query_object.inspector().full_names(ids) has them'
            )
        return np.array(self._names_of_ids(ids), dtype=np.str_)

    def columns(self) -> Columns:
        """Return the arrays (k, ...) by name, with names of geometries if these are known."""
        columns: Columns = {}
        for name in self._listed:
            columns[name] = self._column(name)
            if name.startswith('id_') and self._names_of_ids is not None:
                columns[name.replace('id_', 'name_')] = self.names_of(columns[name])
        return columns

    def _column(self, name: str) -> NDArray[Any]:
        array: NDArray[Any] = getattr(self, name)
        return array


class ResultSequence(NamedResults, Sequence[Record], Generic[Record, Batch]):
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
