"""Listens to what sensors see: to the topics of the maps that ``obstacles`` names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from drake_geom_ros.live.conversions.arrivals import MessageInfo, publisher_of, waited
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.obstacle_records import ObstacleSettings
from drake_geom_ros.live.inputs.obstacle_sources import age_limits, camera_info_of, settings_of
from drake_geom_ros.live.inputs.obstacles import ObstacleInput
from drake_geom_ros.live.inputs.sensor_frames import SensorFrames
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import stand_fed
from drake_geom_ros.live.scene.map_sources import MapSources
from drake_geom_ros.ros import topics
from drake_geom_ros.ros.callback_groups import CallbackGroups
from drake_geom_ros.ros.outputs.diagnostics import add_trouble, add_values
from drake_geom_ros.ros.parameters import NodeParameters, ParameterStore
from drake_geom_ros.ros.sensing.process import SensingProcess
from drake_geom_ros.ros.sensing.protocol import (
    CAMERA,
    CLOUD,
    IMAGE,
    SCAN,
    SENSORS,
    SensorTopic,
    Task,
)
from drake_geom_ros.ros.surface import Surface
from drake_geom_ros.scene_files import (
    DEPTH_IMAGE,
    LASER_SCAN,
    OCTOMAP,
    POINT_CLOUD,
    ObstacleSource,
)


def _sensed(source: ObstacleSource) -> list[tuple[str, str]]:
    """Return what a process of its own listens to: what comes there, and the topic."""
    if source.type == DEPTH_IMAGE:
        return [(CAMERA, camera_info_of(source.topic)), (IMAGE, source.topic)]
    kinds = {POINT_CLOUD: CLOUD, LASER_SCAN: SCAN}
    return [(kinds[source.type], source.topic)] if source.type in kinds else []


class ObstacleListening:
    """The inputs of maps: a process for clouds and images, a subscription for OctoMaps."""

    def __init__(
        self,
        surface: Surface,
        live: LiveScene,
        stream: PoseStream,
        guard: Guard,
        groups: CallbackGroups,
        settings: ParameterStore,
        sources: Mapping[str, ObstacleSource],
    ) -> None:
        """Open the sources by name; where a map of the scene changed, a cycle runs."""
        self._surface, self._guard, self._group = surface, guard, groups.obstacles
        answer = partial(guard.attempt, stream.map_has_changed)
        changed = surface.wake(answer, groups.stream)

        def now() -> ObstacleSettings:
            return obstacle_settings(settings.values)

        def told_apart(name: str) -> float:
            source = sources.get(name)
            if source is None or source.type == OCTOMAP:
                return 0.0
            return settings_of(source, now()).told_apart

        hanging = SensorFrames(lambda: stream.inputs.tf)

        def input_of(source: ObstacleSource) -> ObstacleInput:
            return ObstacleInput(
                source, live, lambda: settings_of(source, now()), hanging, changed
            )

        self.inputs = {name: input_of(source) for name, source in sources.items()}
        live.map_sources = MapSources(self.inputs, now().margin, lambda: now().resolution, changed)
        if sources:
            with live.editing() as scene:
                scene.maps.stand = partial(stand_fed, sources=live.map_sources)
                scene.maps.told_apart = told_apart
                scene.maps.limits = age_limits(sources)
                stand_fed(scene, live.map_sources)
        self._process = self._sensing(sources)
        for name, source in sources.items():
            if source.type == OCTOMAP:
                self._listen(topics.OCTOMAP.type(), source.topic, self.inputs[name].take_octomap)

    def tell(self, status: Any) -> None:
        """Add to a status of diagnostics what became of messages."""
        add_values(status, self._values())
        for trouble in self._troubles():
            add_trouble(status, trouble)
        if self._process is not None:
            self._process.look()
            add_values(status, {'process of sensors': self._process.in_words()})
            if trouble := self._process.trouble:
                add_trouble(status, trouble)

    def close(self) -> None:
        """End the process; nobody who calls this has the scene, which it may wait for."""
        if self._process is not None:
            self._process.close()

    def _sensing(self, sources: Mapping[str, ObstacleSource]) -> SensingProcess | None:
        """Have clouds, scans and images taken in a process of their own; None: none are."""
        topics = [
            _topic(self._surface, name, kind, topic)
            for name, source in sources.items()
            for kind, topic in _sensed(source)
        ]
        if not topics:
            return None
        space, _, name = self._surface.full_name().rpartition('/')
        task = Task(f'{name}{SENSORS}', space or '/', self._surface.enclave(), topics)
        process = SensingProcess(task, self.inputs, self._guard)
        self._surface.until_closed(process.close)  # where opening others fails
        return process

    def _values(self) -> dict[str, str]:
        values = {}
        for name, each in self.inputs.items():
            counts = each.counts
            values[f'obstacles {name}'] = (
                f'{counts.taken} messages taken; of the last one {counts.points} points, '
                f'{counts.not_finite} not finite, {counts.out_of_reach} out of reach, '
                f'{counts.on_bodies} on bodies that the scene knows, {counts.in_shell} beside '
                f'them, which rules take for near, {counts.out_of_box} beyond '
                f'obstacle_box, {counts.in_sparse_cells} in cells with fewer points than '
                'obstacle_least_points that are not held, which are in no answer; '
                f'{counts.cells} cells, {counts.held_cells} of them held from before, and '
                f'{counts.shell_cells} beside bodies, {counts.held_shell_cells} of them held, '
                f'in {1e3 * counts.seconds:.1f} ms'
            )
        return values

    def _troubles(self) -> list[str]:
        """Return which maps never came, and which several sensors feed, in words."""
        never = [
            f'no message of {each.source.topic} was taken yet: what it would show is in no answer'
            for each in self.inputs.values()
            if not each.counts.taken
        ]
        return never + [trouble for each in self.inputs.values() for trouble in each.troubles()]

    def _listen(self, kind: Any, topic: str, take: Callable[[Any, float, str], object]) -> None:
        def hear(message: Any, info: MessageInfo) -> None:
            who = publisher_of(info)
            self._guard.take(topic.removeprefix('~/'), take, message, waited(info), who)

        self._surface.subscription(kind, topic, hear, topics.newest(), self._group)


def _topic(surface: Surface, its_map: str, kind: str, topic: str) -> SensorTopic:
    """Return what a process has to know to listen to a topic of this node."""
    name, profile = surface.heard_elsewhere(topic, topics.newest())
    how = int(profile.history), profile.depth, int(profile.reliability)
    return SensorTopic(its_map, kind, topic.removeprefix('~/'), name, *how)


def obstacle_settings(values: NodeParameters) -> ObstacleSettings:
    """Return how maps are made by the values of parameters."""
    return ObstacleSettings(
        resolution=values.obstacle_resolution,
        reach=values.obstacle_reach,
        padding=values.obstacle_padding,
        noise=values.obstacle_noise,
        self_filter=values.obstacle_self_filter,
        least_points=values.obstacle_least_points,
        keep=values.obstacle_keep,
        rays=values.obstacle_rays,
        margin=values.obstacle_margin,
        box=values.obstacle_box,
    )
