"""Monitor of a scene_graph node's proximity rules; silence of the node means stop."""

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
from rclpy.task import Future
from std_msgs.msg import Float64

from drake_geom_ros.client.services import Services
from drake_geom_ros.common.nearest import nearest

SILENCE = 0.5  # [s] a node without messages for longer counts as dead
_PERIOD = 0.05  # [s] between two checks of that
_EVENTS = QoSProfile(depth=1000)
_STATES = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_SCALE = QoSProfile(depth=1)
LEVELS = {
    msg.ProximityRule.WARN: 'warn',
    msg.ProximityRule.SLOW: 'slow',
    msg.ProximityRule.STOP: 'stop',
    msg.ProximityRule.STOPPABLE: 'stoppable',
}
WHY = {
    msg.ProximityEvents.NEAR: 'near',
    msg.ProximityEvents.SOON: 'soon',
    msg.ProximityEvents.STALE: 'stale',
    msg.ProximityEvents.NO_POSE: 'no pose',
    msg.ProximityEvents.GONE: 'gone',
    msg.ProximityEvents.CANNOT_STOP: 'cannot stop',
    msg.ProximityEvents.TWO_SENDERS: 'two senders',
    msg.ProximityEvents.OTHER_CLOCK: 'other clock',
}


@dataclass(frozen=True)
class ProximityEvent:
    """One entry of a ProximityEvents message: a rule was entered or left.

    ``p_WCa`` and ``p_WCb`` (3,) [m] are the nearest points, in the world; ``pose_a`` and
    ``pose_b`` (7,) are the poses of the geometries, x y z [m] qx qy qz qw.
    """

    sequence: int
    rule: str
    level: str  # warn, slow, stop or stoppable
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
    closing_speed: float  # [m/s] NaN: unknown
    limit_distance: float  # [m] compared with distance - error_bound
    limit_time: float  # [s] for `stale` the parameter stale_after, else min_time_to_contact
    stamp: float  # [s] of the newest pose used
    oldest_pose_age: float  # [s]
    scene_version: int


@dataclass(frozen=True)
class RuleStanding:
    """Current state of a rule."""

    name: str
    level: str  # warn, slow, stop or stoppable
    entered: bool
    why: str  # reason why it is entered; empty if it is not
    since: float  # [s] of the last change, on the node's clock; 0: it never changed
    pairs: int  # watched pairs
    left_out_pairs: int  # pairs of its sets that are never reported
    trouble: str  # why it can never be entered in the current scene
    awaits_acknowledgement: bool = False  # its cause has gone, and its latch keeps it entered
    entered_sequence: int = 0  # number of the event by which it was entered last; 0: never

    def in_words(self) -> str:
        """Return the name and why it is entered, as a text."""
        latched = ', to be acknowledged' if self.awaits_acknowledgement else ''
        return f'{self.name}: {self.why}{latched}'


