"""Gates on the middleware: topics of commands of velocity, opened by the type of who is there."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.publisher import Publisher

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.gates import decide_gate, refuse_shared_topic
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.velocity_gate import PERIOD, VelocityGate
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.ros.outputs.diagnostics import add_trouble, add_values
from drake_geom_ros.ros.surface import Surface, results, sensor_data
from drake_geom_ros.scene_files import Gate

_LOOK_PERIOD = 0.2  # [s] between two looks at who is there
_KINDS = {'Twist': Twist, 'TwistStamped': TwistStamped}


class Gates:
    """The gates of a node.

    Commands and decisions come in the thread of the cycles. A thread of its own looks for silence,
    so that a robot is stopped although that one is busy.
    """

    def __init__(
        self,
        node: Node,
        surface: Surface,
        guard: Guard,
        group: CallbackGroup,
        clocks: Clocks,
        gates: Sequence[Gate],
    ) -> None:
        """Open the gates; raises ArgumentError for topics that cannot be, or are of two gates."""
        self._clocks, self._guard = clocks, guard
        full = [_with_full_topics(gate, surface) for gate in gates]
        for number, gate in enumerate(full):
            refuse_shared_topic(gate, full[:number])
        self._gates = [_OpenGate(node, surface, guard, group, clocks, gate) for gate in full]
        if not self._gates:
            return
        self._ended = threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()
        surface.until_closed(self._ended.set)
        surface.timer(_LOOK_PERIOD, partial(guard.attempt, self._look_for_types))

    def open(self) -> None:
        """Pass commands on from now on."""
        for gate in self._gates:
            gate.passes.open()

    def close(self) -> None:
        """Stop the robots, and pass nothing on."""
        for gate in self._gates:
            gate.passes.close()

    def decide(self, scene: HeldScene) -> None:
        """Take what the rules of a scene allow now."""
        for gate in self._gates:
            decide_gate(scene, gate.gate.robot, gate.passes, self._clocks.steady())

    def tell(self, status: Any) -> None:
        """Add to a status of diagnostics what each gate does."""
        now = self._clocks.steady()
        for gate in self._gates:
            scale, why = gate.passes.allowed(now)
            words = f'scale {scale:.3g}, stopped {gate.passes.stopped} times'
            reason = f': {why}' if why else ''
            add_values(status, {gate.gate.in_words(): f'{words}{reason}'})
            if trouble := gate.trouble():
                add_trouble(status, trouble)

    def _look_for_types(self) -> None:
        for gate in self._gates:
            gate.look_for_type()

    def _watch(self) -> None:
        while not self._ended.wait(PERIOD):
            for gate in self._gates:
                self._guard.attempt(partial(gate.passes.look, self._clocks.steady()))


class _OpenGate:
    """One gate, whose topics open once their type is known."""

    def __init__(
        self,
        node: Node,
        surface: Surface,
        guard: Guard,
        group: CallbackGroup,
        clocks: Clocks,
        gate: Gate,
    ) -> None:
        self.gate = gate
        self.passes = VelocityGate(self._publish, gate.timeout)
        self._node, self._surface, self._guard = node, surface, guard
        self._group, self._clocks = group, clocks
        self._publisher: Publisher | None = None
        self._frame = ''  # of the last command with a header
        self._types: list[str] = []  # that were found
        if gate.type:
            self._open(_KINDS[gate.type])

    def look_for_type(self) -> None:
        """Open the topics, if it is known now of which type they are."""
        if self._publisher is not None:
            return
        commands = self._node.get_publishers_info_by_topic(self.gate.input)
        base = self._node.get_subscriptions_info_by_topic(self.gate.output)
        type_names = {end.topic_type.rpartition('/')[2] for end in (*commands, *base)}
        self._types = sorted(type_names.intersection(_KINDS))
        if len(self._types) == 1:
            self._open(_KINDS[self._types[0]])

    def trouble(self) -> str:
        """Return what is wrong with the topics, in words; empty: nothing."""
        gate = self.gate
        if self._publisher is None:
            if len(self._types) > 1:
                return (
                    f'the {gate.in_words()} is not open: its topics have the types '
                    f'{" and ".join(self._types)}; give the gate a type'
                )
            return ''
        others = self._node.count_publishers(gate.output) - 1
        if others > 0:
            return (
                f'{others} more publish on {gate.output}: what they send passes no gate; have '
                f'them publish on {gate.input}'
            )
        return ''

    def _open(self, kind: Any) -> None:
        gate, stamped = self.gate, kind is TwistStamped
        self._publisher = self._surface.publisher(kind, gate.output, results())
        take: Callable[[Any], None] = self._take_stamped if stamped else self._take
        self._surface.subscription(kind, gate.input, take, sensor_data(), self._group)

    def _take(self, message: Twist) -> None:
        self._take_twist(message, None)

    def _take_stamped(self, message: TwistStamped) -> None:
        self._frame = message.header.frame_id
        self._take_twist(message.twist, message.header)

    def _take_twist(self, twist: Twist, header: Any) -> None:
        parts = (twist.linear, twist.angular)
        values = np.array([[part.x, part.y, part.z] for part in parts], dtype=np.float64)
        now = self._clocks.steady()
        self._guard.take(self.gate.input, self.passes.take, values.ravel(), now, header)

    def _publish(self, values: Floats, header: Any) -> None:
        publisher = self._publisher
        if publisher is None:  # nobody was told of any motion
            return
        twist = Twist()
        twist.linear.x, twist.linear.y, twist.linear.z = values[:3].tolist()
        twist.angular.x, twist.angular.y, twist.angular.z = values[3:].tolist()
        if publisher.msg_type is Twist:
            publisher.publish(twist)
            return
        message = TwistStamped(twist=twist)
        if header is None:
            message.header.stamp = self._node.get_clock().now().to_msg()
            message.header.frame_id = self._frame
        else:
            message.header = header
        publisher.publish(message)


def _with_full_topics(gate: Gate, surface: Surface) -> Gate:
    """Return a gate with the full names of its topics, as remappings have them."""
    topics = surface.full_topic(gate.input), surface.full_topic(gate.output)
    if topics[0] == topics[1]:
        raise ArgumentError(
            f'{gate.where}: the {gate.in_words()} has two names of one topic, {topics[0]!r}; it '
            'would hear itself'
        )
    return replace(gate, input=topics[0], output=topics[1])
