"""A second opinion about what cycles answer: sampled in a cycle, asked and judged beside it.

A cycle only puts what it answered into a queue that never waits; a thread takes a sample from it
to a process of its own (``drake_geom_ros.cross_check``) and counts the verdicts. Loaded by a node
whose parameter ``cross_check`` is not 0, and by no other.
"""

from __future__ import annotations

import queue
import random
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from drake_geom_ros.cross_check.asker import Asker
from drake_geom_ros.cross_check.question import (
    DISAGREED,
    LOST,
    REFUTED,
    SILENT,
    VERDICTS,
    Verdict,
    counted,
    questions_of,
)
from drake_geom_ros.geometry import SignedDistanceResults
from drake_geom_ros.live.outputs.replays import kept, kinds_of
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.replay import Replay, recorded

PAIRS = 16  # of a cycle, at most
_WAITING = 2  # cycles that may wait to be looked at; more are dropped
_DROPPED = 'dropped'
_LOOKS = 0.1  # [s] between two looks whether it is closed


@dataclass(frozen=True)
class _Answered:
    """The answer of a cycle, and the scene that it is for."""

    view: SceneView
    results: SignedDistanceResults
    accuracy: str
    max_distance: float


class CrossCheckCounts(NamedTuple):
    """Counts of checked pairs by verdict, and of samples that were lost or left out."""

    pairs: int
    disagreements: int
    refuted: int  # answers of python-fcl that ours prove wrong
    silent: int  # questions to which python-fcl has no answer
    lost: int  # processes that ended or hung
    dropped: int  # samples of cycles, because those before were not done


class CrossCheck:
    """Hands samples of cycles to python-fcl; a thread of its own lives until it is closed."""

    def __init__(self, rate: float, replay_settings: Callable[[], tuple[str, int]]) -> None:
        """Take a sample ``rate`` [Hz] times a second, of the cycles that there are.

        What is disagreed about goes into the folder (empty: none) of ``replay_settings()``, no
        more files than its limit.
        """
        self.rate = rate
        self._replay_settings = replay_settings
        self._due = 0.0  # [s] of the steady clock
        self._queue: queue.Queue[_Answered] = queue.Queue(_WAITING)
        self._closed = threading.Event()
        self._lock = threading.Lock()  # of what is counted and told
        self._counts: Counter[str] = Counter()
        self._told: list[str] = []
        self._seen: set[str] = set()
        self._random = random.Random()
        self._asker = Asker(self._closed.is_set)
        self._thread = threading.Thread(target=self._serve, name='cross-check', daemon=True)
        self._thread.start()

    def look_at(
        self, scene: HeldScene, results: SignedDistanceResults, max_distance: float
    ) -> None:
        """Keep what a cycle answered, with its scene, if it is time to; it never waits."""
        now = time.monotonic()
        if now < self._due or not len(results):
            return
        self._due = now + 1.0 / self.rate
        if self._queue.full():
            with self._lock:
                self._counts[_DROPPED] += 1
            return
        # Only this thread fills the queue, so that there is room.
        answered = _Answered(scene.view(), results, scene.accuracy, max_distance)
        self._queue.put_nowait(answered)

    def close(self) -> None:
        """End the process and the thread."""
        self._closed.set()
        self._thread.join()
        self._asker.close()

    def counts(self) -> CrossCheckCounts:
        """Return what came of it until now."""
        with self._lock:
            counts = self._counts.copy()
        return CrossCheckCounts(
            pairs=sum(counts[verdict] for verdict in VERDICTS),
            disagreements=counts[DISAGREED],
            refuted=counts[REFUTED],
            silent=counts[SILENT],
            lost=counts[LOST] + self._asker.lost,
            dropped=counts[_DROPPED],
        )

    def tell(self) -> list[str]:
        """Return what is to be logged since the last time, in words."""
        with self._lock:
            texts, self._told = self._told, []
        return texts

    def _serve(self) -> None:
        while not self._closed.is_set():
            try:
                answered = self._queue.get(timeout=_LOOKS)
            except queue.Empty:
                continue
            try:
                self._check(answered)
            except Exception as error:  # nobody foresaw it, and the thread goes on
                self._tell_once(repr(error), f'internal error in the cross-check: {error!r}')

    def _check(self, answered: _Answered) -> None:
        """Ask about a sample of what a cycle answered."""
        results, query = answered.results, answered.view.query
        indices = self._random.sample(range(len(results)), min(PAIRS, len(results)))
        questions = questions_of(query, results, indices)
        verdicts = self._asker.ask(query, answered.view.moment.version, questions)
        if verdicts is None:
            return
        with self._lock:
            self._counts += counted(verdicts)
        for index, verdict in zip(indices, verdicts, strict=True):
            if verdict.verdict == DISAGREED:
                self._keep(answered, index, verdict)

    def _keep(self, answered: _Answered, index: int, verdict: Verdict) -> None:
        """Report the first disagreement of each two shape types, and write its replay file."""
        query, results = answered.view.query, answered.results
        kinds = kinds_of(query, results, index)
        if kinds in self._seen:
            return

        def replay() -> Replay:
            accuracy, reach = answered.accuracy, answered.max_distance
            return recorded(query, results, index, accuracy, reach, opinion=verdict.opinion)

        text = f'python-fcl disagrees about a result of {kinds} ({verdict.text})'
        text += kept(replay, kinds, *self._replay_settings())
        self._tell_once(kinds, text)

    def _tell_once(self, about: str, text: str) -> None:
        """Have something logged, unless it was before."""
        with self._lock:
            if about not in self._seen:
                self._seen.add(about)
                self._told.append(text)
