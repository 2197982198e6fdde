"""Hears of a scene_graph node's proximity rules, and never takes silence for safety."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from drake_geom_msgs import msg
from numpy.typing import NDArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64

from drake_geom_ros.common.nearest import nearest

SILENCE = 0.5  # [s] after which a node that says nothing counts as dead
_PERIOD = 0.05  # [s] between two looks at whether it is
_EVENTS = QoSProfile(depth=1000)
_STATES = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_SCALE = QoSProfile(depth=1)
LEVELS = {
    msg.ProximityRule.WARN: 'warn',
    msg.ProximityRule.SLOW: 'slow',
    msg.ProximityRule.STOP: 'stop',
}
WHY = {
    msg.ProximityEvents.NEAR: 'near',
    msg.ProximityEvents.SOON: 'soon',
    msg.ProximityEvents.STALE: 'stale',
    msg.ProximityEvents.NO_POSE: 'no pose',
    msg.ProximityEvents.GONE: 'gone',
    msg.ProximityEvents.TWO_SENDERS: 'two senders',
    msg.ProximityEvents.OTHER_CLOCK: 'other clock',
}


@dataclass(frozen=True)
class ProximityEvent:
    """A rule was entered or left: see ProximityEvents, of which it is one entry.

    ``p_WCa`` and ``p_WCb`` (3,) [m] are the nearest points, in the world; ``pose_a`` and
    ``pose_b`` (7,) are where the geometries were: x y z [m] qx qy qz qw.
    """

    sequence: int
    rule: str
    level: str  # warn, slow or stop
    entered: bool
    why: str  # near, soon, stale, no pose or gone
    geometry_a: str
    geometry_b: str
    id_a: int
    id_b: int
    distance: float  # [m]
    error_bound: float  # [m]
    p_WCa: NDArray[np.float64]
    p_WCb: NDArray[np.float64]
    pose_a: NDArray[np.float64]
    pose_b: NDArray[np.float64]
    closing_speed: float  # [m/s] NaN: not known
    limit_distance: float  # [m] that distance - error_bound was held against
    limit_time: float  # [s] of stale: the age from which on a pose is; else min_time_to_contact
    stamp: float  # [s] of the newest pose used
    oldest_pose_age: float  # [s]
    scene_version: int


@dataclass(frozen=True)
class RuleStanding:
    """How a rule stands."""

    name: str
    level: str  # warn, slow or stop
    entered: bool
    why: str  # for what it is entered; empty where it is not
    since: float  # [s] of the node's clock; 0: it never changed
    pairs: int  # that it watches
    left_out_pairs: int  # of its sets, that are never reported
    trouble: str  # why it can never be entered as the scene is


class ProximityMonitor:
    """The rules of a node as they stand now, and what changes of them.

    ::

        monitor = ProximityMonitor(node, rules=['hands off'])
        ...
        if reason := monitor.why_stop():
            stop_the_robot(reason)
        else:
            go(monitor.speed_scale)
    """

    def __init__(
        self,
        node: Node,
        server: str = '/scene_graph',
        *,
        rules: Collection[str] = (),
        on_event: Callable[[ProximityEvent], None] = lambda _: None,
        on_change: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Listen with ``node``, which the caller spins, to the node named ``server``.

        ``rules`` are those that must be there: without one of them the robot has to stop. Each
        event is handed to ``on_event``; ``on_change`` is called with ``why_stop()`` whenever that
        changes, also where the server falls silent.
        """
        self._server, self._needed = server, tuple(rules)
        self._on_event, self._on_change = on_event, on_change
        self._heard, self._scale = -np.inf, 0.0
        self._standing: dict[str, RuleStanding] | None = None
        self._next = 0  # the number of the next event; 0: none is known
        self._stated = 0  # the same, as the states said last
        self._version = 0  # of the scene, as the events said last
        self._told: str | None = None
        self.missed = 0  # events that were lost on their way
        for kind, topic, hear, profile in (
            (msg.ProximityEvents, 'proximity_events', self._hear_events, _EVENTS),
            (msg.ProximityStates, 'proximity_states', self._hear_states, _STATES),
            (Float64, 'speed_scale', self._hear_scale, _SCALE),
        ):
            node.create_subscription(kind, f'{server}/{topic}', hear, profile)
        # Real time: simulated time may rest while the server is dead.
        node.create_timer(_PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    @property
    def rules(self) -> dict[str, RuleStanding]:
        """The rules by name, as last heard; empty before anything was heard."""
        return dict(self._standing or {})

    @property
    def is_alive(self) -> bool:
        """Whether the server said something of late."""
        return time.monotonic() - self._heard <= SILENCE

    @property
    def speed_scale(self) -> float:
        """How fast to go, 0 to 1; 0 where ``why_stop`` has a reason."""
        return 0.0 if self.why_stop() else self._scale

    def why_stop(self) -> str:
        """Return why the robot has to stop, in words; empty where it need not."""
        if self._standing is None:
            return f'nothing was heard of the proximity rules of {self._server} yet'
        known = self._standing
        for name in self._needed:
            if name not in known:
                return f'there is no proximity rule {name!r}{nearest(name, known)}'
            if trouble := known[name].trouble:
                return trouble
        stops = [rule for rule in known.values() if rule.level == 'stop']
        if all(rule.trouble for rule in stops):  # or there is none
            return next((rule.trouble for rule in stops), 'no proximity rule says when to stop')
        if not self.is_alive:
            return f'{self._server} is silent for more than {SILENCE:g} s'
        return ', '.join(f'{rule.name}: {rule.why}' for rule in stops if rule.entered)

    def _hear_scale(self, message: Any) -> None:
        self._heard, self._scale = time.monotonic(), float(message.data)
        self._look()

    def _hear_states(self, message: Any) -> None:
        self._heard = time.monotonic()
        is_older = self._stated <= message.next_sequence < self._next
        if is_older and message.scene_version <= self._version:  # of a new node it is greater
            return  # events that came already say more, and states follow them
        self._standing = {
            name: RuleStanding(
                name,
                LEVELS[message.rules.level[k]],
                message.entered[k],
                WHY.get(message.why[k], ''),
                message.since[k],
                message.pairs[k],
                message.left_out_pairs[k],
                message.trouble[k],
            )
            for k, name in enumerate(message.rules.name)
        }
        # States may come after later events; only a server that began anew takes numbers back.
        if self._next == 0 or message.next_sequence < self._stated:
            self._next = message.next_sequence
        self._stated = message.next_sequence
        self._look()

    def _hear_events(self, message: Any) -> None:
        self._heard, self._version = time.monotonic(), message.scene_version
        for k, sequence in enumerate(message.sequence):
            if 0 < self._next < sequence:
                self.missed += sequence - self._next
            elif sequence < self._next:  # a server that began anew, and its states are under way
                self._stated = 0
            self._next = sequence + 1
            event = _event(message, k)
            self._follow(event)
            self._on_event(event)
        self._look()

    def _follow(self, event: ProximityEvent) -> None:
        """Know what an event says of its rule before the states say it."""
        if self._standing is None:
            return
        if event.why == 'gone':
            self._standing.pop(event.rule, None)
            return
        new = RuleStanding(event.rule, event.level, False, '', 0.0, 0, 0, '')
        why = event.why if event.entered else ''
        known = self._standing.get(event.rule, new)
        now = replace(known, entered=event.entered, why=why, since=event.stamp)
        self._standing[event.rule] = now

    def _look(self) -> None:
        reason = self.why_stop()
        if reason != self._told:
            self._told = reason
            self._on_change(reason)


def _event(message: Any, k: int) -> ProximityEvent:
    """Return entry ``k`` of a ProximityEvents message."""
    p_wca, p_wcb = (np.asarray(each[3 * k : 3 * k + 3]) for each in (message.p_wca, message.p_wcb))
    poses = (np.asarray(each[7 * k : 7 * k + 7]) for each in (message.pose_a, message.pose_b))
    pose_a, pose_b = poses
    return ProximityEvent(
        sequence=message.sequence[k],
        rule=message.rule[k],
        level=LEVELS[message.level[k]],
        entered=message.entered[k],
        why=WHY[message.why[k]],
        geometry_a=message.geometry_a[k],
        geometry_b=message.geometry_b[k],
        id_a=message.id_a[k],
        id_b=message.id_b[k],
        distance=message.distance[k],
        error_bound=message.error_bound[k],
        p_WCa=p_wca,
        p_WCb=p_wcb,
        pose_a=pose_a,
        pose_b=pose_b,
        closing_speed=message.closing_speed[k],
        limit_distance=message.limit_distance[k],
        limit_time=message.limit_time[k],
        stamp=_seconds(message.header.stamp),
        oldest_pose_age=message.oldest_pose_age[k],
        scene_version=message.scene_version,
    )


def _seconds(stamp: Any) -> float:
    return float(stamp.sec + stamp.nanosec / 1_000_000_000)
