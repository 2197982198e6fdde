"""Decides once more about all rules, pair by pair, from what was recorded; knows what is certain.

Times are of this process, which sends and hears: that the node took a pose, or decided, is known
to be between two of them. So of each fact there are two: what must be, and what may be. A decision
that must be and is not is missing or late; one that was made and cannot be is unfounded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bench.ros.rules.cell import STALE_AFTER, STANDING, Bodies, Rule, body_of
from drake_geom_ros.math import RigidTransform

_ROUNDING = 1e-9  # [m] of poses that went through quaternions
_LOOSE = 1e-6  # [m] wider than any bound of level exact here
_PATIENCE = 1.0  # [s] in which a node looks at poses that grow old, on a machine that is busy
Pairs = frozenset[frozenset[str]]


class Facts(NamedTuple):
    """What is certain for a while."""

    rules: dict[str, Rule]
    filtered: Pairs = frozenset()  # surely
    in_doubt: Pairs = frozenset()  # filtered, or not any more
    is_exact: bool = True  # the level
    unposed: frozenset[str] = frozenset()  # sources whose poses are unknown, or of unknown age


@dataclass
class Step:
    """Poses that were sent and answered by a cycle, and what was heard until the next one."""

    stamp: int  # [ns] that no other step has
    sent: float  # [s]
    heard: float  # [s] when its cycle was reported
    places: dict[str, RigidTransform]  # of all bodies, as far as they ever had one
    posed: dict[str, tuple[float, float]]  # by source, when it was sent last, and heard of
    facts: Facts  # when the cycle ran
    later: list[Facts] = field(default_factory=list)  # and until the next one
    events: list[Heard] = field(default_factory=list)
    until: float = -math.inf  # [s] when the next one was sent


class Heard(NamedTuple):
    """An entry of ProximityEvents, as ProximityMonitor tells it, and when it was heard [s]."""

    event: Any
    at: float


@dataclass
class _State:
    """What is certain of a rule."""

    entered: bool = False
    since: tuple[float, float] = (-math.inf, -math.inf)  # [s] at the earliest, at the latest
    near_since: tuple[float, float] = (math.inf, math.inf)  # may be, and must be


class Referee:
    """Looks at steps, one after the other, and keeps what was wrong."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.decisions = 0
        self.undecided = 0  # where poses are as near to a limit as numbers tell
        self._bodies = Bodies()
        self._states: dict[str, _State] = {}
        self._next = 1

    def begin_anew(self) -> None:
        """Know that the node did."""
        self._states, self._next = {}, 1

    def look(self, step: Step) -> None:
        """Judge all that was decided by the poses of a step."""
        self._bodies.pose(step.places)
        bodies = set(step.places) | set(STANDING)
        distances: dict[frozenset[str], tuple[float, float]] = {}
        rules = {**step.facts.rules, **{n: r for f in step.later for n, r in f.rules.items()}}
        for rule in rules.values():
            for pair in rule.pairs():
                if pair <= bodies and pair not in distances:
                    distances[pair] = self._bodies.distance(pair)
        events: dict[str, list[Heard]] = {name: [] for name in rules}
        for heard in step.events:
            if heard.event.sequence != self._next:
                self._problem(step, f'event {heard.event.sequence} after {self._next - 1}')
            self._next = heard.event.sequence + 1
            self.decisions += 1
            if heard.event.rule not in rules:
                self._problem(step, f'an event of {heard.event.rule!r}, which is no rule')
            else:
                events[heard.event.rule].append(heard)
        for name, rule in rules.items():
            _OneRule(self, step, rule, distances).judge(events[name])

    def state(self, name: str) -> _State:
        """Return what is certain of a rule."""
        return self._states.setdefault(name, _State())

    def forget(self, name: str) -> None:
        """Know nothing more of a rule that is gone."""
        self._states.pop(name, None)

    def _problem(self, step: Step, text: str) -> None:
        self.problems.append(f'step {step.stamp}: {text}')

    def tell(self, step: Step, rule: Rule, text: str) -> None:
        """Keep that a decision about a rule was wrong."""
        self._problem(step, f'{rule}: {text}')


