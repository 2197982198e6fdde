"""Compiled decision whether rules are entered or left, for all rules at once.

Decisions use the certified lower bound of a distance: a loose bound may enter a rule early, but
never late. In NumPy these steps took a tenth of a cycle of 1000 bodies, for one rule as for
many, because every call is a cache miss (``bench/costs``).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.compiling import compiled
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.proximity_rules.nearest_pairs import NearestPairs, no_pairs
from drake_geom_ros.proximity_rules.rule import Level, ProximityRule, Why

Ids = NDArray[np.int64]
Whys = NDArray[np.uint8]
_NEAR, _SOON, _NO_POSE = int(Why.NEAR), int(Why.SOON), int(Why.NO_POSE)
_CANNOT_STOP = int(Why.CANNOT_STOP)
# Whether the entering of a rule was acknowledged, and whether its cause has gone since.
_UNACKNOWLEDGED, _ACKNOWLEDGED, _ACKNOWLEDGED_AND_CLEAR = 0, 1, 2
_NONE = np.zeros(0, dtype=np.bool_)


class Poses(NamedTuple):
    """Flags (n,) of geometries without a valid pose, in the order of ``WatchedPairs.ids``.

    A flagged geometry descends from a frame without a valid pose, for one of four reasons. An
    empty array flags none.
    """

    stale: Flags  # posed too long ago
    absent: Flags  # never posed
    contested: Flags = _NONE  # posed by two senders in turn
    foreign: Flags = _NONE  # posed with stamps of another clock

    def without(self) -> tuple[tuple[Why, Flags], ...]:
        """Return the flags by reason; a later reason overrides an earlier one."""
        return (
            (Why.STALE, self.stale),
            (Why.OTHER_CLOCK, self.foreign),
            (Why.TWO_SENDERS, self.contested),
            (Why.NO_POSE, self.absent),
        )


class Reasons(NamedTuple):
    """Values by which each rule (r,) is entered or stays entered."""

    lowest: Floats  # [m] smallest lower bound of its pairs; inf: no pair was near enough
    soonest: Floats  # [s] smallest time to contact; inf: no pair closes
    unposed: Whys  # a Why: it needs a pose that is not valid; 0: all are valid
    unpredicted: Flags  # it uses times to contact, and a motion that it needs is unknown
    # It is of level STOPPABLE, and braking that begins now is not proved to end before contact.
    cannot_stop: Flags
    stop_scale: Floats  # share of the present speed for which that is proved; 1 for other levels

    @classmethod
    def of_nothing(cls, rules: Sequence[ProximityRule]) -> Reasons:
        """Return the values of rules before any measurement: nothing is proved."""
        count = len(rules)
        lowest, soonest = np.full((2, count), math.inf)
        unposed, unpredicted = np.zeros(count, dtype=np.uint8), np.zeros(count, dtype=np.bool_)
        cannot_stop = np.array([rule.level == Level.STOPPABLE for rule in rules], dtype=np.bool_)
        stop_scale = np.where(cannot_stop, 0.0, 1.0)
        return cls(lowest, soonest, unposed, unpredicted, cannot_stop, stop_scale)


class Limits(NamedTuple):
    """Limits of rules as arrays (r,)."""

    group: Ids  # index of the group of rules with the same sets
    enter: Floats  # [m]
    leave: Floats  # [m]
    hold: Floats  # [s]
    enter_after: Floats  # [s]
    least_time: Floats  # [s]
    enters_when_stale: Flags
    acknowledge: Flags
    far: Floats  # [m] pairs beyond count only by their time to contact
    farthest_at_rest: float  # [m] the maximum of ``far``; -inf: there is no rule

    @classmethod
    def of(cls, rules: Sequence[ProximityRule], groups: Ids) -> Limits:
        """Return the limits of rules with the group indices ``groups`` (r,)."""

        def each(field: str) -> Floats:
            return np.array([getattr(rule, field) for rule in rules], dtype=np.float64)

        far, leave, enter = each('farthest'), each('leave'), each('enter')
        by_braking = np.array([rule.level == Level.STOPPABLE for rule in rules], dtype=np.bool_)
        enter[by_braking] = leave[by_braking] = -math.inf  # no distance counts
        return cls(
            np.array(groups, dtype=np.int64),
            enter,
            leave,
            each('hold'),
            each('enter_after'),
            each('min_time_to_contact'),
            each('enters_when_stale').astype(np.bool_),
            each('acknowledge').astype(np.bool_),
            far,
            float(far.max(initial=-math.inf)),
        )

    def farthest(self, fastest: float) -> float:
        """Return the distance [m] up to which pairs count, at closing speeds to ``fastest``."""
        if not fastest:
            return self.farthest_at_rest
        far = np.maximum(self.far, self.least_time * fastest)
        return float(far.max(initial=-math.inf))


class Entered(NamedTuple):
    """States of rules (r,); times [s] are of one monotonic clock."""

    is_entered: Flags
    since: Floats  # time of the last change; -inf: there was none
    why: Whys  # the last Why; 0: never entered
    near_since: Floats  # begin of uninterrupted nearness; inf: it is not near
    is_clear: Flags  # it is entered, and nothing but ``hold`` or its latch keeps it so
    acknowledged: NDArray[np.uint8]  # of an entered rule: a state of acknowledgement
    sequence: Ids  # number of the event by which it was entered last; 0: never
    interlock: Flags  # the next decision enters it, whatever was measured

    @classmethod
    def of_new(cls, count: int) -> Entered:
        """Return the states of new rules, none of which was ever entered."""
        return cls(
            np.zeros(count, dtype=np.bool_),
            np.full(count, -math.inf),
            np.zeros(count, dtype=np.uint8),
            np.full(count, math.inf),
            np.zeros(count, dtype=np.bool_),
            np.zeros(count, dtype=np.uint8),
            np.zeros(count, dtype=np.int64),
            np.zeros(count, dtype=np.bool_),
        )

    def of(self, numbers: Sequence[int]) -> Entered:
        """Return the states of these rules, by index; -1 stands for a new rule."""
        other, old = Entered.of_new(len(numbers)), [n for n in numbers if n >= 0]
        at = [place for place, n in enumerate(numbers) if n >= 0]
        columns: Iterable[tuple[NDArray[Any], NDArray[Any]]] = zip(other, self, strict=True)
        for column, own in columns:
            column[at] = own[old]
        return other

    def awaits(self, limits: Limits) -> Flags:
        """Return which rules (r,) are entered and not acknowledged yet, though they have to be."""
        lacks: Flags = self.acknowledged == _UNACKNOWLEDGED
        return self.is_entered & limits.acknowledge & lacks

    def acknowledge(self, number: int) -> None:
        """Let a rule that is entered, by index, be left once its cause has gone."""
        if self.acknowledged[number] == _UNACKNOWLEDGED:
            self.acknowledged[number] = _ACKNOWLEDGED


@compiled
def take_nearest(nearest: NearestPairs, limits: Limits, reasons: Reasons) -> None:
    """Copy the values of groups of rules into the ``reasons`` of their rules."""
    for r in range(len(limits.group)):
        reasons.lowest[r] = nearest.lowest[limits.group[r]]
        reasons.soonest[r] = nearest.soonest[limits.group[r]]


@compiled
def step(
    now: float, limits: Limits, reasons: Reasons, is_measured: bool, entered: Entered, changed: Ids
) -> int:
    """Enter and leave rules at the time ``now`` [s]; return the number of changes.

    The indices of changed rules, ascending, are written to the front of ``changed`` (r,). The
    ``why`` of an entered rule follows the reasons; a rule that is left keeps its last one. No
    rule is left before the first measurement. An invalid pose enters a rule at once, since
    waiting would trust it.

    A latched rule is left only once it is acknowledged. The acknowledgement is of one entering:
    it ends when the rule is left, and when the rule would be entered again meanwhile.
    """
    count = 0
    for r in range(len(limits.group)):
        # An invalid pose keeps a rule entered whatever ``when_stale`` says; so does an unknown
        # motion if the rule uses times to contact.
        is_unsure = reasons.unposed[r] > 0 or reasons.unpredicted[r]
        why_unposed = reasons.unposed[r] if limits.enters_when_stale[r] else np.uint8(0)
        near = 0  # the Why of nearness, which enters the rule after ``enter_after``
        if reasons.cannot_stop[r]:
            near = _CANNOT_STOP
        elif reasons.lowest[r] < limits.enter[r]:
            near = _NEAR
        elif reasons.soonest[r] < limits.least_time[r]:
            near = _SOON
        entered.near_since[r] = min(entered.near_since[r], now) if near else math.inf
        is_due = near > 0 and now - entered.near_since[r] >= limits.enter_after[r]
        why = near if is_due else int(why_unposed)
        if entered.interlock[r]:
            entered.interlock[r] = False
            why = why or _NO_POSE
        changes = why > 0
        is_far, is_soon = False, False
        if entered.is_entered[r]:
            is_soon = reasons.soonest[r] < limits.least_time[r]
            is_far = reasons.lowest[r] >= limits.leave[r] and not is_soon
            is_far = is_far and not reasons.cannot_stop[r]
            has_held = now - entered.since[r] >= limits.hold[r]
            entered.is_clear[r] = is_measured and is_far and not is_unsure
            if entered.acknowledged[r] == _ACKNOWLEDGED_AND_CLEAR and why > 0:
                entered.acknowledged[r] = _UNACKNOWLEDGED
            elif entered.acknowledged[r] == _ACKNOWLEDGED and entered.is_clear[r]:
                entered.acknowledged[r] = _ACKNOWLEDGED_AND_CLEAR
            is_latched = limits.acknowledge[r] and entered.acknowledged[r] == _UNACKNOWLEDGED
            changes = entered.is_clear[r] and has_held and not is_latched
        if changes:
            entered.is_entered[r] = not entered.is_entered[r]
            entered.since[r] = now
            entered.is_clear[r] = False
            entered.acknowledged[r] = _UNACKNOWLEDGED
            changed[count] = r
            count += 1
        if not entered.is_entered[r]:
            continue
        if why > 0:
            entered.why[r] = why
        elif reasons.cannot_stop[r]:
            entered.why[r] = _CANNOT_STOP
        elif is_measured and not is_unsure and not is_far:  # only the distance keeps it entered
            entered.why[r] = _SOON if is_soon and reasons.lowest[r] >= limits.leave[r] else _NEAR
    return count


def prepare() -> None:
    """Compile the decision functions, so that no cycle waits for the compiler."""
    none = np.zeros(0, dtype=np.int64)
    limits, reasons = Limits.of((), none), Reasons.of_nothing(())
    take_nearest(no_pairs(0), limits, reasons)
    step(0.0, limits, reasons, False, Entered.of_new(0), none)
