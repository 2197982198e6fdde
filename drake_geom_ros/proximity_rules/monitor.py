"""Monitor of a scene's rules: their states, and gapless events of changes."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

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
from drake_geom_ros.proximity_rules.events import Event, LastMeasured, events_of, events_of_gone
from drake_geom_ros.proximity_rules.measured import Measured
from drake_geom_ros.proximity_rules.rule import Level, ProximityRule, RuleError, Why
from drake_geom_ros.proximity_rules.speed_scale import SpeedScale
from drake_geom_ros.proximity_rules.unseen_bodies import with_unseen_bodies
from drake_geom_ros.proximity_rules.watched_pairs import ScenePairs, WatchedPairs
from drake_geom_ros.stopping import Stop

Points: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]


class RuleState(NamedTuple):
    """Current state of a rule."""

    rule: ProximityRule
    is_entered: bool
    why: Why | None  # the reason why it is entered; None: it is not
    since: float  # [s] of the last change, on the clock of ``decide``; -inf: it never changed
    lowest: float  # [m] smallest lower bound of its pairs; inf: no pair was near enough
    pairs: int  # watched pairs
    left_out: int  # pairs of its two sets that are never reported
    trouble: str  # why it can never be entered in the current scene; empty if it can
    lacking: tuple[str, ...]  # names that match nothing any more; the rule goes on without them
    unpredicted: bool  # it uses times to contact, and a motion that it needs is unknown
    awaits_acknowledgement: bool  # it is entered, its cause has gone, and its latch holds it
    entered_sequence: int  # number of the event by which it was entered last; 0: never


class RuleStates(NamedTuple):
    """Current states of all rules (r,) as columns, in the order of their addition.

    See RuleState for the fields. Making one object a rule takes longer than all decisions.
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
    awaits_acknowledgement: NDArray[np.bool_]
    entered_sequence: NDArray[np.int64]

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
                self.awaits_acknowledgement.tolist(),
                self.entered_sequence.tolist(),
            )
        )


class ScaleOfRobot(NamedTuple):
    """Speed scale of one robot, 0 to 1, and why it is less than 1, in words.

    Braking from a velocity that the robot is to have is to be proved for the rules ``stoppable``,
    by name: that from its present one is.
    """

    scale: float
    why: str
    stoppable: tuple[str, ...] = ()


