"""Whether rules are entered and left, for all rules at once, compiled.

What decides is the lower bound of a distance, which is certified: a rule may be entered early
where an answer is loose, and never late. In NumPy these steps took a tenth of a cycle of 1000
bodies, of one rule as of many, for each call comes from memory again (``bench/costs``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.compiling import compiled
from drake_geom_ros.proximity_rules.nearest_pairs import NearestPairs, no_pairs
from drake_geom_ros.proximity_rules.rule import ProximityRule, Why

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ids = NDArray[np.int64]
Whys = NDArray[np.uint8]
_NEAR, _SOON = int(Why.NEAR), int(Why.SOON)
_NONE = np.zeros(0, dtype=np.bool_)


class Poses(NamedTuple):
    """The geometries (n,) whose poses are not known, in the order of ``WatchedPairs.ids``.

    Each hangs on a frame that lacks a good pose, for one of four reasons. An empty array flags
    none.
    """

    stale: Flags  # posed too long ago
    absent: Flags  # never posed
    contested: Flags = _NONE  # posed by two senders in turn
    foreign: Flags = _NONE  # posed with stamps of another clock

    def without(self) -> tuple[tuple[Why, Flags], ...]:
        """Return the geometries without a good pose by reason; a later reason counts more."""
        return (
            (Why.STALE, self.stale),
            (Why.OTHER_CLOCK, self.foreign),
            (Why.TWO_SENDERS, self.contested),
            (Why.NO_POSE, self.absent),
        )


class Reasons(NamedTuple):
    """What each rule (r,) would be entered for, and what keeps it entered."""

    lowest: Floats  # [m] the least lower bound of its pairs; inf: none was near enough to see
    soonest: Floats  # [s] the least time to contact; inf: nothing that closes
    blind: Whys  # a Why: it needs a pose that is not known; 0: all are
    unpredicted: Flags  # times count for it, and nobody knows how all that it needs moves

    @classmethod
    def of_nothing(cls, count: int) -> Reasons:
        """Return those of rules of which nothing was measured."""
        lowest, soonest = np.full((2, count), math.inf)
        blind, unpredicted = np.zeros(count, dtype=np.uint8), np.zeros(count, dtype=np.bool_)
        return cls(lowest, soonest, blind, unpredicted)


class Limits(NamedTuple):
    """The numbers of rules as arrays (r,)."""

    group: Ids  # of the rules that name the same sets
    enter: Floats  # [m]
    leave: Floats  # [m]
    hold: Floats  # [s]
    enter_after: Floats  # [s]
    least_time: Floats  # [s]
    enters_when_stale: Flags
    far: Floats  # [m] from which distance on a pair counts no more, but for its speed
    farthest_at_rest: float  # [m] the greatest of these; -inf: there is no rule

    @classmethod
    def of(cls, rules: Sequence[ProximityRule], groups: Ids) -> Limits:
        """Return those of rules, each of which is of one of the ``groups`` (r,)."""

        def each(field: str) -> Floats:
            return np.array([getattr(rule, field) for rule in rules], dtype=np.float64)

        far = each('farthest')
        return cls(
            np.array(groups, dtype=np.int64),
            each('enter'),
            each('leave'),
            each('hold'),
            each('enter_after'),
            each('min_time_to_contact'),
            each('enters_when_stale').astype(np.bool_),
            far,
            float(far.max(initial=-math.inf)),
        )

    def farthest(self, fastest: float) -> float:
        """Return how far [m] a pair counts, where pairs close at most this fast [m/s]."""
        if not fastest:
            return self.farthest_at_rest
        far = np.maximum(self.far, self.least_time * fastest)
        return float(far.max(initial=-math.inf))


class Entered(NamedTuple):
    """The states of rules (r,); times [s] are of one clock that never runs back."""

    is_entered: Flags
    since: Floats  # of the last change; -inf: there was none
    why: Whys  # a Why, of the last time; 0: never entered
    near_since: Floats  # without a break; inf: it is not near

    @classmethod
    def of_new(cls, count: int) -> Entered:
        """Return the states of rules that were never entered."""
        return cls(
            np.zeros(count, dtype=np.bool_),
            np.full(count, -math.inf),
            np.zeros(count, dtype=np.uint8),
            np.full(count, math.inf),
        )

    def of(self, numbers: Sequence[int]) -> Entered:
        """Return the states of these rules; -1: of one that is new."""
        other, kept = Entered.of_new(len(numbers)), [n for n in numbers if n >= 0]
        at = [place for place, n in enumerate(numbers) if n >= 0]
        other.is_entered[at] = self.is_entered[kept]
        other.since[at] = self.since[kept]
        other.why[at] = self.why[kept]
        other.near_since[at] = self.near_since[kept]
        return other


@compiled
def take_nearest(nearest: NearestPairs, limits: Limits, reasons: Reasons) -> None:
    """Take over what was measured of the groups of rules."""
    for r in range(len(limits.group)):
        reasons.lowest[r] = nearest.lowest[limits.group[r]]
        reasons.soonest[r] = nearest.soonest[limits.group[r]]


@compiled
def step(
    now: float, limits: Limits, reasons: Reasons, is_measured: bool, entered: Entered, changed: Ids
) -> int:
    """Enter and leave rules by what holds ``now`` [s]; return how many changed.

    Their numbers are the first of ``changed`` (r,), ascending. What a rule is entered for follows
    the reasons; of one that is left it stays. Before anything was measured none is left.
    A pose that is not known enters a rule at once: to wait were to trust it.
    """
    count = 0
    for r in range(len(limits.group)):
        # What holds a rule entered whatever ``when_stale`` says: a pose that is not known, and a
        # motion that is not known where times to contact count.
        is_unsure = reasons.blind[r] > 0 or reasons.unpredicted[r]
        blind = reasons.blind[r] if limits.enters_when_stale[r] else np.uint8(0)
        near = 0  # why it would be entered after ``enter_after``
        if reasons.lowest[r] < limits.enter[r]:
            near = _NEAR
        elif reasons.soonest[r] < limits.least_time[r]:
            near = _SOON
        entered.near_since[r] = min(entered.near_since[r], now) if near else math.inf
        is_due = near > 0 and now - entered.near_since[r] >= limits.enter_after[r]
        why = near if is_due else int(blind)
        changes = why > 0
        is_far, is_soon = False, False
        if entered.is_entered[r]:
            is_soon = reasons.soonest[r] < limits.least_time[r]
            is_far = reasons.lowest[r] >= limits.leave[r] and not is_soon
            has_held = now - entered.since[r] >= limits.hold[r]
            changes = is_measured and is_far and has_held and not is_unsure
        if changes:
            entered.is_entered[r] = not entered.is_entered[r]
            entered.since[r] = now
            changed[count] = r
            count += 1
        if not entered.is_entered[r]:
            continue
        if why > 0:
            entered.why[r] = why
        elif is_measured and not is_unsure and not is_far:  # what holds it is the distance alone
            entered.why[r] = _SOON if is_soon and reasons.lowest[r] >= limits.leave[r] else _NEAR
    return count


def prepare() -> None:
    """Compile what decides, so that no cycle waits for it."""
    none = np.zeros(0, dtype=np.int64)
    limits, reasons = Limits.of((), none), Reasons.of_nothing(0)
    take_nearest(no_pairs(0), limits, reasons)
    step(0.0, limits, reasons, False, Entered.of_new(0), none)
