"""Listens to trackers: to ~/tracked_objects, and to markers and detections where asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from visualization_msgs.msg import MarkerArray

from drake_geom_ros.live.conversions.arrivals import MessageInfo, publisher_of, waited
from drake_geom_ros.live.conversions.serialized_tracked import TrackedObjectsBytes
from drake_geom_ros.live.conversions.tracked_markers import MarkerReader, bodies_of_detections
from drake_geom_ros.live.conversions.tracked_objects import Bodies, TrackedObjectsReader
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.sensor_frames import SensorFrames
from drake_geom_ros.live.inputs.tracked_input import TrackedInput, trackers_in_words
from drake_geom_ros.live.inputs.waiting_bodies import WaitingBodies, WaitingMessage
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros import topics
from drake_geom_ros.ros.callback_groups import CallbackGroups
from drake_geom_ros.ros.message_classes import message_class
from drake_geom_ros.ros.message_reading import MessageReader, time_of
from drake_geom_ros.ros.outputs.diagnostics import add_trouble, add_values
from drake_geom_ros.ros.parameters import NodeParameters
from drake_geom_ros.ros.surface import Surface

_DETECTIONS = 'vision_msgs/msg/Detection3DArray'


class TrackedListening:
    """The inputs of tracked bodies."""

    def __init__(
        self,
        surface: Surface,
        live: LiveScene,
        stream: PoseStream,
        guard: Guard,
        groups: CallbackGroups,
        values: NodeParameters,
    ) -> None:
        """Open the topics; where bodies moved, a cycle runs, or that of other poses comes soon.

        Messages of ``~/tracked_objects`` wait for such poses.
        """
        self._surface, self._live, self._guard = surface, live, guard
        self._group = groups.tracked
        self._input = TrackedInput(live, SensorFrames(lambda: stream.inputs.tf))
        self._stream = stream
        self._changed = surface.wake(partial(guard.attempt, stream.map_has_changed), groups.stream)
        self._waiting = self._listen_to_objects()
        stream.with_poses = self._waiting.move_with
        markers = MarkerReader()
        if values.tracked_markers:
            self._listen(values.tracked_markers, MarkerArray, markers.read)
        if values.tracked_detections:
            kind, lifetime = message_class(_DETECTIONS), values.tracked_lifetime
            self._listen(
                values.tracked_detections, kind, lambda m: bodies_of_detections(m, lifetime)
            )

    def sweep(self) -> None:
        """Take out the bodies that were not named for their lifetimes.

        Messages that wait for poses which have stopped are taken, too.
        """
        if self._waiting and not self._stream.has_cycle_soon():
            self._waiting.call_later()
        if self._input.sweep():
            self._changed()

    def tell(self, status: Any) -> None:
        """Add to a status of diagnostics how many bodies there are, and of which trackers."""
        with self._live.reading() as scene:
            words, troubles = trackers_in_words(scene), scene.tracked.troubles()
            absent = scene.poses.visitors.in_words()
        for each in words:
            add_values(status, {'tracked': each})
        if absent:
            add_values(status, {'absent': absent})
        for trouble in troubles:
            add_trouble(status, trouble)

    def _listen_to_objects(self) -> WaitingBodies:
        """Open ~/tracked_objects; return the messages of it that wait."""
        row, objects = topics.TRACKED_OBJECTS, TrackedObjectsReader()
        name, by_bytes = row.topic.removeprefix('~/'), TrackedObjectsBytes(time_of)
        reader = MessageReader(row.type(), by_bytes)

        def read(raw: bytes, sender: str) -> Bodies:
            return objects.read(reader.read(raw, sender), self._live.files)

        def take(message: WaitingMessage) -> None:
            def do(raw: bytes, arrival: topics.MessageArrival) -> None:
                self._take(read(raw, arrival.sender), arrival, row.topic)

            self._guard.take(name, do, message.raw, _arrival_of(message.info))

        def move(message: WaitingMessage, scene: HeldScene) -> bool:
            left = []

            def do(raw: bytes, arrival: topics.MessageArrival) -> None:
                bodies = read(raw, arrival.sender)
                if not self._input.move(scene, bodies, *arrival, row.topic):
                    left.append(bodies)

            arrival = _arrival_of(message.info)
            if not by_bytes.repeats(message.raw, arrival.sender):
                return False
            self._guard.take(name, do, message.raw, arrival)
            return not left

        def take_all() -> None:
            waiting.take_all()

        def hear(raw: bytes, info: MessageInfo) -> None:
            waiting.add(raw, info)
            if not self._stream.has_cycle_soon():
                take_all()

        waiting = WaitingBodies(take, move, self._surface.wake(take_all, self._group))
        self._surface.subscription(
            row.type(), row.topic, hear, row.profile(), self._group, raw=True
        )
        return waiting

    def _listen(self, topic: str, kind: Any, read: Callable[[Any], Bodies]) -> None:
        """Open a topic of messages that ``read`` makes bodies of."""

        def take(message: Any, arrival: topics.MessageArrival) -> None:
            self._take(read(message), arrival, topic)

        def hear(message: Any, info: MessageInfo) -> None:
            self._guard.take(topic.removeprefix('~/'), take, message, _arrival_of(info))

        profile = topics.TRACKED_OBJECTS.profile()
        self._surface.subscription(kind, topic, hear, profile, self._group)

    def _take(self, bodies: Bodies, arrival: topics.MessageArrival, topic: str) -> None:
        """Take bodies in the thread of trackers."""
        self._input.take(bodies, *arrival, topic)
        if not self._stream.has_cycle_soon():
            self._changed()


def _arrival_of(info: MessageInfo) -> topics.MessageArrival:
    return topics.MessageArrival(waited(info), publisher_of(info))