class RuleMonitor:
    """Decides each cycle which rules are entered. Times [s] are of one monotonic clock."""

    def __init__(self, scene: ScenePairs, first_sequence: int = 1) -> None:
        self._scene = scene
        self._sequence = first_sequence
        self._met: frozenset[str] = frozenset()  # rules whose names all matched at least once
        self.changes_of_state = 0  # how often the reason or the latch of any rule changed
        self._set((), Entered.of_new(0))

    # Adding and removing rules.

    def add(
        self,
        rules: Iterable[ProximityRule],
        watched: WatchedPairs | None = None,
        *,
        may_wait: bool = False,
    ) -> list[str]:
        """Add rules, all or none; return the troubles of rules that can never be entered.

        ``watched`` is what ``watching`` returned for the present rules and these. Raises RuleError
        for a name that is taken, and, unless rules ``may_wait`` for what they name, for a rule
        that can never be entered in the current scene.
        """
        added = tuple(rules)
        taken = {rule.name for rule in self.rules}
        for rule in added:
            if rule.name in taken:
                raise RuleError(
                    f'there is a proximity rule {rule.name[:80]!r} already; remove it first'
                )
            taken.add(rule.name)
        watched = watched or self.watching((*self.rules, *added), self._scene)
        troubles = list(filter(None, watched.trouble[len(self.rules) :]))
        if troubles and not may_wait:
            raise RuleError(troubles[0])
        self.exchange((), added, watched)
        return troubles

    def exchange(
        self,
        removed: Collection[str],
        added: Sequence[ProximityRule],
        watched: WatchedPairs | None = None,
    ) -> tuple[list[Event], list[str]]:
        """Replace the rules ``removed`` by others; return GONE events, and troubles.

        ``watched`` is what ``watching`` returned for the rules that stay, then those ``added``. A
        latched rule that nobody acknowledged goes on, without an event, as the one of its name
        among those added, if that has a latch too. A rule without one leaves nothing to wait for,
        which is one of the troubles.
        """
        ended = {rule.name: n for n, rule in enumerate(self.rules) if rule.name in removed}
        left = [n for n, rule in enumerate(self.rules) if rule.name not in ended]
        awaits = self._entered.awaits(self._limits)
        latched = {name: n for name, n in ended.items() if awaits[n]}
        passed_on = [latched.get(rule.name, -1) if rule.acknowledge else -1 for rule in added]
        gone = [self.rules[n] for n in ended.values() if n not in passed_on]
        events = events_of_gone(self._sequence, gone)
        self._sequence += len(events)
        released = [rule.name for rule in gone if rule.name in latched]
        every = (*(self.rules[n] for n in left), *added)
        self._set(every, self._entered.of([*left, *passed_on]), watched)
        return events, [
            f'proximity rule {name!r} was entered and not acknowledged; the one in its place has '
            'no key acknowledge, and does not wait for it'
            for name in released
        ]

    def remove(self, *names: str, watched: WatchedPairs | None = None) -> list[Event]:
        """Remove rules, all or none; return their GONE events.

        ``watched`` is what ``watching`` returned for the rules that stay. Raises RuleError if
        there is no rule of a name.
        """
        return self._end([self._number(name) for name in names], watched)

    def _number(self, name: str) -> int:
        """Return the index of a rule; raises RuleError if there is none of that name."""
        for number, rule in enumerate(self.rules):
            if rule.name == name:
                return number
        names = [rule.name for rule in self.rules]
        raise RuleError(
            f'there is no proximity rule {name[:80]!r}{nearest(name, names)}; '
            'see list_proximity_rules'
        )

    # Latches.

    def acknowledge(self, name: str, sequence: int) -> list[Event]:
        """Acknowledge that a rule was entered, by the number of that event.

        The rule is left by the next decision that finds its cause gone and its ``hold`` over: a
        cause that persists is not overruled. The acknowledgement is of this entering only. It ends
        when the rule is left, and when a new cause comes after the old one has gone. A rule of
        whose geometries nothing is left ends now, and its GONE event is returned.

        Raises RuleError for an unknown rule, one without a latch, one that is not entered, and
        another event than that by which it was entered last.
        """
        number = self._number(name)
        rule, entered = self.rules[number], self._entered
        if not rule.acknowledge:
            raise RuleError(
                f'proximity rule {name[:80]!r} has no key acknowledge: it is left by itself'
            )
        if not entered.is_entered[number]:
            raise RuleError(
                f'proximity rule {name[:80]!r} is not entered: there is nothing to acknowledge, '
                'and nothing is remembered for later; see ~/proximity_states'
            )
        if sequence != (last := int(entered.sequence[number])):
            raise RuleError(
                f'sequence is {sequence}; proximity rule {name[:80]!r} was entered last by event '
                f'{last}: look at that one (entered_sequence of ~/proximity_states), then '
                'acknowledge it'
            )
        entered.acknowledge(number)
        self.changes_of_state += 1
        return self._end([number]) if self._has_ended(number) else []

    def unacknowledged(self) -> dict[str, int]:
        """Return by latched rule the event that entered it, and that has to be acknowledged."""
        numbers = np.flatnonzero(self._entered.awaits(self._limits)).tolist()
        return {self.rules[n].name: int(self._entered.sequence[n]) for n in numbers}

    def begin_entered(self) -> None:
        """Have the next decision enter each latched rule, whatever it measures.

        For a process that starts, and does not know whether one was entered before: as a safety
        relay with a manual reset it waits to be acknowledged.
        """
        self._entered.interlock[:] = self._limits.acknowledge & ~self._entered.is_entered

    def _has_ended(self, number: int) -> bool:
        """Return whether a rule was about geometries of which nothing is left."""
        return self.rules[number].name in self._met and bool(self._watched.unknown[number])

    def watching(self, rules: Sequence[ProximityRule], scene: ScenePairs) -> WatchedPairs:
        """Return the pairs that such rules watch in another version of the scene."""
        present = set(self.rules)
        met = [rule.name for rule in rules if rule.name in self._met and rule in present]
        return WatchedPairs(rules, scene, met)

    def bind(self, scene: ScenePairs, watched: WatchedPairs | None = None) -> list[Event]:
        """Bind the rules to another version of the scene; return GONE events of rules it ends.

        A rule ends if one of its sets is empty now, unless it is latched and nobody acknowledged
        it: that one stays entered. If only some of its names match nothing now, it goes on with
        the others. Filters end no rule, since they come and go. ``watched`` is what ``watching``
        returned for the scene and the present rules.
        """
        unknown_before, self._scene = self._watched.unknown, scene
        self._set(self.rules, self._entered, watched)
        awaits = self._entered.awaits(self._limits)
        pairs = enumerate(zip(unknown_before, self._watched.unknown, strict=True))
        return self._end([n for n, (old, new) in pairs if new and not old and not awaits[n]])

    def _end(self, numbers: Sequence[int], watched: WatchedPairs | None = None) -> list[Event]:
        """Remove rules by index; return their GONE events."""
        gone = events_of_gone(self._sequence, [self.rules[n] for n in numbers])
        self._sequence += len(gone)
        if numbers:
            ended = set(numbers)
            left = [n for n in range(len(self.rules)) if n not in ended]
            self._set(tuple(self.rules[n] for n in left), self._entered.of(left), watched)
        return gone

    def _set(
        self,
        rules: tuple[ProximityRule, ...],
        states: Entered,
        watched: WatchedPairs | None = None,
    ) -> None:
        """Set the rules and their states, and discard measurements until ``decide``."""
        self.rules, self._entered = rules, states
        self._watched = watched or WatchedPairs(rules, self._scene, self._met)
        self._limits = Limits.of(rules, self._watched.groups)
        lacking = zip([rule.name for rule in rules], self._watched.unknown, strict=True)
        self._met = frozenset(name for name, lacks in lacking if not lacks or name in self._met)
        self._speed = SpeedScale(rules, self._watched)
        if rules:
            prepare()
        self._reasons = Reasons.of_nothing(rules)
        self.stops: Mapping[str, Stop] = {}  # the last answers, by the name of their rule
        self._changed = np.empty(len(rules), dtype=np.int64)
        self._seen: LastMeasured | None = None
        self.is_measured = False  # whether distances of these pairs were measured

    # Cycles.

    @property
    def watched(self) -> WatchedPairs:
        """The pairs that the rules watch."""
        return self._watched

    @property
    def measurement(self) -> LastMeasured | None:
        """The last measurement of the present pairs; None before the first one."""
        return self._seen

    def nearest_points(self) -> list[Points | None]:
        """Return p_WCa and p_WCb (3,) [m] of the nearest pair of each rule.

        A on each pair is the geometry with the lower id. None for a rule without a pair that was
        near enough to be measured, and for one of whose bodies nothing is known.
        """
        if self._seen is None:
            return [None] * len(self.rules)
        measured, nearest = self._seen
        rows = nearest.lowest_pair[self._watched.groups].tolist()
        pairs = [None if row < 0 else (measured.p_WCa[row], measured.p_WCb[row]) for row in rows]
        return [pair if pair and np.isfinite(pair).all() else None for pair in pairs]

    @property
    def next_sequence(self) -> int:
        """Sequence number of the next event."""
        return self._sequence

    def farthest(self, fastest: float = 0.0) -> float:
        """Return the distance [m] that a cycle has to cover, at closing speeds to ``fastest``."""
        return self._limits.farthest(fastest)

    def decide(
        self,
        now: float,
        poses: Poses,
        measured: Measured | None = None,
        farthest: float = math.inf,
        stops: Mapping[str, Stop] | None = None,
    ) -> list[Event]:
        """Enter and leave rules by a measurement; return the events in the order of the rules.

        ``measured`` None: nothing moved since the last measurement, and only time went on. Pairs
        that are certainly beyond ``farthest`` [m] are ignored. Before the first measurement,
        rules are entered only for invalid poses, and no rule is left.

        ``stops`` are the answers of now for rules of level STOPPABLE, by name; without one, the
        last answer stands, and before the first one such a rule is entered.
        """
        watched, limits = self._watched, self._limits
        reasons, entered = self._reasons, self._entered
        if measured is not None:
            nearest = watched.nearest_of_groups(measured, farthest)
            measured, nearest = with_unseen_bodies(watched, measured, nearest)
            take_nearest(nearest, limits, reasons)
            reasons.unpredicted[:] = self._unpredicted(measured)
            self._seen, self.is_measured = LastMeasured(measured, nearest), True
        self._take_stops(stops or {})
        reasons.unposed[:] = 0
        for why, flags in poses.without():
            reasons.unposed[watched.needs(flags)] = why
        reasons.unposed[watched.is_unknown] = Why.NO_POSE
        before = entered.why.copy(), entered.is_clear.copy()
        count = step(now, limits, reasons, self.is_measured, entered, self._changed)
        is_same = np.array_equal(before[0], entered.why)
        is_same &= np.array_equal(before[1], entered.is_clear)
        self.changes_of_state += int(not is_same)
        if not count:
            return []
        first, changed = self._sequence, self._changed[:count]
        enters = entered.is_entered[changed]
        entered.sequence[changed[enters]] = first + np.flatnonzero(enters)
        self._sequence += count
        seen = self._seen
        return events_of(first, self.rules, changed, entered, watched, poses, seen, self.stops)

    def _take_stops(self, stops: Mapping[str, Stop]) -> None:
        for number, rule in enumerate(self.rules):
            if (stop := stops.get(rule.name)) is not None and rule.level == Level.STOPPABLE:
                self._reasons.cannot_stop[number] = not stop.clear
                self._reasons.stop_scale[number] = stop.scale
        self.stops = {**self.stops, **stops}

    def _unpredicted(self, measured: Measured) -> NDArray[np.bool_]:
        """Return a mask (r,) of the rules with times to contact that need an unknown motion."""
        timed = self._limits.least_time > 0.0
        if measured.unpredicted is None or not timed.any():
            return np.zeros(len(self.rules), dtype=np.bool_)
        return timed & self._watched.needs(measured.unpredicted)

    def speed_scale(self) -> float | None:
        """Return the speed scale, 0 to 1; None if no rule sets one; 0 before a measurement."""
        if not self._speed.is_asked_for:
            return None
        if not self.is_measured:
            return 0.0
        entered, limits = self._entered, self._limits
        return self._speed.value(entered.is_entered, entered.awaits(limits), self._reasons, limits)

    def scale_about(self, pattern: str) -> ScaleOfRobot:
        """Return the speed scale of what a name or pattern stands for, as rules' sets have it.

        It is 0 before a measurement, where nothing is called so, and where no rule about it says
        how fast to go. A rule whose names match nothing yet is about everything. One of level
        STOPPABLE scales to 0 while it is entered, and does not scale else.
        """
        watched, entered, limits = self._watched, self._entered, self._limits
        members = self._scene.geometries.named(pattern)
        if not members.any():
            return ScaleOfRobot(0.0, f'{pattern[:80]!r} stands for no geometry of the scene')
        about = (watched.needs(members) | watched.is_unknown) & self._speed.has_scale
        if not about.any():
            return ScaleOfRobot(0.0, f'no proximity rule says how fast {pattern[:80]!r} may go')
        if not self.is_measured:
            return ScaleOfRobot(0.0, 'its rules were not decided yet')
        latched = entered.awaits(limits)
        scales = self._speed.each(entered.is_entered, latched, self._reasons, limits)
        # The share of a stoppable rule is of the present speed, and says nothing of another one.
        brakes = np.array([rule.level == Level.STOPPABLE for rule in self.rules])
        stands = entered.is_entered | self._reasons.cannot_stop | (scales == 0.0)
        scales[brakes] = np.where(stands, 0.0, 1.0)[brakes]
        scales[~about] = 1.0
        lowest = int(scales.argmin())
        why = '' if scales[lowest] == 1.0 else f'proximity rule {self.rules[lowest].name!r}'
        stoppable = tuple(self.rules[n].name for n in np.flatnonzero(about & brakes).tolist())
        return ScaleOfRobot(float(scales[lowest]), why, stoppable)

    def states(self) -> list[RuleState]:
        """Return the state of each rule, in the order of their addition."""
        return self.table().each()

    def table(self) -> RuleStates:
        """Return the states of all rules as arrays, which the next call may overwrite."""
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
            awaits_acknowledgement=entered.awaits(self._limits) & entered.is_clear,
            entered_sequence=entered.sequence,
        )
