"""Publishes decisions of proximity rules: events, states, the speed scale.

Rules are decided whether anybody listens or not: who comes later must find their states right, and
numbers of events without a gap.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import SignedDistanceResults
from drake_geom_ros.live.conversions.proximity_rules import (
    fill_events,
    fill_rules,
    fill_what_decided,
)
from drake_geom_ros.live.conversions.stopping import fill_speed_limits, fill_stopping
from drake_geom_ros.live.outputs.effects import Beside
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.rule_states import fill_rule_states
from drake_geom_ros.live.scene.scene_rules import Twists
from drake_geom_ros.live.scene.stops_beside_sensors import Sensed
from drake_geom_ros.proximity_rules import Event, ProximityRule
from drake_geom_ros.stopping import Stop

_NO_RULE = 'no proximity rule'
_NO_STOPPABLE = 'no rule of level stoppable'
# [s] at most between two decisions, and two values of the scale: poses may stop to come.
PERIOD = 0.05
# [s] at least between two messages of states: they bear all rules, and who comes late hears the
# events that follow.
_STATES_PERIOD = 0.1


class RuleTopics(NamedTuple):
    """The publishers of the topics of proximity rules."""

    events: Any
    states: Any
    speed_scale: Any
    speed_limit: Any
    stopping: Any

    @classmethod
    def of(cls, publishers: Mapping[str, Any]) -> RuleTopics:
        """Return those among the publishers of a node, by topic."""
        return cls(
            events=publishers['~/proximity_events'],
            states=publishers['~/proximity_states'],
            speed_scale=publishers['~/speed_scale'],
            speed_limit=publishers['~/speed_limit'],
            stopping=publishers['~/stopping'],
        )


class RuleMessages(NamedTuple):
    """The classes of the messages of proximity rules."""

    ProximityEvents: Any
    ProximityRules: Any
    ProximityStates: Any
    SpeedLimits: Any
    Stopping: Any
    Float64: Any


class RuleSettings(NamedTuple):
    """The parameters of proximity rules."""

    stale_after: float  # [s] age from which on a pose is stale
    time_budget: float = 0.0  # [s] of a narrow phase; 0: it has none


class _Listed(NamedTuple):
    """Rules, and a message that was filled with them, which takes as long as all their states."""

    rules: Sequence[ProximityRule] | None
    message: Any


def effect() -> Beside:
    """Return the row of ~/cycle_report with the pairs that were computed for rules alone."""
    return Beside('decide proximity rules', lambda: _NO_RULE)


class StopEffects(NamedTuple):
    """Rows of ~/cycle_report about the proofs of stoppable rules, added up over all rules."""

    looked: Beside  # pairs
    far_pairs: Beside
    far_bodies: Beside
    idle_joints: Beside

    @classmethod
    def fresh(cls) -> StopEffects:
        """Return rows in which nothing is counted yet."""
        names = (
            'prove stops: pairs',
            'leave out of stops: pairs that are too far',
            'leave out of stops: bodies that are too far',
            'leave out of stops: joints that move no near body',
        )
        return cls(*(Beside(name, lambda: _NO_STOPPABLE) for name in names))

    def did(self, stops: Iterable[Stop], seconds: float) -> None:
        """Count the answers of one decision, which took so long [s]."""
        counts = np.sum(
            [(s.pairs, s.far_pairs, s.far_bodies, s.idle_joints) for s in stops], axis=0
        )
        for row, count, spent in zip(self, counts.tolist(), (seconds, 0, 0, 0), strict=True):
            row.did(count, spent)


class RuleEvents:
    """Decides about the rules of the live scene and publishes their states and events."""

    def __init__(
        self,
        topics: RuleTopics,
        types: RuleMessages,
        settings: Callable[[], RuleSettings],
        did: Callable[[int, float], None],
        stop_effects: StopEffects | None = None,
    ) -> None:
        """``types`` holds the message classes, ``settings()`` is called at each decision.

        ``did(pairs, seconds)`` is called for each decision, with the pairs that it alone needed.
        """
        self._stop_effects = stop_effects
        self._topics, self._types = topics, types
        self._settings, self._did = settings, did
        self._decided = -math.inf  # [s] of steady time
        self._period = PERIOD  # [s] until the next decision, by the last two
        self._told = -1  # the revision of the states that were published last
        self._stated = -math.inf  # [s] of steady time, when that was
        self._listed = _Listed(None, None)
        # Called at each decision, in the cycle: gates stop robots at once.
        self.tell_gates: Callable[[HeldScene], object] = lambda scene: None

    def look_at(
        self, scene: HeldScene, distances: SignedDistanceResults | None, reach: float
    ) -> None:
        """Decide by the poses of now; ``distances`` are those within ``reach`` [m], if any."""
        if not scene.rules.rules:  # what there is to tell of that, ``look_again`` tells
            return
        start = time.perf_counter()
        rules, settings = scene.rules, self._settings()
        scene.bind_rules()
        seen = None if distances is None else (distances, reach)
        unreliable = scene.blind_frames(settings.stale_after)
        twists = scene.poses.twists()
        stops = self._stops(scene, twists)
        computed = rules.decide(
            self._decided,
            scene.query,
            unreliable,
            seen,
            twists,
            settings.time_budget,
            scene.maps.shells(),
            scene.maps.sights(),
            stops,
        )
        self._tell(scene, rules.take_events())
        self._did(computed, time.perf_counter() - start)

    def look_again(self, scene: HeldScene) -> None:
        """Decide although no cycle ran: poses grow old, times run out, the scene was changed."""
        rules, now = scene.rules, scene.clocks.steady()
        if now - self._decided < PERIOD / 2.0:
            return
        if rules.rules:
            scene.bind_rules()
        if rules.rules and not rules.is_measured:
            self.look_at(scene, None, 0.0)
            return
        if rules.rules:
            stops = self._stops(scene, scene.poses.twists())  # what is older may be nearer
            rules.wait(now, scene.blind_frames(self._settings().stale_after), stops)
        self._decided = now
        self._tell(scene, rules.take_events())

    def _stops(self, scene: HeldScene, twists: Twists | None) -> dict[str, Stop] | None:
        """Return whether robots can stop now; the time of a cycle counts as their reaction."""
        now, before = scene.clocks.steady(), self._decided
        if before > -math.inf:
            last, self._period = self._period, max(now - before, 0.0)
            delay = max(last, self._period)
        else:
            delay = self._period
        self._decided = now
        sensed = Sensed(scene.maps.shells(), scene.maps.sights())
        start = time.perf_counter()
        stops = scene.stopping.stops(twists, self._settings().stale_after, delay, sensed)
        if stops and self._stop_effects is not None:
            self._stop_effects.did(stops.values(), time.perf_counter() - start)
        return stops

    def forget(self) -> None:
        """Publish the states anew, for subscribers that received nothing meanwhile."""
        self._told, self._stated = -1, -math.inf

    def _tell(self, scene: HeldScene, events: list[Event]) -> None:
        """Publish events, states where they changed (soon), and the scale of speed."""
        self.tell_gates(scene)
        if events:
            message = self._types.ProximityEvents(accuracy=scene.accuracy)
            moment = scene.moment()
            moment.stamp_header(message)
            message.names_version = moment.names_version
            fill_events(message, events, scene.model.names.name_of_value)
            fill_what_decided(
                message, events, scene.rules.with_zones(scene.query), self._settings().stale_after
            )
            message.oldest_pose_age = [moment.oldest.age] * len(events)
            message.oldest_frame = [moment.oldest.frame] * len(events)
            self._topics.events.publish(message)
        # All rules each time: many a second would cost more than what they decide.
        now = scene.clocks.steady()
        if scene.rules.revision != self._told and now - self._stated >= _STATES_PERIOD:
            self._told, self._stated = scene.rules.revision, now
            if scene.rules.rules is not self._listed.rules:
                self._listed = _Listed(scene.rules.rules, self._types.ProximityRules())
                fill_rules(self._listed.message, scene.rules.rules)
            states = self._types.ProximityStates()
            fill_rule_states(states, scene, self._listed.message)
            self._topics.states.publish(states)
        scale = scene.rules.speed_scale()
        if scale is not None and self._topics.speed_scale.get_subscription_count():
            self._topics.speed_scale.publish(self._types.Float64(data=scale))
        if scene.rules.stops:
            self._tell_stops(scene)

    def _tell_stops(self, scene: HeldScene) -> None:
        """Publish whether robots can stop, and how fast they may go."""
        stops, moment = scene.rules.stops, scene.moment()
        if self._topics.speed_limit.get_subscription_count():
            limits = self._types.SpeedLimits()
            moment.stamp_poses(limits)
            fill_speed_limits(limits, stops)
            self._topics.speed_limit.publish(limits)
        if self._topics.stopping.get_subscription_count():
            message = self._types.Stopping()
            moment.stamp_header(message)
            message.scene_version = moment.version
            fill_stopping(message, stops, scene.model.names.name_of_value)
            self._topics.stopping.publish(message)
