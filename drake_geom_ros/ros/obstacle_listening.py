"""Listens to what sensors see: to the topics of the maps that ``obstacles`` names."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from drake_geom_ros.ros.callback_groups import CallbackGroups
from drake_geom_ros.ros.conversions.serialized_cloud import cloud_of_bytes, is_plain
from drake_geom_ros.ros.guard import Guard
from drake_geom_ros.ros.inputs.obstacles import (
    DEPTH,
    OCTOMAP,
    POINTS,
    ObstacleInput,
    ObstacleSettings,
)
from drake_geom_ros.ros.inputs.sensor_frames import SensorFrames
from drake_geom_ros.ros.outputs.diagnostics import add_trouble, add_values
from drake_geom_ros.ros.parameters import NodeParameters, ParameterStore
from drake_geom_ros.ros.pose_stream import PoseStream
from drake_geom_ros.ros.scene.live_scene import LiveScene
from drake_geom_ros.ros.scene.map_sources import MapSources
from drake_geom_ros.ros.scene.seen_maps import stand_fed
from drake_geom_ros.ros.surface import Surface
from drake_geom_ros.ros.together import MessageInfo, waited


class ObstacleListening:
    """The subscriptions that maps are made from, in a thread of their own."""

    def __init__(
        self,
        surface: Surface,
        live: LiveScene,
        stream: PoseStream,
        guard: Guard,
        groups: CallbackGroups,
        settings: ParameterStore,
    ) -> None:
        """Open them; where a map of the scene changed, a cycle runs."""
        self._surface, self._guard, self._group = surface, guard, groups.obstacles
        answer = partial(guard.attempt, stream.map_has_changed)
        changed = surface.wake(answer, groups.stream)
        names = settings.values.obstacles

        def now() -> ObstacleSettings:
            return obstacle_settings(settings.values)

        hanging = SensorFrames(lambda: stream.inputs.tf)
        self.inputs = {n: ObstacleInput(n, live, now, hanging, changed) for n in names}
        live.map_sources = MapSources(self.inputs, now().margin, lambda: now().resolution, changed)
        if names:
            with live.editing() as scene:
                scene.stand_maps = partial(stand_fed, sources=live.map_sources)
                scene.stand_maps(scene)
        if POINTS in names:
            points = self.inputs[POINTS]

            def take_cloud(raw: bytes, waited: float) -> None:
                points.take_cloud(_cloud_of(raw), waited)

            self._listen(PointCloud2, f'~/obstacles/{POINTS}', take_cloud, raw=True)
        if DEPTH in names:
            depth = self.inputs[DEPTH]
            self._listen(CameraInfo, f'~/obstacles/{DEPTH}/camera_info', depth.take_camera)
            self._listen(Image, f'~/obstacles/{DEPTH}/image_rect_raw', depth.take_depth)
        if OCTOMAP in names:
            Octomap = importlib.import_module('octomap_msgs.msg').Octomap
            octomap = self.inputs[OCTOMAP]
            self._listen(Octomap, f'~/obstacles/{OCTOMAP}', octomap.take_octomap)

    def tell(self, status: Any) -> None:
        """Add to a status of diagnostics what became of messages."""
        add_values(status, self._values())
        for trouble in self._troubles():
            add_trouble(status, trouble)

    def _values(self) -> dict[str, str]:
        told = {}
        for name, each in self.inputs.items():
            counts = each.counts
            told[f'obstacles {name}'] = (
                f'{counts.taken} messages taken; of the last one {counts.points} points, '
                f'{counts.not_finite} not finite, {counts.out_of_reach} out of reach, '
                f'{counts.on_bodies} on bodies that the scene knows, {counts.out_of_box} beyond '
                f'obstacle_box, {counts.in_sparse_cells} in cells with fewer points than '
                'obstacle_least_points, which are in no answer; '
                f'{counts.cells} cells, {counts.held_cells} of them held from before, '
                f'in {1e3 * counts.seconds:.1f} ms'
            )
        return told

    def _troubles(self) -> list[str]:
        """Return which maps never came, in words."""
        return [
            f'no message of ~/obstacles/{name} was taken yet: what it would show is in no answer'
            for name, each in self.inputs.items()
            if not each.counts.taken
        ]

    def _listen(
        self, kind: Any, topic: str, take: Callable[[Any, float], object], *, raw: bool = False
    ) -> None:
        def hear(message: Any, info: MessageInfo) -> None:
            self._guard.take(topic.removeprefix('~/'), take, message, waited(info))

        self._surface.subscription(kind, topic, hear, _newest(), self._group, raw=raw)


def _cloud_of(raw: bytes) -> Any:
    """Return the PointCloud2 of a message as it comes."""
    # A middleware may have another layout.
    return cloud_of_bytes(raw) if is_plain(raw) else deserialize_message(raw, PointCloud2)


def obstacle_settings(values: NodeParameters) -> ObstacleSettings:
    """Return how maps are made by the values of parameters."""
    return ObstacleSettings(
        resolution=values.obstacle_resolution,
        reach=values.obstacle_reach,
        padding=values.obstacle_padding,
        self_filter=values.obstacle_self_filter,
        least_points=values.obstacle_least_points,
        keep=values.obstacle_keep,
        rays=values.obstacle_rays,
        margin=values.obstacle_margin,
        box=values.obstacle_box,
    )


def _newest() -> QoSProfile:
    """Return the profile of what sensors see: what is old by then is not worth its time."""
    return QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
