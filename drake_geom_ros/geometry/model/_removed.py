"""Names of removed geometries, for error messages."""

from __future__ import annotations

from collections.abc import Iterable

from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model._records import GeometryRecord

_MAX_NAMES = 1024  # of the geometries that were removed last


class Removed:
    """Names of the last removed geometries, by their ids."""

    def __init__(self, names: dict[GeometryId, str] | None = None) -> None:
        self._names = {} if names is None else names

    def copy(self) -> Removed:
        """Return an independent copy."""
        return Removed(dict(self._names))

    def add(self, records: Iterable[GeometryRecord]) -> None:
        """Record the names of geometries that are being removed."""
        self._names |= {record.id: record.name for record in records}
        while len(self._names) > _MAX_NAMES:
            del self._names[next(iter(self._names))]

    def sentence_on(self, id: GeometryId) -> str:
        """Return a sentence that says if a missing geometry was removed or never registered."""
        if id in self._names:
            return f"It was called '{self._names[id]}', and has been removed."
        return 'It has not been registered.'
