"""Record of which geometries changed, so that what queries derive from the others is kept."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

from drake_geom_ros.geometry.ids import GeometryId

_MAX_VERSIONS = 1024  # a query after more changes than this derives everything again


class ChangedGeometries:
    """Ids of the geometries that each version of the proximity geometry changed."""

    def __init__(self) -> None:
        # None for a version that may have changed all of them.
        self._by_version: dict[int, tuple[GeometryId, ...] | None] = {}

    def copy(self) -> ChangedGeometries:
        """Return an independent copy."""
        other = ChangedGeometries()
        other._by_version = dict(self._by_version)
        return other

    def add(self, version: int, ids: Iterable[GeometryId] | None) -> None:
        """Record the change that made a version; ``ids`` None: of any geometry."""
        self._by_version[version] = None if ids is None else tuple(ids)
        while len(self._by_version) > _MAX_VERSIONS:
            del self._by_version[next(iter(self._by_version))]

    def between(self, before: int, now: int) -> set[GeometryId] | None:
        """Return the geometries changed after one version, up to another; None: any may have."""
        if now - before > len(self._by_version):
            return None
        changes = [self._by_version.get(version) for version in range(before + 1, now + 1)]
        recorded = [ids for ids in changes if ids is not None]
        return set(chain(*recorded)) if len(recorded) == len(changes) else None
