"""Filters of a scene file whose robot comes later: they hold from when it is there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import AwaitedFilter, SceneFileError, apply_filter, describe
from drake_geom_ros.scene_files.names import FileNames


class AwaitedFilters:
    """The filters of one scene that name sources which may not be there yet."""

    def __init__(self) -> None:
        self._filters: list[AwaitedFilter] = []
        self._reasons: list[str] = []  # why each waits; empty: it holds
        self._tried: object = None

    def begin(self, filters: Iterable[AwaitedFilter]) -> None:
        """Wait with more filters."""
        for each in filters:
            self._filters.append(each)
            self._reasons.append(_waits(each.sources))

    def forget(self, source: str) -> None:
        """Wait again with those that name a source which is gone."""
        for k, each in enumerate(self._filters):
            if source in each.sources:
                self._reasons[k] = _waits(each.sources)

    def all(self) -> tuple[AwaitedFilter, ...]:
        """Return all of them, those that hold as well."""
        return tuple(self._filters)

    def waiting(self) -> tuple[AwaitedFilter, ...]:
        """Return those that do not hold yet."""
        pairs = zip(self._filters, self._reasons, strict=True)
        return tuple(each for each, reason in pairs if reason)

    def bind(self, scene_graph: SceneGraph) -> Iterator[str]:
        """Apply those whose sources are there, and yield what became of them, in words."""
        if not any(self._reasons):
            return
        history = scene_graph.collision_filter_manager().has_transient_history()
        state = scene_graph.names_version(), history
        if state == self._tried:
            return
        self._tried = state
        inspector = scene_graph.model_inspector()
        there = set(map(inspector.GetName, inspector.GetAllSourceIds()))
        ready = [
            k
            for k, each in enumerate(self._filters)
            if self._reasons[k] and there.issuperset(each.sources)
        ]
        if not ready:
            return
        scene = describe(scene_graph)
        names = FileNames(scene.frames, scene.geometries)
        for k in ready:
            each = self._filters[k]
            assert each.bind is not None
            try:
                apply_filter(scene_graph, each.bind(names))
            except SceneFileError as error:
                self._reasons[k] = error.reason
                continue
            self._reasons[k] = ''
            sources = ', '.join(map(repr, each.sources))
            yield str(each.where.error(f'holds now that {sources} is there'))

    def troubles(self) -> list[str]:
        """Return which filters wait, and for what, in words."""
        return [
            f'a filter of the scene file does not hold yet: {each.where.error(reason)}'
            for each, reason in zip(self._filters, self._reasons, strict=True)
            if reason
        ]


def _waits(sources: tuple[str, ...]) -> str:
    return f'it waits for {", ".join(map(repr, sources))}'
