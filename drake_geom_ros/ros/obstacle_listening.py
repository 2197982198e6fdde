"""Listens to what sensors see: to the topics of the maps that ``obstacles`` names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from drake_geom_ros.live.conversions.arrivals import Gaps, MessageInfo, publisher_of, waited
from drake_geom_ros.live.conversions.misread_numbers import refuse_misread_numbers
from drake_geom_ros.live.conversions.paddings import paddings_of
from drake_geom_ros.live.guard import Guard
from drake_geom_ros.live.inputs.lasting_maps import LastingMaps
from drake_geom_ros.live.inputs.late_messages import LateMessages
from drake_geom_ros.live.inputs.obstacle_records import ObstacleSettings
from drake_geom_ros.live.inputs.obstacle_sources import (
    age_limits,
    camera_info_of,
    refuse_taken_name,
    refuse_without_package,
    removable,
    saved_sources,
    settings_of,
)
from drake_geom_ros.live.inputs.obstacles import ObstacleInput
from drake_geom_ros.live.inputs.sensor_frames import SensorFrames
from drake_geom_ros.live.pose_stream import PoseStream
from drake_geom_ros.live.scene.changes.standing_maps import standing_maps
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import stand_fed
from drake_geom_ros.live.scene.map_sources import (
    ListedSource,
    MapSources,
    NamedSource,
    SourceOrigin,
)
from drake_geom_ros.live.scene.pose_history import PoseHistory
from drake_geom_ros.ros import topics
from drake_geom_ros.ros.callback_groups import CallbackGroups
from drake_geom_ros.ros.message_classes import message_class
from drake_geom_ros.ros.outputs.diagnostics import add_trouble, add_values
from drake_geom_ros.ros.parameters import NodeParameters, ParameterStore
from drake_geom_ros.ros.sensing.process import SensingProcess
from drake_geom_ros.ros.sensing.protocol import (
    CAMERA,
    CLOUD,
    CONE,
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
    MAPS,
    OCTOMAP,
    POINT_CLOUD,
    RANGE,
    ObstacleSource,
)
from drake_geom_ros.sensed_maps.passes import compile_passes
from drake_geom_ros.sensed_maps.tree_walk import compile_tree_walk

_GRID = 'nav_msgs/msg/OccupancyGrid'
_LATE_PERIOD = 0.02  # [s] between two looks whether the poses of maps that wait have come
_LASTING_PERIOD = 0.1  # [s] between two looks whether frames of static maps were posed elsewhere


def _sensed(source: ObstacleSource) -> list[tuple[str, str]]:
    """Return the kind of message and the topic that the sensor process listens to."""
    if source.type == DEPTH_IMAGE:
        return [(CAMERA, camera_info_of(source.topic)), (IMAGE, source.topic)]
    kinds = {POINT_CLOUD: CLOUD, LASER_SCAN: SCAN, RANGE: CONE}
    return [(kinds[source.type], source.topic)] if source.type in kinds else []


class ObstacleListening:
    """The inputs of maps: a process for clouds, scans and images, subscriptions for maps."""

    def __init__(
        self,
        surface: Surface,
        live: LiveScene,
        stream: PoseStream,
        guard: Guard,
        groups: CallbackGroups,
        settings: ParameterStore,
        sources: Mapping[str, NamedSource],
    ) -> None:
        """Open the sources by name; where a map of the scene changed, a cycle runs."""
        self._surface, self._live, self._guard = surface, live, guard
        self._group, self._settings = groups.obstacles, settings
        self._changed = surface.wake(partial(guard.attempt, stream.map_has_changed), groups.stream)
        self._hanging = SensorFrames(lambda: stream.inputs.tf)
        self._sources = dict(sources)
        self.inputs = {name: self._input_of(each.source) for name, each in sources.items()}
        self._maps: dict[str, Subscription[Any]] = {}  # of sources that send maps
        self._late, self._lasting = LateMessages(), LastingMaps(live, self._hanging)
        self._process: SensingProcess | None = None
        with live.editing() as scene:
            self._follow(scene)
            if sources:
                stand_fed(scene, live.map_sources)
        self._open()
        surface.timer(_LATE_PERIOD, partial(guard.attempt, self._late.retry), self._group)
        look = partial(guard.take, 'static maps', self._lasting.look)
        surface.timer(_LASTING_PERIOD, look, self._group)

    def add(self, source: ObstacleSource) -> None:
        """Listen to one more source, the map of which waits for its first message.

        Raises RuntimeError to refuse, and then nothing has changed.
        """
        refuse_taken_name(source, self._sources)
        refuse_without_package(source)
        for topic in (topic for _, topic in _sensed(source) or [('', source.topic)]):
            self._surface.full_topic(topic)
        compile_passes()
        compile_tree_walk()
        name = source.name
        with self._live.editing() as scene:
            change = standing_maps(scene, [], [name], self._live.map_sources.margin)

        def then(scene: HeldScene, made: Any) -> int:
            cells = change.then(scene, made)
            if scene.poses.history is None:
                scene.poses.history = PoseHistory()
            self._sources = {**self._sources, name: NamedSource(source, SourceOrigin.SERVICE)}
            self.inputs = {**self.inputs, name: self._input_of(source)}
            self._follow(scene)
            return cells

        self._live.change(replace(change, then=then), calls_for_more=True)
        self._live.compile_kernels()
        self._open()
        self._changed()

    def remove(self, name: str) -> int:
        """Listen to a source no more; return the number of cells that its map had.

        Raises RuntimeError where there is none, or one of a parameter or a scene file.
        """
        removable(name, self._sources)
        with self._live.editing() as scene:
            change = standing_maps(scene, [name], [], self._live.map_sources.margin)

        def then(scene: HeldScene, made: Any) -> int:
            self.inputs[name].remove()
            self._sources = {key: each for key, each in self._sources.items() if key != name}
            self.inputs = {key: each for key, each in self.inputs.items() if key != name}
            self._follow(scene)
            return change.then(scene, made)

        cells = self._live.change(replace(change, then=then))
        self._open()
        self._changed()
        return cells

    def listed(self) -> list[ListedSource]:
        """Return the open sources."""
        inputs = self.inputs
        return [
            ListedSource(*each, inputs[name].counts.taken)
            for name, each in list(self._sources.items())
            if name in inputs
        ]

    def _now(self) -> ObstacleSettings:
        return obstacle_settings(self._settings.values)

    def _input_of(self, source: ObstacleSource) -> ObstacleInput:
        def settings() -> ObstacleSettings:
            return settings_of(source, self._now())

        return ObstacleInput(source, self._live, settings, self._hanging, self._changed)

    def _follow(self, scene: HeldScene) -> None:
        """Register the sources in the scene, each with its settings."""
        now, live = self._now, self._live
        sources = {name: each.source for name, each in self._sources.items()}
        live.map_sources = MapSources(
            self.inputs,
            now().margin,
            lambda: now().resolution,
            self._changed,
            self.add,
            self.remove,
            self.listed,
        )

        def told_apart(name: str) -> float:
            source = sources.get(name)
            if source is None or source.type in MAPS:
                return 0.0
            return settings_of(source, now()).told_apart

        scene.maps.stand = partial(stand_fed, sources=live.map_sources)
        scene.maps.told_apart = told_apart
        scene.maps.limits = age_limits(sources)
        scene.maps.sources = saved_sources(sources.values())

    def tell(self, status: Any) -> None:
        """Add counts of taken and refused messages to a diagnostic status."""
        add_values(status, self._values())
        for trouble in self._troubles():
            add_trouble(status, trouble)
        if self._process is not None:
            self._process.look()
            add_values(status, {'process of sensors': self._process.in_words()})
            if trouble := self._process.trouble:
                add_trouble(status, trouble)

    def close(self) -> None:
        """End the process; the caller must not hold the scene, for which it may wait."""
        if self._process is not None:
            self._process.close()

    def _open(self) -> None:
        """Listen to the topics of the sources, and to no others."""
        sources = [each.source for each in self._sources.values()]
        sensed = tuple(
            _topic(self._surface, source, kind, topic, its_own=self._is_added(source))
            for source in sources
            for kind, topic in _sensed(source)
        )
        if self._process is not None:
            self._process.listen_to(sensed, self.inputs)
        elif sensed:
            space, _, name = self._surface.full_name().rpartition('/')
            task = Task(f'{name}{SENSORS}', space or '/', self._surface.enclave(), sensed)
            self._process = SensingProcess(task, self.inputs, self._guard)
            self._surface.until_closed(self._process.close)  # where opening others fails
        maps = {source.name: source for source in sources if source.type in MAPS}
        for name in self._maps.keys() - maps.keys():
            self._surface.close_subscription(self._maps.pop(name))
            self._late.forget(name)
            self._lasting.forget(name)
        for name in maps.keys() - self._maps.keys():
            self._maps[name] = self._listen(maps[name])

    def _is_added(self, source: ObstacleSource) -> bool:
        return self._sources[source.name].origin == SourceOrigin.SERVICE

    def _values(self) -> dict[str, str]:
        values = {}
        for name, each in self.inputs.items():
            counts = each.counts
            values[f'obstacles {name}'] = (
                f'{counts.taken} messages taken, {counts.missed} lost or replaced by newer ones '
                f'before they were; of the last one {counts.points} points, '
                f'{counts.not_finite} not finite, {counts.out_of_reach} out of reach, '
                f'{counts.on_bodies} on bodies that the scene knows, {counts.in_shell} beside '
                f'them, which rules take for near, {counts.out_of_box} beyond '
                f'obstacle_box, {counts.in_sparse_cells} in cells with fewer points than '
                'obstacle_least_points that are not held, which are in no answer; '
                f'{counts.cells} cells, {counts.held_cells} of them held from before, '
                f'{counts.shadow_cells} behind bodies, which hide them from the sensor, and '
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

    def _listen(self, source: ObstacleSource) -> Subscription[Any]:
        """Open the topic of a source that sends maps."""
        told_as, profile = source.topic.removeprefix('~/'), _profile(source)
        its_map, gaps = self.inputs[source.name], Gaps()
        is_tree = source.type == OCTOMAP
        take = its_map.take_octomap if is_tree else its_map.take_grid

        def hear(message: Any, info: MessageInfo) -> None:
            def attempt() -> None:
                refuse_misread_numbers(message)
                publisher = publisher_of(info)
                attempted = partial(take, message, waited(info), publisher, patience=0.0)
                if source.static:
                    header = its_map.framed(message.header)
                    self._lasting.take(source.name, publisher, header, attempted)
                else:
                    attempted()

            def refuse(error: Exception) -> None:
                foreseen = isinstance(error, RuntimeError)
                self._guard.refused(
                    told_as, str(error) if foreseen else f'internal error: {error!r}'
                )

            missed = gaps.before(info)
            missed += self._late.take(source.name, attempt, refuse, profile.depth)
            if missed:
                its_map.miss(missed)

        return self._surface.subscription(
            topics.OCTOMAP.type() if is_tree else message_class(_GRID),
            source.topic,
            hear,
            profile,
            self._group,
            comes_and_goes=self._is_added(source),
        )


def _profile(source: ObstacleSource) -> QoSProfile:
    """Return the profile of a source: as usual for sensors but for what it says itself."""
    profile, qos = topics.newest(), source.qos
    if qos.reliability is not None:
        profile.reliability = ReliabilityPolicy.get_from_short_key(qos.reliability)
    if qos.durability is not None:
        profile.durability = DurabilityPolicy.get_from_short_key(qos.durability)
    if qos.depth is not None:
        profile.depth = qos.depth
    return profile


def _topic(
    surface: Surface, source: ObstacleSource, kind: str, topic: str, *, its_own: bool
) -> SensorTopic:
    """Return the options of a process that listens to a topic of this node."""
    name, profile = surface.heard_elsewhere(topic, _profile(source), comes_and_goes=its_own)
    return SensorTopic(
        source.name,
        kind,
        topic.removeprefix('~/'),
        name,
        int(profile.history),
        profile.depth,
        int(profile.reliability),
        int(profile.durability),
    )


def obstacle_settings(values: NodeParameters) -> ObstacleSettings:
    """Return how maps are made by the values of parameters."""
    return ObstacleSettings(
        resolution=values.obstacle_resolution,
        reach=values.obstacle_reach,
        padding=values.obstacle_padding,
        paddings=paddings_of(values.obstacle_paddings, 'obstacle_paddings'),
        noise=values.obstacle_noise,
        self_filter=values.obstacle_self_filter,
        least_points=values.obstacle_least_points,
        keep=values.obstacle_keep,
        keep_hidden=values.obstacle_keep_hidden,
        rays=values.obstacle_rays,
        margin=values.obstacle_margin,
        box=values.obstacle_box,
    )
