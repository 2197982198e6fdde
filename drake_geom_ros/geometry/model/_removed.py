"""What messages say of geometries that are here no longer."""

from __future__ import annotations

from collections.abc import Iterable

from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model._records import GeometryRecord

_KEPT = 1024  # names of those that were removed last


class Removed:
    """The names of the geometries that were removed last, by their ids."""

    def __init__(self, names: dict[GeometryId, str] | None = None) -> None:
        self._names = {} if names is None else names

    def copy(self) -> Removed:
        """Return names that change on their own."""
        return Removed(dict(self._names))

    def add(self, records: Iterable[GeometryRecord]) -> None:
        """Note geometries that are being removed."""
        self._names |= {record.id: record.name for record in records}
        while len(self._names) > _KEPT:
            del self._names[next(iter(self._names))]

    def told_of(self, id: GeometryId) -> str:
        """Return what is known of a geometry that is not here, as a sentence."""
        if id in self._names:
            return f"It was called '{self._names[id]}', and has been removed."
        return 'It has not been registered.'
