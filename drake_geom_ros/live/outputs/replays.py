"""Replay files of results that break a promise: seen in a cycle, written beside it.

A cycle only compares the error bounds with what the level promises. For the first pair of each two
shape types that breaks it the scene is kept as it was, and written down by another thread.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from drake_geom_ros.geometry import GeometryId, QueryObject, SignedDistanceResults
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.replay import Replay, recorded, write

PERIOD = 0.5  # [s] between two looks at what waits to be written
_NAME = 'replay_{kinds}_{stamp}.json'


@dataclass(frozen=True)
class _Finding:
    """A result to be written, and the scene that it was given for."""

    query: QueryObject
    results: SignedDistanceResults
    index: int
    kinds: str
    accuracy: str
    max_distance: float
    hint: tuple[float, ...] | None


class Replays:
    """Looks at what cycles answer, and writes one file for each pair of shape types."""

    def __init__(self, settings: Callable[[], tuple[str, int]]) -> None:
        """Write to the folder (empty: none) of ``settings()``, no more files than its limit."""
        self._settings = settings
        self._previous: SignedDistanceResults | None = None
        self._seen: set[str] = set()
        self._lock = threading.Lock()  # of what waits
        self._waiting: list[_Finding] = []

    def look_at(
        self, scene: HeldScene, results: SignedDistanceResults, max_distance: float
    ) -> None:
        """Keep what breaks a promise and is the first of its kind, with the scene as it is."""
        if not self._settings()[0]:
            self._previous = None
            return
        broken = results.breaks_promise()
        if broken.any():
            for index in broken.nonzero()[0].tolist():
                self._keep(scene, results, index, max_distance)
        # The last normal of a pair is where its next computation starts.
        self._previous = results

    def _keep(
        self, scene: HeldScene, results: SignedDistanceResults, index: int, max_distance: float
    ) -> None:
        kinds = kinds_of(scene.query, results, index)
        if kinds in self._seen:
            return
        self._seen.add(kinds)
        hint = self._hint(results, index)
        query = scene.view().query
        finding = _Finding(query, results, index, kinds, scene.accuracy, max_distance, hint)
        with self._lock:
            self._waiting.append(finding)

    def _hint(self, results: SignedDistanceResults, index: int) -> tuple[float, ...] | None:
        """Return the normal of the same pair in the last cycle, if it was there."""
        if self._previous is None:
            return None
        before = self._previous
        ids = results.id_A[index], results.id_B[index]
        rows = ((before.id_A == ids[0]) & (before.id_B == ids[1])).nonzero()[0]
        return tuple(before.nhat_BA_W[rows[0]].tolist()) if len(rows) else None

    def write(self) -> list[str]:
        """Write what waits; return what happened, in words. Errors are returned, not raised."""
        with self._lock:
            waiting, self._waiting = self._waiting, []
        return [self._write(finding) for finding in waiting if self._settings()[0]]

    def _write(self, finding: _Finding) -> str:
        text = f'a result of {finding.kinds} exceeds the tolerance of level {finding.accuracy}'

        def replay() -> Replay:
            return recorded(
                finding.query,
                finding.results,
                finding.index,
                finding.accuracy,
                finding.max_distance,
                finding.hint,
            )

        return text + kept(replay, finding.kinds, *self._settings())


def kinds_of(query: QueryObject, results: SignedDistanceResults, index: int) -> str:
    """Return the shape types of a result's geometries, as one word that is the same for (B, A)."""
    inspector = query.inspector()
    ids = (GeometryId(int(each[index])) for each in (results.id_A, results.id_B))
    return '_'.join(sorted(type(inspector.GetShape(id)).__name__ for id in ids)).lower()


def kept(make: Callable[[], Replay], kinds: str, folder: str, limit: int) -> str:
    """Write a replay into a folder (empty: none), and return what is to be said of that."""
    if not folder:
        return ''
    try:
        path = Path(folder)
        path.mkdir(parents=True, exist_ok=True)
        if sum(1 for _ in path.glob(_NAME.format(kinds='*', stamp='*'))) >= limit:
            return f'; replay_limit ({limit} files) is reached in {path}'
        path /= _NAME.format(kinds=kinds, stamp=time.strftime('%Y%m%dT%H%M%S'))
        write(make(), path)
    except (OSError, RuntimeError) as error:
        return f', and no replay file could be written: {error}'
    return f': python -m drake_geom_ros replay {path}'
