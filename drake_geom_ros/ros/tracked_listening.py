"""Listens to trackers: to ~/tracked_objects, and to markers and detections where asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from visualization_msgs.msg import MarkerArray

from drake_geom_ros.live.conversions.arrivals import MessageInfo, publisher_of, waited
from drake_geom_ros.live.conversions.tracked_markers import MarkerReader, bodies_of_detections
from drake_geom_ros.live.conversions.tracked_objects import Bodies, TrackedObjectsReader
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.sensor_frames import SensorFrames
from drake_geom_ros.live.inputs.tracked_input import TrackedInput, trackers_in_words
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.ros import topics
from drake_geom_ros.ros.callback_groups import CallbackGroups
from drake_geom_ros.ros.message_classes import message_class
from drake_geom_ros.ros.message_reading import tracked_objects_reader
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
        """Open the topics; where bodies moved, a cycle runs, or that of other poses comes soon."""
        self._surface, self._live, self._guard = surface, live, guard
        self._group = groups.tracked
        self._input = TrackedInput(live, SensorFrames(lambda: stream.inputs.tf))
        self._stream = stream
        self._changed = surface.wake(partial(guard.attempt, stream.map_has_changed), groups.stream)
        objects, markers = TrackedObjectsReader(), MarkerReader()
        row = topics.TRACKED_OBJECTS
        reader = tracked_objects_reader(row.type())

        def read_bytes(raw: bytes, sender: str) -> Bodies:
            return objects.read(reader.read(raw, sender), live.files)

        self._listen(row.topic, row.type(), read_bytes, by_bytes=True)
        if values.tracked_markers:
            self._listen(values.tracked_markers, MarkerArray, lambda m, _: markers.read(m))
        if values.tracked_detections:
            kind, lifetime = message_class(_DETECTIONS), values.tracked_lifetime
            self._listen(
                values.tracked_detections, kind, lambda m, _: bodies_of_detections(m, lifetime)
            )

    def sweep(self) -> None:
        """Take out the bodies that were not named for their lifetimes."""
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

    def _listen(
        self,
        topic: str,
        kind: Any,
        read: Callable[[Any, str], Bodies],
        *,
        by_bytes: bool = False,
    ) -> None:
        """Open a topic; ``read`` gets a message, or its bytes, and the identity of its sender."""

        def take(message: Any, arrival: topics.MessageArrival) -> None:
            self._input.take(read(message, arrival.sender), *arrival, topic)
            if not self._stream.has_cycle_soon():
                self._changed()

        def hear(message: Any, info: MessageInfo) -> None:
            arrival = topics.MessageArrival(waited(info), publisher_of(info))
            self._guard.take(topic.removeprefix('~/'), take, message, arrival)

        profile = topics.TRACKED_OBJECTS.profile()
        self._surface.subscription(kind, topic, hear, profile, self._group, raw=by_bytes)
