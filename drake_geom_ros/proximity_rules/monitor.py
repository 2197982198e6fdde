"""The rules of a scene, their states, and what changes of them: events without a gap."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.proximity_rules.decisions import (
    Entered,
    Limits,
    Poses,
    Reasons,
    prepare,
    step,
    take_nearest,
)
from drake_geom_ros.proximity_rules.events import Event, Seen, events_of, events_of_gone
from drake_geom_ros.proximity_rules.measured import Measured
from drake_geom_ros.proximity_rules.rule import ProximityRule, RuleError, Why
from drake_geom_ros.proximity_rules.speed_scale import SpeedScale
from drake_geom_ros.proximity_rules.watched_pairs import ScenePairs, WatchedPairs


class RuleState(NamedTuple):
    """What is to be known of a rule now."""

    rule: ProximityRule
    is_entered: bool
    why: Why | None  # what it is entered for, now where that still holds
    since: float  # [s] of the clock that ``decide`` is given; -inf: it never changed
    lowest: float  # [m] the least lower bound of its pairs; inf: none was near enough to see
    pairs: int  # that it watches
    left_out: int  # of its two sets, that are never reported
    trouble: str  # why it can never be entered as the scene is; empty where it can
    lacking: tuple[str, ...]  # names that it goes on without, for they stand for nothing any more
    unpredicted: bool  # times count for it, and nobody knows how all that it needs moves


class RuleStates(NamedTuple):
    """What is to be known of all rules (r,) now, in the order in which they came; see RuleState.

    Without an object for each, which takes longer than to decide about them.
    """

    rules: Sequence[ProximityRule]
    is_entered: NDArray[np.bool_]
    why: NDArray[np.uint8]  # 0: it is not entered
    since: NDArray[np.float64]
    lowest: NDArray[np.float64]
    pairs: NDArray[np.int64]
    left_out: NDArray[np.int64]
    trouble: Sequence[str]
    lacking: Sequence[tuple[str, ...]]
    unpredicted: NDArray[np.bool_]

    def each(self) -> list[RuleState]:
        """Return the state of each rule."""
        columns = [np.asarray(column).tolist() for column in self[3:7]]
        return list(
            map(
                RuleState,
                self.rules,
                self.is_entered.tolist(),
                [Why(why) if why else None for why in self.why.tolist()],
                *columns,
                self.trouble,
                self.lacking,
                self.unpredicted.tolist(),
            )
        )


class RuleMonitor:
    """Decides about rules, cycle for cycle. Times [s] are of one clock that never runs back."""

    def __init__(self, scene: ScenePairs, first_sequence: int = 1) -> None:
        self._scene = scene
        self._sequence = first_sequence
        self._met: frozenset[str] = frozenset()  # the rules that found all that they name
        self.changes_of_why = 0  # cycles in which the reason of any rule changed
        self._set((), Entered.of_new(0))

    # Rules come and go.

    def add(self, rules: Iterable[ProximityRule], *, may_wait: bool = False) -> list[str]:
        """Add rules, all or none; return what is wrong with them.

        A name that is taken is refused by a RuleError, and so is a rule that could never be
        entered as the scene is, unless it ``may_wait`` for what it names: then that is told.
        """
        added = tuple(rules)
        taken = {rule.name for rule in self.rules}
        for rule in added:
            if rule.name in taken:
                raise RuleError(
                    f'there is a proximity rule {rule.name[:80]!r} already; remove it first'
                )
            taken.add(rule.name)
        watched = WatchedPairs(added, self._scene)
        told = list(filter(None, watched.trouble))
        if told and not may_wait:
            raise RuleError(told[0])
        states = self._entered.of([*range(len(self.rules)), *[-1] * len(added)])
        self._set((*self.rules, *added), states)
        return told

    def remove(self, *names: str) -> list[Event]:
        """Remove rules, all or none; return the events that they are gone.

        Raises RuleError where there is none of a name.
        """
        numbers = {rule.name: number for number, rule in enumerate(self.rules)}
        for name in names:
            if name not in numbers:
                raise RuleError(
                    f'there is no proximity rule {name[:80]!r}{nearest(name, numbers)}; '
                    'see list_proximity_rules'
                )
        return self._end([numbers[name] for name in names])

    def bind(self, scene: ScenePairs) -> list[Event]:
        """Be about another version of the scene; return the events of the rules that it ends.

        A rule is gone where nothing is left of one of its sets; where only some of its names
        stand for nothing now, it goes on with the others. Filters end none, for they come and go.
        """
        known, self._scene = self._watched.unknown, scene
        self._set(self.rules, self._entered)
        pairs = enumerate(zip(known, self._watched.unknown, strict=True))
        return self._end([number for number, (old, new) in pairs if new and not old])

    def _end(self, numbers: Sequence[int]) -> list[Event]:
        """Forget rules; return the events of that."""
        gone = events_of_gone(self._sequence, [self.rules[n] for n in numbers])
        self._sequence += len(gone)
        if numbers:
            ended = set(numbers)
            kept = [n for n in range(len(self.rules)) if n not in ended]
            self._set(tuple(self.rules[n] for n in kept), self._entered.of(kept))
        return gone

    def _set(self, rules: tuple[ProximityRule, ...], states: Entered) -> None:
        """Have these rules, in these states; nothing is known of distances until ``decide``."""
        self.rules, self._entered = rules, states
        self._watched = WatchedPairs(rules, self._scene, self._met)
        self._limits = Limits.of(rules, self._watched.groups)
        lacking = zip([rule.name for rule in rules], self._watched.unknown, strict=True)
        self._met = frozenset(name for name, lacks in lacking if not lacks or name in self._met)
        self._speed = SpeedScale(rules, self._watched)
        if rules:
            prepare()
        self._reasons = Reasons.of_nothing(len(rules))
        self._changed = np.empty(len(rules), dtype=np.int64)
        self._seen: Seen | None = None
        self.is_measured = False  # whether the distances of these pairs were looked at

    # Cycles.

    @property
    def watched(self) -> WatchedPairs:
        """The pairs that the rules are about."""
        return self._watched

    @property
    def next_sequence(self) -> int:
        """The number of the next event."""
        return self._sequence

    def farthest(self, fastest: float = 0.0) -> float:
        """Return how far [m] a cycle has to look, where pairs close at most this fast [m/s]."""
        return self._limits.farthest(fastest)

    def decide(
        self,
        now: float,
        poses: Poses,
        measured: Measured | None = None,
        farthest: float = math.inf,
    ) -> list[Event]:
        """Decide by what a cycle measured; None: nothing moved, and only time went on.

        Pairs that are surely beyond ``farthest`` [m] are left out, whoever measured these, too.

        Returns the changes, in the order of the rules. Before anything was measured, rules are
        entered for want of poses only, and none is left.
        """
        watched, limits = self._watched, self._limits
        reasons, entered = self._reasons, self._entered
        if measured is not None:
            nearest = watched.nearest_of_groups(measured, farthest)
            take_nearest(nearest, limits, reasons)
            reasons.unpredicted[:] = self._unpredicted(measured)
            self._seen, self.is_measured = Seen(measured, nearest), True
        reasons.blind[:] = 0
        for why, flags in poses.without():
            reasons.blind[watched.needs(flags)] = why
        reasons.blind[watched.is_unknown] = Why.NO_POSE
        before = entered.why.copy()
        count = step(now, limits, reasons, self.is_measured, entered, self._changed)
        self.changes_of_why += int(not np.array_equal(before, entered.why))
        if not count:
            return []
        first, changed = self._sequence, self._changed[:count]
        self._sequence += count
        return events_of(first, self.rules, changed, entered, watched, poses, self._seen)

    def _unpredicted(self, measured: Measured) -> NDArray[np.bool_]:
        """Return the rules (r,) that need to know a motion which nobody knows."""
        timed = self._limits.least_time > 0.0
        if measured.unpredicted is None or not timed.any():
            return np.zeros(len(self.rules), dtype=np.bool_)
        return timed & self._watched.needs(measured.unpredicted)

    def speed_scale(self) -> float | None:
        """Return how fast to go, 0 to 1; None: no rule says. 0 before anything was measured."""
        if not self._speed.is_asked_for:
            return None
        if not self.is_measured:
            return 0.0
        return self._speed.value(self._entered.is_entered, self._reasons, self._limits)

    def states(self) -> list[RuleState]:
        """Return the state of each rule, in the order in which they came."""
        return self.table().each()

    def table(self) -> RuleStates:
        """Return the states of all rules in arrays, to be read before anything else happens."""
        entered, watched, reasons = self._entered, self._watched, self._reasons
        return RuleStates(
            self.rules,
            is_entered=entered.is_entered,
            why=np.where(entered.is_entered, entered.why, np.uint8(0)),
            since=entered.since,
            lowest=reasons.lowest,
            pairs=watched.pairs,
            left_out=watched.left_out,
            trouble=watched.trouble,
            lacking=watched.lacking,
            unpredicted=reasons.unpredicted,
        )
