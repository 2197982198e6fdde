"""The measurement: errors of all, then times in turns, so that noise meets everybody alike."""

from __future__ import annotations

import gc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from drake_geom_ros import peers
from drake_geom_ros.accuracy import ours
from drake_geom_ros.accuracy.cases import PENETRATION, POINTS, SIGNED_DISTANCE, Case
from drake_geom_ros.accuracy.peer_process import ANSWERED, MISSED, Outcome, PeerProcess
from drake_geom_ros.accuracy.results import OURS, Measured, Setting
from drake_geom_ros.accuracy.samples import Sample, samples
from drake_geom_ros.accuracy.scenes import Scene
from drake_geom_ros.accuracy.solids import random_rotation
from drake_geom_ros.accuracy.timed import TimedScene, side_by_side

TIMED_PAIRS = 120  # of a case in one scene of ours: what a query costs once is shared by so many
TIMED_CALLS = 30  # of a peer in its turn
# The tolerances [m] of peers that have one, besides their own settings.
TOLERANCES = {'Coal': (1e-3, 1e-9), 'MuJoCo': (1e-3, 1e-9)}
OWN = 'own settings'


@dataclass(frozen=True)
class Plan:
    """How much is measured: samples of each configuration, pairs of a scene, turns of each."""

    samples: int = 8
    scene_pairs: int = 100
    turns: int = 7
    seed: int = 0
    tolerances: bool = True


