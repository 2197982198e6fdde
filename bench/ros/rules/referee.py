"""Decides once more about all rules, pair by pair, from what was recorded; knows what is certain.

Of each fact there are two: what must be, and what may be. A decision that must be and is not is
missing or late; one that was made and cannot be is unfounded; where neither is certain, that is
counted.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

from bench.ros.rules.cell import Bodies, Rule
from bench.ros.rules.distances import Distances
from bench.ros.rules.one_rule import OneRule, State
from bench.ros.rules.records import Heard, Step, Twist


class Referee:
    """Looks at steps, one after the other, and keeps what was wrong."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.decisions = 0  # that changed a rule
        self.silences, self.undecided = 0, 0  # rules that did not change; of which it may be wrong
        self._bodies = Bodies()
        self._states: dict[str, State] = {}
        self._ending: set[str] = set()  # removed after the step before, and not told yet
        self._first = self._next = 1

    def begin_anew(self, next_sequence: int, entered: Mapping[str, bool]) -> None:
        """Know that the node did: the number of its next event, and which rules are entered."""
        self._ending, self._first, self._next = set(), next_sequence, next_sequence
        now = -math.inf, time.time()
        self._states = {
            name: State(is_entered, now, (-math.inf, math.inf))
            for name, is_entered in entered.items()
        }

    def look(self, step: Step, pulses: list[float]) -> None:
        """Judge all that was decided by the poses of a step; ``pulses``: see Step.decisions."""
        twists: dict[str, Twist] = {}
        for posed in step.posed.values():
            twists |= posed.twists or {}
        distances = Distances(self._bodies, step.places, twists)
        rules = {**step.facts.rules, **{n: r for f in step.later for n, r in f.rules.items()}}
        events = self._sorted(step, rules)
        decisions = step.decisions(pulses)
        for name, rule in rules.items():

            def tell(text: str, rule: Rule = rule) -> None:
                self._problem(step, f'{rule}: {text}')

            state = self._states.setdefault(name, State())
            judged = OneRule(step, rule, state, distances, decisions, tell)
            is_certain = judged.judge(events[name])
            self.silences += not events[name]
            self.undecided += not is_certain
        for name in self._ending:
            self._problem(step, f'{name!r} was removed, and no event told of it')
        self._ending = step.removed - {h.event.rule for h in step.events if _is_end(h)}

    def _sorted(self, step: Step, rules: dict[str, Rule]) -> dict[str, list[Heard]]:
        """Return the events of each rule; look at their order, and at those of the ends."""
        events: dict[str, list[Heard]] = {name: [] for name in rules}
        for heard in step.events:
            event = heard.event
            if event.sequence < self._first:
                continue  # what the states knew
            if event.sequence != self._next:
                self._problem(step, f'event {event.sequence} after {self._next - 1}')
            self._next = event.sequence + 1
            self.decisions += 1
            if _is_end(heard):
                if event.rule not in self._ending | step.removed or event.entered:
                    self._problem(step, f'{event.rule!r} ended, and nobody removed it')
                self._ending.discard(event.rule)
            elif event.rule not in rules:
                self._problem(step, f'an event of {event.rule!r}, which is no rule')
            else:
                events[event.rule].append(heard)
        return events

    def _problem(self, step: Step, text: str) -> None:
        self.problems.append(f'step {step.stamp}: {text}')


def _is_end(heard: Heard) -> bool:
    return bool(heard.event.why == 'gone')
