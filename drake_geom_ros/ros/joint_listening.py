"""Listens to joint states: to the topic of all robots, and to those that robots name."""

from __future__ import annotations

from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.subscription import Subscription

from drake_geom_ros.live.conversions.arrivals import MessageInfo, publisher_of, waited
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.clocks import Clocks
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.ros.message_reading import pose_reader
from drake_geom_ros.ros.parameters import NodeParameters
from drake_geom_ros.ros.surface import Surface
from drake_geom_ros.ros.topics import JOINT_STATES


class JointListening:
    """The subscriptions that joint values come by; those of robots come and go with these."""

    def __init__(
        self,
        surface: Surface,
        stream: PoseStream,
        guard: Guard,
        group: CallbackGroup,
        clocks: Clocks,
        values: NodeParameters,
    ) -> None:
        """Listen to ``joint_states`` if parameters say so, for robots that name no topic."""
        self._surface, self._stream, self._guard, self._group = surface, stream, guard, group
        by_default = values.use_joint_states
        self._input = JointInput(clocks, values.stale_after, by_default=by_default)
        stream.inputs.joints = self._input
        self._open: dict[str, Subscription[Any]] = {}
        if by_default:
            self._listen('', JOINT_STATES.topic)

    def follow(self, scene: HeldScene) -> None:
        """Listen to the topics that the robots of a scene name, and to no others."""
        wanted = self._input.topics(scene)
        for topic in self._open.keys() - wanted:
            self._surface.close_subscription(self._open.pop(topic))
        for topic in wanted - self._open.keys():
            self._open[topic] = self._listen(topic, topic)

    def _listen(self, robots: str, topic: str) -> Subscription[Any]:
        row = JOINT_STATES
        reader = pose_reader(row.type())

        def hear(raw: bytes, waited: float, sender: str) -> None:
            self._stream.take_joint_states(robots, reader.read(raw, sender), waited, sender)

        def take(raw: bytes, info: MessageInfo) -> None:
            self._guard.take(topic, hear, raw, waited(info), publisher_of(info))

        return self._surface.subscription(
            row.kind, topic, take, row.profile(), self._group, raw=True
        )