class Measurement:
    """Measures cases and scenes with the peers that it was given, and keeps the records."""

    def __init__(self, plan: Plan, peer_names: Sequence[str], say: Callable[[str], None]) -> None:
        self.plan, self.say = plan, say
        self.records: list[Measured] = []
        self.overheads: dict[tuple[str, str, str], float] = {}
        self._rng = np.random.default_rng(plan.seed)
        self._peers = [
            (PeerProcess(name), tolerance)
            for name in peer_names
            for tolerance in (None, *(TOLERANCES.get(name, ()) if plan.tolerances else ()))
        ]
        # One process for all settings of a peer.
        first = {process.name: process for process, _ in reversed(self._peers)}
        self._peers = [(first[process.name], tolerance) for process, tolerance in self._peers]

    def close(self) -> None:
        """End the peers' processes."""
        for process, _ in self._peers:
            process.close()

    def calibrate(self) -> None:
        """Measure what a call of each peer costs at least: two spheres, a few ns of arithmetic."""
        pairs = list(samples(Case('Sphere', 'Sphere'), 4, self.plan.seed))
        for query in (SIGNED_DISTANCE, PENETRATION):
            known = _asked(pairs, query)
            for process, tolerance in self._peers:
                outcomes = process.answers(query, tolerance, known)
                seconds = [self._peer_turn(process, tolerance, query, known, outcomes)]
                seconds += [
                    self._peer_turn(process, tolerance, query, known, outcomes)
                    for _ in range(self.plan.turns)
                ]
                taken = [s for s in seconds if s is not None]
                if taken:
                    key = process.name, _label(tolerance), query
                    self.overheads[key] = median(taken)

    def case(self, case: Case) -> None:
        """Measure a pair of shapes."""
        found = list(samples(case, self.plan.samples, self.plan.seed))
        for query in case.queries():
            known = _asked(found, query)
            answers = [ours.answers(sample, query) for sample in known]
            by_level = {
                level: [each[k] for each in answers] for k, level in enumerate(ours.LEVELS)
            }
            tiled = [known[k % len(known)] for k in range(TIMED_PAIRS)]
            self._measure(case.name, case.family, query, known, by_level, side_by_side(tiled), TIMED_PAIRS)

    def scene(self, scene: Scene) -> None:
        """Measure a whole scene; of peers its pairs are asked one by one."""
        pairs = scene.pairs(self.plan.scene_pairs, self.plan.seed)
        for query in scene.queries:
            asked = [p for p in pairs if p[2] in _asked([s for _, _, s in pairs], query)]
            by_level = {}
            for level in ours.LEVELS:
                answers = scene.answers(query, level)
                by_level[level] = [answers.get((i, j)) for i, j, _ in asked]
            timed = scene.timed()
            timed.cycle(query, 'exact', self._rng, 1)
            known = [sample for _, _, sample in asked]
            self._measure(scene.name, scene.name, query, known, by_level, timed, timed.found())

    def _measure(
        self,
        name: str,
        family: str,
        query: str,
        known: list[Sample],
        by_level: dict[str, list[ours.Answer | None]],
        timed: TimedScene,
        timed_pairs: int,
    ) -> None:
        """Record our answers, ask the peers, and let all take turns to be timed."""
        mine = {level: Measured(name, family, query, Setting(OURS, level)) for level in by_level}
        for level, answers in by_level.items():
            for sample, answer in zip(known, answers, strict=True):
                if answer is None:
                    mine[level].verdicts[MISSED] += 1
                else:
                    mine[level].add(sample, answer.distance, answer.error_bound)
        theirs = []
        for process, tolerance in self._peers:
            record = Measured(name, family, query, Setting(process.name, _label(tolerance)))
            outcomes = process.answers(_peer_query(query), tolerance, known)
            for sample, outcome in zip(known, outcomes, strict=True):
                if outcome.verdict == ANSWERED:
                    record.add(sample, outcome.distance)
                else:
                    record.verdicts[outcome.verdict] += 1
            theirs.append((process, tolerance, record, outcomes))
        self._time(query, known, mine, timed, timed_pairs, theirs)
        self.records += [*mine.values(), *(record for _, _, record, _ in theirs)]

    def _time(self, query, known, mine, timed, timed_pairs, theirs):  # type: ignore[no-untyped-def]
        """Let everybody take turns; medians are kept."""
        for level in mine:
            timed.cycle(query, level, self._rng, timed_pairs)  # compiles, or loads, kernels
        taken = {level: [] for level in mine}
        calls = [[] for _ in theirs]
        gc.collect()
        gc.disable()
        try:
            for _ in range(self.plan.turns):
                for level in mine:
                    taken[level].append(timed.cycle(query, level, self._rng, timed_pairs))
                for k, (process, tolerance, _, outcomes) in enumerate(theirs):
                    seconds = self._peer_turn(
                        process, tolerance, _peer_query(query), known, outcomes
                    )
                    if seconds is None:
                        continue
                    calls[k].append(seconds)
        finally:
            gc.enable()
        for level, record in mine.items():
            record.whole = median(s.whole for s in taken[level])
            record.inside = median(s.kernels for s in taken[level])
        for (process, tolerance, record, _), seconds in zip(theirs, calls, strict=True):
            if seconds:
                record.whole = median(seconds)
                least = self.overheads.get(
                    (process.name, _label(tolerance), _peer_query(query)), 0.0
                )
                record.inside = max(record.whole - least, 0.0)

    def _peer_turn(
        self,
        process: PeerProcess,
        tolerance: float | None,
        query: str,
        known: Sequence[Sample],
        outcomes: Sequence[Outcome],
    ) -> float | None:
        """Return the seconds a call of a turn of a peer, on samples that it answered."""
        sound = [k for k, o in enumerate(outcomes) if o.verdict in (ANSWERED, MISSED)]
        if not sound:
            return None
        sound = self._rng.permutation(sound)[:TIMED_CALLS].tolist()
        turns = np.array([random_rotation(self._rng) for _ in sound])
        return process.seconds(query, tolerance, sound, turns)


def _asked(pairs: Sequence[Sample], query: str) -> list[Sample]:
    """Return the samples that a query is about: penetration, of those that overlap."""
    return [s for s in pairs if query != PENETRATION or s.truth < -1e-9]


def _peer_query(query: str) -> str:
    """Return what peers are asked: to them a point is a sphere of radius 0."""
    return peers.SIGNED_DISTANCE if query == POINTS else query


def _label(tolerance: float | None) -> str:
    return OWN if tolerance is None else f'{tolerance:g}'