class _OneRule:
    """What must be and may be of one rule at one step."""

    def __init__(
        self,
        referee: Referee,
        step: Step,
        rule: Rule,
        distances: dict[frozenset[str], tuple[float, float]],
    ) -> None:
        self._referee, self._step, self._rule, self._distances = referee, step, rule, distances
        self._state = referee.state(rule.name)
        facts = [step.facts, *step.later]
        mine = rule.pairs()
        self._sure = mine - step.facts.filtered - step.facts.in_doubt
        self._ever = frozenset().union(*(mine - f.filtered for f in facts))  # may count
        self._always = mine - frozenset().union(*(f.filtered | f.in_doubt for f in facts))
        needed = {body.partition('::')[0] for pair in self._ever for body in pair}
        self._needed = needed - set(STANDING)
        must = {body.partition('::')[0] for pair in self._sure for body in pair}
        self._surely_needed = must - set(STANDING)
        self._unposed_ever = frozenset().union(*(f.unposed for f in facts))

    def _tell(self, text: str) -> None:
        self._referee.tell(self._step, self._rule, text)

    def judge(self, events: Sequence[Heard]) -> None:
        """Judge its events, then whether any is missing."""
        was_entered = self._state.entered
        self._follow_near()
        for heard in events:
            if heard.event.why == 'gone':
                self._judge_end(heard)
                return
            if heard.event.entered == self._state.entered:
                self._tell(f'it was {"entered" if heard.event.entered else "left"} twice')
            elif heard.event.entered:
                self._judge_entering(heard)
            else:
                self._judge_leaving(heard)
            self._state.entered = heard.event.entered
            self._state.since = self._step.sent, heard.at
        if self._rule.name in self._step.facts.rules:
            self._judge_silence(events, was_entered=was_entered)

    def _known(self, pairs: Pairs) -> list[tuple[float, float]]:
        return [self._distances[pair] for pair in pairs if pair in self._distances]

    def _follow_near(self) -> None:
        rule, step, state = self._rule, self._step, self._state
        may = any(d - e - self._margin() < rule.enter for d, e in self._known(self._ever))
        must = any(d + e + _ROUNDING < rule.enter for d, e in self._known(self._sure))
        must &= rule.name in step.facts.rules
        first, last = state.near_since
        first = min(first, step.sent) if may else math.inf
        last = min(last, step.heard) if must else math.inf
        state.near_since = first, last

    def _margin(self) -> float:
        exact = all(f.is_exact for f in [self._step.facts, *self._step.later])
        return _LOOSE if exact else math.inf

    def _judge_entering(self, heard: Heard) -> None:
        event, rule = heard.event, self._rule
        if event.why == 'near':
            if (wrong := self._wrong_pair(event)) or (wrong := self._too_early(heard)):
                self._tell(f'entered by {event.geometry_a}, {event.geometry_b}: {wrong}')
        elif event.why in ('stale', 'no pose'):
            if not rule.enters_when_stale:
                self._tell(f'entered for {event.why}, which it does not ask for')
            if not self._may_be_stale(heard.at):
                self._tell('entered for stale poses, and all that it needs were fresh')
        else:
            self._tell(f'entered for {event.why}')

    def _wrong_pair(self, event: Any) -> str:
        """Return why the pair of an event is no reason; empty where it is."""
        pair = frozenset((body_of(event.geometry_a), body_of(event.geometry_b)))
        if pair not in self._ever:
            return 'a pair that does not count'
        if pair not in self._distances:
            return 'a pair that has no pose'
        d, bound = self._distances[pair]
        if abs(event.distance - d) > event.error_bound + bound + _ROUNDING:
            return f'{event.distance} ± {event.error_bound} m, and it is {d} m'
        if not event.distance - event.error_bound < self._rule.enter:
            return 'not below enter'
        return ''

    def _too_early(self, heard: Heard) -> str:
        since = heard.at - self._state.near_since[0]
        return '' if since >= self._rule.enter_after else f'near for {since} s only'

    def _judge_leaving(self, heard: Heard) -> None:
        rule = self._rule
        near = [d for d, e in self._known(self._always) if d + e + _ROUNDING < rule.leave]
        if near and rule.name in self._step.facts.rules:
            self._tell(f'left while a pair is {min(near)} m apart')
        if heard.at - self._state.since[0] < rule.hold:
            self._tell('left before hold')
        if self._unposed_ever == self._step.facts.unposed and self._is_stale(self._step.sent):
            self._tell('left while poses are stale')

    def _judge_end(self, heard: Heard) -> None:
        if all(self._rule.name in facts.rules for facts in self._step.later):
            self._tell('ended, and nobody removed it')
        self._referee.forget(self._rule.name)

    def _judge_silence(self, events: Sequence[Heard], *, was_entered: bool) -> None:
        """Tell of a decision that had to come by the cycle of the step."""
        rule, step = self._rule, self._step
        if not was_entered and not any(heard.event.entered for heard in events):
            if step.sent - self._state.near_since[1] >= rule.enter_after or (
                not rule.enter_after and self._state.near_since[1] <= step.heard
            ):
                self._tell('missing or late: a pair is near, and it was not entered')
            late = max(step.sent, step.until - _PATIENCE)
            if rule.enters_when_stale and self._is_stale(late):
                self._tell('missing or late: poses are stale, and it was not entered')
        if was_entered and not events and step.facts.is_exact:
            limits = self._known(rule.pairs() - step.facts.filtered)
            clear = all(d - e - _LOOSE >= rule.leave for d, e in limits)
            is_old = step.sent - self._state.since[1] >= rule.hold
            if clear and is_old and not self._may_be_stale(step.heard, now=True):
                self._tell('missing or late: all is far, and it was not left')

    def _may_be_stale(self, at: float, *, now: bool = False) -> bool:
        """Return whether a pose that it needs may have been stale then; not ``now``: or before."""
        unposed = self._step.facts.unposed if now else self._unposed_ever
        ages = [at - self._step.posed.get(s, (-math.inf, 0.0))[0] for s in self._needed]
        return bool(self._needed & unposed) or any(age > STALE_AFTER for age in ages)

    def _is_stale(self, at: float) -> bool:
        """Return whether a pose that it needs surely was stale at a time."""
        ages = [at - self._step.posed.get(s, (0.0, -math.inf))[1] for s in self._surely_needed]
        unposed = self._step.facts.unposed
        return bool(self._surely_needed & unposed) or any(age > STALE_AFTER for age in ages)
