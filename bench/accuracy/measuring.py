"""The measurement: errors of all, then times in turns, so that noise meets everybody alike."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from bench.accuracy.cases import ShapePair, Subject
from bench.accuracy.peer_process import ANSWERED, MISSED, PeerAnswer, PeerProcess
from bench.accuracy.results import OURS, Measured, Setting
from truth import peers
from truth.bodies.random_bodies import random_rotations
from truth.hard_cases.cases import Case
from truth.judging.asking import LEVELS, PENETRATION, POINTS, SIGNED_DISTANCE
from truth.tolerances import EASY, PEER_TOLERANCES, TOUCHING

TIMED_CALLS = 30  # of a peer in its turn
OWN = 'own settings'


@dataclass(frozen=True)
class Plan:
    """How much is measured of each subject: at least and at most so many batches, and turns."""

    least_batches: int = 2
    most_batches: int = 16
    turns: int = 15
    seed: int = 0
    tolerances: bool = True


@dataclass(frozen=True)
class Rival:
    """A peer at one of its settings."""

    process: PeerProcess
    tolerance: float | None

    @property
    def setting(self) -> Setting:
        """How it is called in the records."""
        label = OWN if self.tolerance is None else f'{self.tolerance:g}'
        return Setting(self.process.name, label)


class _Query:
    """One query of a subject: its samples, all records, and the outcomes of the rivals."""

    def __init__(self, subject: Subject, query: str, rivals: Sequence[Rival]) -> None:
        self.name = query
        # To peers a point is a sphere of radius 0.
        self.of_peers = peers.SIGNED_DISTANCE if query == POINTS else query
        self.known: list[Case] = []
        mine = [Setting(OURS, level) for level in LEVELS]
        self.mine, self.theirs = (
            [Measured(subject.name, subject.family, query, setting) for setting in settings]
            for settings in (mine, [rival.setting for rival in rivals])
        )
        self.outcomes: list[list[tuple[int, Case, PeerAnswer]]] = [[] for _ in rivals]


class Measurement:
    """Measures subjects with the peers that it was given, and keeps the records."""

    def __init__(self, plan: Plan, peer_names: Sequence[str]) -> None:
        self.plan = plan
        self.records: list[Measured] = []
        # Seconds of a call of a peer with hardly any arithmetic, by setting and query.
        self.overheads: dict[tuple[Setting, str], float] = {}
        self._rng = np.random.default_rng(plan.seed)
        self._processes = [PeerProcess(name) for name in peer_names]
        self._rivals = [
            Rival(process, tolerance)
            for process in self._processes
            for tolerance in (
                None,
                *(PEER_TOLERANCES.get(process.name, ()) if plan.tolerances else ()),
            )
        ]

    def close(self) -> None:
        """End the peers' processes."""
        for process in self._processes:
            process.close()

    def calibrate(self) -> None:
        """Measure what a call of each peer costs at least: two spheres, a few ns of arithmetic."""
        if not self._rivals:
            return
        spheres = ShapePair('Sphere', 'Sphere')
        for query in self._asked(spheres, float('-inf')):
            for rival, seconds in zip(
                self._rivals, self._turns(query, _nothing, easy=True), strict=True
            ):
                if seconds:
                    self.overheads[rival.setting, query.of_peers] = median(seconds)

    def measure(self, subject: Subject, seconds: float) -> list[Measured]:
        """Return the records of a subject; batches are asked until some seconds are over."""
        records = []
        for query in self._asked(subject, time.monotonic() + seconds):
            self._time(subject, query)
            records += [*query.mine, *query.theirs]
        self.records += records
        return records

    def _asked(self, subject: Subject, end: float) -> list[_Query]:
        """Return the queries with the answers of everybody."""
        queries = [_Query(subject, query, self._rivals) for query in subject.queries]
        for process in self._processes:
            process.begin()
        count = 0
        for number, batch in enumerate(subject.batches(self.plan.seed), 1):
            for process in self._processes:
                process.give(batch)
            for index, sample in enumerate(batch, count):
                for query in queries:
                    if query.name != PENETRATION or sample.distance < -TOUCHING:
                        self._ask(subject, query, sample, index)
            count += len(batch)
            late = time.monotonic() > end and number >= self.plan.least_batches
            if late or number == self.plan.most_batches:
                break
        return queries

    def _ask(self, subject: Subject, query: _Query, sample: Case, index: int) -> None:
        """Ask everybody about a sample."""
        query.known.append(sample)
        answers = subject.answers(sample, query.name)
        for record, answer in zip(query.mine, answers, strict=True):
            if answer is None:
                record.verdicts[MISSED] += 1
            else:
                record.add(sample, *answer)
        for k, rival in enumerate(self._rivals):
            outcome = rival.process.answer(query.of_peers, rival.tolerance, index)
            query.outcomes[k].append((index, sample, outcome))
            if outcome.verdict == ANSWERED:
                query.theirs[k].add(sample, outcome.distance)
            else:
                query.theirs[k].verdicts[outcome.verdict] += 1

    def _time(self, subject: Subject, query: _Query) -> None:
        """Record medians of everybody's turns."""
        if not query.known:
            return
        timed, pairs = subject.timed(query.name, query.known)
        spent: list[list[tuple[float, float]]] = [[] for _ in query.mine]

        def our_turns() -> None:
            # In random order: the first level finds cold caches after the peers' turns.
            for k in self._rng.permutation(len(LEVELS)):
                spent[k].append(timed.cycle(query.name, LEVELS[k], self._rng, max(pairs, 1)))

        our_turns()  # compiles, or loads, what is needed
        calls = self._turns(query, our_turns)
        for record, taken in zip(query.mine, spent, strict=True):
            whole, kernels = zip(*taken[1:], strict=True)
            record.whole, record.inside = median(whole), median(kernels)
        for rival, record, seconds in zip(self._rivals, query.theirs, calls, strict=True):
            if seconds:
                least = self.overheads.get((rival.setting, query.of_peers), 0.0)
                record.whole = median(seconds)
                record.inside = max(record.whole - least, 0.0)

    def _turns(
        self, query: _Query, our_turns: Callable[[], None], easy: bool = False
    ) -> list[list[float]]:
        """Return the seconds a call of each turn of each rival, between which come ours.

        A rival is timed on samples that it answered; ``easy``: on those that are apart, or, asked
        about penetration, overlap.
        """
        spent: list[list[float]] = [[] for _ in self._rivals]
        sound = [
            [
                index
                for index, sample, outcome in outcomes
                if outcome.verdict in (ANSWERED, MISSED)
                and not (easy and query.name == SIGNED_DISTANCE and sample.distance < EASY)
            ]
            for outcomes in query.outcomes
        ]
        gc.collect()
        gc.disable()
        try:
            for _ in range(self.plan.turns):
                our_turns()
                for rival, indices, taken in zip(self._rivals, sound, spent, strict=True):
                    if not indices:
                        continue
                    chosen = self._rng.permutation(indices)[:TIMED_CALLS].tolist()
                    rotations = random_rotations(self._rng, len(chosen))
                    seconds = rival.process.seconds(
                        query.of_peers, rival.tolerance, chosen, rotations
                    )
                    if seconds is not None:
                        taken.append(seconds)
        finally:
            gc.enable()
        return spent


def _nothing() -> None:
    """Take no turn of ours."""
