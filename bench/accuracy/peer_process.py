"""A peer in a process of its own: what it answers to samples, and how long that takes it.

Times are taken inside: what it costs to talk to the process is not in them.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.cross_check.lost_process import ANSWER, LostProcess, QuestionOutcome
from drake_geom_ros.math.array_types import Floats
from truth import peers

LIMIT = 5.0  # [s] for one pair to be made and asked: milliseconds, usually
BLOCK_LIMIT = 60.0  # [s] for a block of timed calls
MOST_LOST = 2  # processes that a query of one subject may cost; the rest of it is not asked

ANSWERED, NAN, UNSUPPORTED = 'answered', 'nan', 'unsupported'
MISSED = 'missed'  # no penetration reported
NOT_ASKED = 'not asked'  # after too many lost processes


class PeerAnswer(NamedTuple):
    """What became of a question; ``distance`` [m] is NaN without an answer."""

    verdict: str
    distance: float = math.nan


class PeerProcess:
    """Asks a peer about samples, which are numbered in the order in which they were given."""

    def __init__(self, name: str, limit: float = LIMIT) -> None:
        self.name, self._limit = name, limit
        self._process = LostProcess(partial(_Server, name), clean=__name__)
        self._samples: list[Pair] = []
        self._lost: Counter[str] = Counter()  # processes, by query

    def begin(self) -> None:
        """Forget all samples."""
        self._samples, self._lost = [], Counter()
        self._keep('forget')

    def give(self, samples: Sequence[Pair]) -> None:
        """Add samples."""
        self._samples += samples
        self._keep('give', samples)

    def answer(self, query: str, tolerance: float | None, index: int) -> PeerAnswer:
        """Return what the peer says to a sample, with its own settings or one tolerance."""
        if self._lost[query] >= MOST_LOST:
            return PeerAnswer(NOT_ASKED)
        outcome = self._ask(self._limit, 'answer', query, tolerance, index)
        self._lost[query] += outcome.is_lost
        answer: PeerAnswer = outcome.value if outcome.end == ANSWER else PeerAnswer(outcome.end)
        return answer

    def seconds(
        self, query: str, tolerance: float | None, indices: Sequence[int], turns: Floats
    ) -> float | None:
        """Return the mean seconds of one call for some of the samples; None without.

        Each of them is turned as a whole, by ``turns`` (k, 3, 3).
        """
        outcome = self._ask(BLOCK_LIMIT, 'time', query, tolerance, list(indices), turns)
        return float(outcome.value) if outcome.end == ANSWER else None

    def close(self) -> None:
        """End the process."""
        self._process.close()

    def _keep(self, *request: Any) -> None:
        """Tell a process that runs; one that starts is given all samples."""
        if self._process.is_running:
            self._process.ask(BLOCK_LIMIT, *request)

    def _ask(self, limit: float, *request: Any) -> QuestionOutcome:
        if not self._process.is_running:
            given = self._process.ask(BLOCK_LIMIT, 'give', self._samples)
            if given.is_lost:
                return given
        return self._process.ask(limit, *request)


class _Server:
    """Pairs that were made for a peer, by query, tolerance and number of the sample."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._loaded: dict[float | None, peers.Peer] = {None: peers.load(name)}
        # Imports the library, and what reads hulls, which is no part of a limit.
        hull = Body('Convex', np.vstack([np.zeros(3), np.eye(3)])).shape
        self._loaded[None].pair(peers.PENETRATION, hull, hull)
        self.forget()

    def __call__(self, what: str, *arguments: Any) -> Any:
        """Do what is asked for."""
        return getattr(self, what)(*arguments)

    def forget(self) -> None:
        self._samples: list[Pair] = []
        self._asks: dict[tuple[str, float | None, int], peers.Ask] = {}

    def give(self, samples: Sequence[Pair]) -> None:
        self._samples += samples

    def answer(self, query: str, tolerance: float | None, index: int) -> PeerAnswer:
        sample = self._samples[index]
        try:
            found = self._ask(query, tolerance, index)(sample.a.pose, sample.b.pose)
        except peers.Unsupported:
            return PeerAnswer(UNSUPPORTED)
        if found is None:
            return PeerAnswer(MISSED)
        return PeerAnswer(
            ANSWERED if math.isfinite(found.distance) else NAN, float(found.distance)
        )

    def time(
        self, query: str, tolerance: float | None, indices: Sequence[int], turns: Floats
    ) -> float:
        work = []
        for index, R in zip(indices, turns, strict=True):
            turned = self._samples[index].moved(R, np.zeros(3))
            work.append((self._ask(query, tolerance, index), turned.a.pose, turned.b.pose))
        start = time.thread_time()
        for ask, X_WA, X_WB in work:  # a turned pair may be one that the library refuses
            ask(X_WA, X_WB)
        return (time.thread_time() - start) / len(work)

    def _ask(self, query: str, tolerance: float | None, index: int) -> peers.Ask:
        key = query, tolerance, index
        if key not in self._asks:
            if tolerance not in self._loaded:
                self._loaded[tolerance] = peers.load(self._name, tolerance)
            sample = self._samples[index]
            pair = self._loaded[tolerance].pair(query, sample.a.shape, sample.b.shape)
            self._asks[key] = pair
        return self._asks[key]
