"""What must be and may be of one rule at one step."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from bench.ros.rules.cell import STALE_AFTER, STANDING, Rule, body_of
from bench.ros.rules.distances import Distances
from bench.ros.rules.records import Heard, Pairs, Posed, Step

_ROUNDING = 1e-9  # [m] of poses that went through quaternions
_LOOSE = 1e-6  # [m] wider than any bound of level exact here
_NEVER = Posed(-math.inf, -math.inf)


@dataclass
class State:
    """What is certain of a rule."""

    entered: bool = False
    since: tuple[float, float] = (-math.inf, -math.inf)  # [s] at the earliest, at the latest
    near_since: tuple[float, float] = (math.inf, math.inf)  # may be, and must be


class OneRule:
    """A rule, and a step at which it is judged."""

    def __init__(
        self,
        step: Step,
        rule: Rule,
        state: State,
        distances: Distances,
        decisions: Sequence[tuple[float, float]],
        tell: Callable[[str], None],
    ) -> None:
        self._step, self._rule, self._state = step, rule, state
        self._distances, self._decisions, self._tell = distances, decisions, tell
        self._is_rule = rule.name in step.facts.rules
        facts, mine = [step.facts, *step.later], rule.pairs()
        self._sure = mine - step.facts.filtered - step.facts.in_doubt
        self._may_be = mine - step.facts.filtered
        self._ever = frozenset().union(*(mine - f.filtered for f in facts))
        self._always = mine - frozenset().union(*(f.filtered | f.in_doubt for f in facts))
        self._unposed_ever = frozenset().union(*(f.unposed for f in facts))
        self._is_exact = all(f.is_exact for f in facts)

    def judge(self, events: Sequence[Heard]) -> bool:
        """Judge its events, then whether any is missing; return whether that is certain."""
        was_entered = self._state.entered
        self._follow_near()
        for heard in events:
            if heard.event.entered == self._state.entered:
                self._tell(f'it was {"entered" if heard.event.entered else "left"} twice')
            elif heard.event.entered:
                self._judge_entering(heard)
            else:
                self._judge_leaving(heard)
            self._state.entered = heard.event.entered
            self._state.since = self._step.sent, heard.at
        certain = True
        if self._is_rule and not events:
            certain = self._must_leave() if was_entered else self._must_enter()
        if not any(self._is_near(pair) for pair in self._always):
            self._state.near_since = self._state.near_since[0], math.inf
        return certain

    # Pairs.

    def _known(self, pairs: Pairs) -> list[tuple[float, float]]:
        there = self._step.places.keys() | STANDING.keys()
        return [self._distances.at(pair) for pair in pairs if pair <= there]

    def _is_near(self, pair: frozenset[str]) -> bool:
        """Return whether a pair surely enters the rule."""
        rule = self._rule
        if not pair <= self._step.places.keys() | STANDING.keys():
            return False
        d, e = self._distances.at(pair)
        if d + e + _ROUNDING < rule.enter:
            return True
        if not rule.min_time_to_contact or not self._is_exact or not self._moves_surely(pair):
            return False
        gap = self._distances.gap(pair)
        far = max(d + e + _ROUNDING, 0.0)
        return gap.slowest > 0.0 and far < gap.slowest * rule.min_time_to_contact

    def _may_be_near(self, pair: frozenset[str], limit: float) -> bool:
        """Return whether a pair may enter the rule, or be below a limit [m]."""
        rule = self._rule
        if not pair <= self._step.places.keys() | STANDING.keys():
            return False
        d, e = self._distances.at(pair)
        low = d - e - _LOOSE if self._is_exact else -math.inf
        if low < limit:
            return True
        if not rule.min_time_to_contact or not self._may_move(pair):
            return False
        gap = self._distances.gap(pair)
        return gap.fastest > 0.0 and max(low, 0.0) < gap.fastest * rule.min_time_to_contact

    def _moves_surely(self, pair: frozenset[str]) -> bool:
        """Return whether the twists of a pair are known at the cycle, and no other holds."""
        end = self._decisions[0][1] if self._decisions else math.inf
        return all(self._is_moving(source, end) for source in _sources([pair]))

    def _is_moving(self, source: str, at: float) -> bool:
        posed = self._step.posed.get(source, _NEVER)
        is_fresh = source not in self._unposed_ever and at - posed.sent <= STALE_AFTER
        return posed.twists is not None and is_fresh

    def _may_move(self, pair: frozenset[str]) -> bool:
        posed = [self._step.posed.get(source, _NEVER) for source in _sources([pair])]
        return all(
            each.twists is not None and self._step.sent - each.heard <= STALE_AFTER
            for each in posed
        )

    def _follow_near(self) -> None:
        step, state, decisions = self._step, self._state, self._decisions
        may = any(self._may_be_near(pair, self._rule.enter) for pair in self._ever)
        must = self._is_rule and any(self._is_near(pair) for pair in self._sure)
        first, last = state.near_since
        first = min(first, step.sent) if may else math.inf
        last = min(last, decisions[0][1]) if must and decisions else math.inf
        state.near_since = first, last

    # Events.

    def _judge_entering(self, heard: Heard) -> None:
        event, rule = heard.event, self._rule
        if event.why in ('near', 'soon'):
            if (wrong := self._wrong_pair(event)) or (wrong := self._too_early(heard)):
                self._tell(
                    f'entered ({event.why}) by {event.geometry_a}, {event.geometry_b}: {wrong}'
                )
        elif event.why in ('stale', 'no pose'):
            if not rule.enters_when_stale:
                self._tell(f'entered for {event.why}, which it does not ask for')
            if not self._may_be_stale(heard.at, self._unposed_ever):
                self._tell('entered for stale poses, and all that it needs were fresh')
        else:
            self._tell(f'entered for {event.why}')

    def _wrong_pair(self, event: Any) -> str:
        """Return why the pair of an event is no reason; empty where it is."""
        pair = frozenset((body_of(event.geometry_a), body_of(event.geometry_b)))
        if pair not in self._ever:
            return 'a pair that does not count'
        if not pair <= self._step.places.keys() | STANDING.keys():
            return 'a pair that has no pose'
        d, bound = self._distances.at(pair)
        if abs(event.distance - d) > event.error_bound + bound + _ROUNDING:
            return f'{event.distance} ± {event.error_bound} m, and it is {d} m'
        lower = event.distance - event.error_bound
        if event.why == 'near':
            return '' if lower < self._rule.enter else 'not below enter'
        if not self._may_move(pair):
            return 'nobody knows how the pair moves'
        gap, speed = self._distances.gap(pair), event.closing_speed
        if self._is_exact and not gap.slowest <= speed <= gap.fastest:
            return f'closing at {speed} m/s, and it is {gap.slowest} to {gap.fastest}'
        is_soon = speed > 0.0 and max(lower, 0.0) < speed * self._rule.min_time_to_contact
        return '' if is_soon else 'it would not touch so soon'

    def _too_early(self, heard: Heard) -> str:
        since = heard.at - self._state.near_since[0]
        return '' if since >= self._rule.enter_after else f'near for {since} s only'

    def _judge_leaving(self, heard: Heard) -> None:
        rule, step = self._rule, self._step
        near = [d for d, e in self._known(self._always) if d + e + _ROUNDING < rule.leave]
        if near and self._is_rule:
            self._tell(f'left while a pair is {min(near)} m apart')
        if heard.at - self._state.since[0] < rule.hold:
            self._tell('left before hold')
        if self._is_rule and self._is_stale(step.sent, self._always):
            self._tell('left while poses are stale')
        if self._is_rule and rule.min_time_to_contact and not near:
            self._judge_motion(heard)

    def _judge_motion(self, heard: Heard) -> None:
        """Judge that a rule was left for which a time to contact counts."""
        sources = _sources(self._always)
        posed = self._step.posed
        if any(source in posed and posed[source].twists is None for source in sources):
            self._tell('left while nobody knows how its bodies move')
        known = all(self._is_moving(source, heard.at) for source in sources)
        if known and any(self._is_near(pair) for pair in self._always):
            self._tell('left while a pair would touch too soon')

    # Silence.

    def _must_enter(self) -> bool:
        """Tell of an entering that is missing; return whether there surely is none."""
        rule, due = self._rule, self._state.near_since[1] + self._rule.enter_after
        last = max((begin for begin, _ in self._decisions), default=-math.inf)
        is_near = self._state.near_since[1] < math.inf
        if is_near and (not rule.enter_after or last >= due):
            self._tell('missing or late: a pair is near, and it was not entered')
        if rule.enters_when_stale and self._is_stale(last, self._sure):
            self._tell('missing or late: poses are stale, and it was not entered')
        is_far = not any(self._may_be_near(pair, rule.enter) for pair in self._may_be)
        is_fresh = not self._may_be_stale(max(last, self._step.sent), self._step.facts.unposed)
        return is_near or (is_far and (is_fresh or not rule.enters_when_stale))

    def _must_leave(self) -> bool:
        """Tell of a leaving that is missing; return whether there surely is none."""
        rule, facts, earliest = self._rule, self._step.facts, self._state.since[1]
        clear = not any(self._may_be_near(pair, rule.leave) for pair in self._may_be)
        due = [end for begin, end in self._decisions if begin - earliest >= rule.hold]
        is_fresh = bool(due) and not self._may_be_stale(due[0], facts.unposed)
        moves = not rule.min_time_to_contact or (
            bool(due) and all(self._is_moving(s, due[0]) for s in _sources(self._may_be))
        )
        if facts.is_exact and clear and is_fresh and moves:
            self._tell('missing or late: all is far, and it was not left')
        held = [d for d, e in self._known(self._sure) if d + e + _ROUNDING < rule.leave]
        return bool(held) or self._is_stale(self._step.sent, self._sure) or (clear and not due)

    # Ages.

    def _may_be_stale(self, at: float, unposed: frozenset[str]) -> bool:
        """Return whether a pose that it needs may have been stale then, or before."""
        needed = _sources(self._ever)
        ages = [at - self._step.posed.get(source, _NEVER).sent for source in needed]
        return bool(needed & unposed) or any(age > STALE_AFTER for age in ages)

    def _is_stale(self, at: float, pairs: Pairs) -> bool:
        """Return whether a pose that some pairs need surely was stale at a time."""
        needed, posed = _sources(pairs), self._step.posed
        ages = [at - posed[source].heard for source in needed if source in posed]
        return bool(needed & self._step.facts.unposed) or any(age > STALE_AFTER for age in ages)


def _sources(pairs: Pairs | Sequence[frozenset[str]]) -> frozenset[str]:
    """Return the robots that some pairs are of."""
    bodies = frozenset().union(*pairs) - STANDING.keys()
    return frozenset(body.partition('::')[0] for body in bodies)