class ProximityMonitor:
    """Subscriber to a node's proximity rules: their current states and their events.

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

        ``rules`` are required: if one of them is missing, the robot has to stop. ``on_event`` is
        called with each event, and ``on_change`` with ``why_stop()`` whenever that changes, also
        when the server falls silent.
        """
        self._server, self._needed = server, tuple(rules)
        self._services = Services(node, server)
        self._on_event, self._on_change = on_event, on_change
        self._heard, self._scale = -np.inf, 0.0
        self._standing: dict[str, RuleStanding] | None = None
        self._next = 0  # number of the next event; 0: unknown
        self._stated = 0  # the same, by the last states message
        self._version = 0  # scene version of the last events message
        self._last_reason: str | None = None  # the last argument of on_change
        self.missed = 0  # events that were lost in transport
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
        """The rules by name, as last received; empty before the first message."""
        return dict(self._standing or {})

    @property
    def is_alive(self) -> bool:
        """True if the server sent a message within the last ``SILENCE``."""
        return time.monotonic() - self._heard <= SILENCE

    @property
    def speed_scale(self) -> float:
        """Speed scale, 0 to 1; 0 if ``why_stop`` has a reason.

        With a rule of the level ``stoppable`` it is a share of the present speed, and not of the
        nominal one: ``~/speed_limit`` has the speeds that are proved.
        """
        return 0.0 if self.why_stop() else self._scale

    def why_stop(self) -> str:
        """Return why the robot has to stop, as a text; empty if it need not."""
        if self._standing is None:
            return f'nothing was heard of the proximity rules of {self._server} yet'
        standings = self._standing
        for name in self._needed:
            if name not in standings:
                return f'there is no proximity rule {name!r}{nearest(name, standings)}'
            if trouble := standings[name].trouble:
                return trouble
        # A stoppable rule that is entered asks for less speed (``speed_scale``), a latched one for
        # rest until it is acknowledged.
        stops = [rule for rule in standings.values() if rule.level in ('stop', 'stoppable')]
        if all(rule.trouble for rule in stops):  # or there is none
            return next((rule.trouble for rule in stops), 'no proximity rule says when to stop')
        if not self.is_alive:
            return f'{self._server} is silent for more than {SILENCE:g} s'
        entered = [
            rule
            for rule in stops
            if rule.entered and (rule.level == 'stop' or rule.awaits_acknowledgement)
        ]
        return ', '.join(rule.in_words() for rule in entered)

    def acknowledge(self, rule: str) -> Future:
        """Acknowledge that a latched rule was entered; return the future of the response.

        Call it for somebody who has seen why the robot stopped. It names the entering that was
        received here last, so the node refuses it if the rule was entered again since.

        ::

            response = await monitor.acknowledge('hands off')
            if not response.success:
                print(response.message)
        """
        standing = (self._standing or {}).get(rule)
        sequence = 0 if standing is None else standing.entered_sequence
        return self._services.send('acknowledge_rule', name=rule, sequence=sequence)

    def _hear_scale(self, message: Any) -> None:
        self._heard, self._scale = time.monotonic(), float(message.data)
        self._look()

    def _hear_states(self, message: Any) -> None:
        self._heard = time.monotonic()
        is_older = self._stated <= message.next_sequence < self._next
        if is_older and message.scene_version <= self._version:  # a restarted node has a greater
            return  # the events received so far are newer, and states follow them
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
                message.awaits_acknowledgement[k],
                message.entered_sequence[k],
            )
            for k, name in enumerate(message.rules.name)
        }
        # States may arrive after later events; only a restarted server reuses numbers.
        if self._next == 0 or message.next_sequence < self._stated:
            self._next = message.next_sequence
        self._stated = message.next_sequence
        self._look()

    def _hear_events(self, message: Any) -> None:
        self._heard, self._version = time.monotonic(), message.scene_version
        for k, sequence in enumerate(message.sequence):
            if 0 < self._next < sequence:
                self.missed += sequence - self._next
            elif sequence < self._next:  # the server restarted, and its states will follow
                self._stated = 0
            self._next = sequence + 1
            event = _event(message, k)
            self._follow(event)
            self._on_event(event)
        self._look()

    def _follow(self, event: ProximityEvent) -> None:
        """Update a rule's standing by an event, which precedes the states message."""
        if self._standing is None:
            return
        if event.why == 'gone':
            self._standing.pop(event.rule, None)
            return
        new = RuleStanding(event.rule, event.level, False, '', 0.0, 0, 0, '')
        why = event.why if event.entered else ''
        before = self._standing.get(event.rule, new)
        self._standing[event.rule] = replace(
            before,
            entered=event.entered,
            why=why,
            since=event.stamp,
            awaits_acknowledgement=False,
            entered_sequence=event.sequence if event.entered else before.entered_sequence,
        )

    def _look(self) -> None:
        reason = self.why_stop()
        if reason != self._last_reason:
            self._last_reason = reason
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
