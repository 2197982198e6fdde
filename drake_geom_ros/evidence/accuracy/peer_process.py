"""A peer in a process of its own, which may crash or hang without harm.

Its libraries do not meet those of the others either. Times are taken inside: what it costs to
talk to the process is not in them.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import resource
import time
from collections import Counter
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.evidence import peers
from drake_geom_ros.evidence.accuracy.samples import Sample
from drake_geom_ros.evidence.accuracy.solids import Solid
from drake_geom_ros.evidence.truth.supports import Floats
from drake_geom_ros.math import RigidTransform, RotationMatrix

START_LIMIT = 60.0  # [s] to start and to import the library
LIMIT = 5.0  # [s] for one pair to be made and asked: milliseconds, usually
BLOCK_LIMIT = 60.0  # [s] for a block of timed calls
MOST_LOST = 2  # processes that a query of one subject may cost; the rest of it is not asked

ANSWERED, MISSED, NAN, EXCEPTION, CRASH, HANG, UNSUPPORTED, NOT_ASKED = VERDICTS = (
    'answered',
    'missed',  # no penetration reported
    'nan',
    'exception',
    'crash',
    'hang',
    'unsupported',
    'not asked',  # after too many lost processes
)


class Outcome(NamedTuple):
    """What became of a question; ``distance`` [m] is NaN without an answer."""

    verdict: str
    distance: float = math.nan


class PeerProcess:
    """Starts the process when it is first needed, and again when it was lost."""

    def __init__(self, name: str, limit: float = LIMIT) -> None:
        self.name, self._limit = name, limit
        self._methods = multiprocessing.get_context('forkserver')
        self._methods.set_forkserver_preload([__name__])
        self._process: Any = None
        self._samples: list[Sample] = []
        self._lost: Counter[str] = Counter()  # processes, by query

    def begin(self) -> None:
        """Forget all samples."""
        self._samples, self._lost = [], Counter()
        if self._process is not None:
            self._connection.send(('forget',))

    def give(self, samples: Sequence[Sample]) -> None:
        """Add samples, which are numbered in the order in which they came."""
        self._samples += samples
        if self._process is not None:
            self._connection.send(('give', samples))

    def answer(self, query: str, tolerance: float | None, index: int) -> Outcome:
        """Return what the peer says to a sample, with its own settings or one tolerance."""
        if self._lost[query] >= MOST_LOST:
            return Outcome(NOT_ASKED)
        outcome: Outcome = self._request(self._limit, 'answer', query, tolerance, index)
        self._lost[query] += outcome.verdict in (CRASH, HANG)
        return outcome

    def seconds(
        self, query: str, tolerance: float | None, indices: Sequence[int], turns: Floats
    ) -> float | None:
        """Return the mean seconds of one call for some of the samples; None without.

        Each of them is turned as a whole, by ``turns`` (k, 3, 3).
        """
        taken = self._request(BLOCK_LIMIT, 'time', query, tolerance, list(indices), turns)
        return None if isinstance(taken, Outcome) else float(taken)

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._connection.close()
            self._process = None

    def _request(self, limit: float, *request: Any) -> Any:
        """Return what the process answers; an Outcome when it is lost over it."""
        try:
            if self._process is None:
                self._start()
            self._connection.send(request)
            if self._connection.poll(limit):
                return self._connection.recv()
            lost = Outcome(HANG)
        except (EOFError, OSError):
            lost = Outcome(CRASH)
        self.close()
        return lost

    def _start(self) -> None:
        self._connection, theirs = self._methods.Pipe()
        self._process = self._methods.Process(target=_serve, args=(theirs, self.name), daemon=True)
        self._process.start()
        theirs.close()
        if not self._connection.poll(START_LIMIT):
            raise EOFError
        self._connection.recv()
        self._connection.send(('give', self._samples))


def _serve(connection: Connection, name: str) -> None:
    """Answer requests until the other side is gone."""
    # What a library prints while it dies is no output of ours, and nobody reads its core.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    server = _Server(name)
    connection.send('ready')
    while True:
        try:
            what, *arguments = connection.recv()
        except EOFError:
            return
        answer = getattr(server, what)(*arguments)
        if what in ('answer', 'time'):
            connection.send(answer)


class _Server:
    """Pairs that were made for a peer, by query, tolerance and number of the sample."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._loaded: dict[float | None, peers.Peer] = {None: peers.load(name)}
        # Imports the library, and what reads hulls, which is no part of a limit.
        hull = Solid('Convex', vertices=np.vstack([np.zeros(3), np.eye(3)])).shape
        self._loaded[None].pair(peers.PENETRATION, hull, hull)
        self.forget()

    def forget(self) -> None:
        self._samples: list[Sample] = []
        self._asks: dict[tuple[str, float | None, int], peers.Ask] = {}

    def give(self, samples: Sequence[Sample]) -> None:
        self._samples += samples

    def answer(self, query: str, tolerance: float | None, index: int) -> Outcome:
        sample = self._samples[index]
        try:
            found = self._ask(query, tolerance, index)(_pose(sample.X_WA), _pose(sample.X_WB))
        except peers.Unsupported:
            return Outcome(UNSUPPORTED)
        except Exception:  # whatever a library raises for numbers that it does not like
            return Outcome(EXCEPTION)
        if found is None:
            return Outcome(MISSED)
        return Outcome(ANSWERED if math.isfinite(found.distance) else NAN, float(found.distance))

    def time(
        self, query: str, tolerance: float | None, indices: Sequence[int], turns: Floats
    ) -> float | Outcome:
        work = [
            (self._ask(query, tolerance, i), _pose(s.X_WA, turn), _pose(s.X_WB, turn))
            for i, turn in zip(indices, turns, strict=True)
            for s in [self._samples[i]]
        ]
        try:
            start = time.thread_time()
            for ask, X_WA, X_WB in work:
                ask(X_WA, X_WB)
            return (time.thread_time() - start) / len(work)
        except Exception:  # a turned pair may be one that the library does not like
            return Outcome(EXCEPTION)

    def _ask(self, query: str, tolerance: float | None, index: int) -> peers.Ask:
        key = query, tolerance, index
        if key not in self._asks:
            if tolerance not in self._loaded:
                self._loaded[tolerance] = peers.load(self._name, tolerance)
            sample = self._samples[index]
            pair = self._loaded[tolerance].pair(query, sample.a.shape, sample.b.shape)
            self._asks[key] = pair
        return self._asks[key]


def _pose(X: tuple[Floats, Floats], turn: Floats | None = None) -> RigidTransform:
    R, p = X if turn is None else (turn @ X[0], turn @ X[1])
    return RigidTransform(RotationMatrix(np.asarray(R)), p)
