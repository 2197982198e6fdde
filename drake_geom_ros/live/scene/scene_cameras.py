"""The cameras of the live scene, and the largest that a node can publish."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import ArgumentError, FrameId
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.scene_files import CameraDescription

# RMW_TOPIC_MAX_NAME_LENGTH of rmw/validate_full_topic_name.h: the middleware puts a prefix before.
LONGEST_TOPIC = 247
# Bytes of a pixel while an image is made: four channels of colour, float32, int16.
_BYTES = {'color': 4, 'depth': 4, 'label': 2}
_LONGEST_END = '/cameras//depth/image_rect_raw'  # around the name of a camera


class SceneCameras:
    """Cameras by name, each with the frame that it is on, within what a node can publish."""

    def __init__(self) -> None:
        self.limits = CameraLimits()
        self._cameras: dict[str, tuple[FrameId, CameraDescription]] = {}

    def by_name(self) -> dict[str, tuple[FrameId, CameraDescription]]:
        """Return all cameras; a copy."""
        return dict(self._cameras)

    def get(self, name: str) -> tuple[FrameId, CameraDescription]:
        """Return the frame of a camera and its description; raises ArgumentError for none."""
        if name not in self._cameras:
            raise ArgumentError(
                f'There is no camera {name[:80]!r}{nearest(name, self._cameras)}. Cameras: '
                f'{some_of(list(self._cameras)) or "none"}. See list_cameras.'
            )
        return self._cameras[name]

    def add(self, frame: FrameId, camera: CameraDescription) -> None:
        """Add a camera on a frame; raises ArgumentError where its name is taken."""
        self.refuse_taken(camera.name)
        if reason := self.limits.refusal(camera):
            raise ArgumentError(reason)
        self._cameras[camera.name] = frame, camera

    def remove(self, name: str) -> None:
        """Remove a camera; raises ArgumentError where there is none of that name."""
        self.get(name)
        del self._cameras[name]

    def begin(self, cameras: Iterable[tuple[FrameId, CameraDescription]]) -> None:
        """Have the cameras of a scene file, which were looked at before."""
        self._cameras.update((camera.name, (frame, camera)) for frame, camera in cameras)

    def forget(self, frames: Collection[FrameId]) -> None:
        """Forget the cameras on frames that have gone."""
        gone = set(frames)
        self._cameras = {n: each for n, each in self._cameras.items() if each[0] not in gone}

    def clear(self) -> None:
        """Forget all cameras."""
        self._cameras = {}

    def refuse_taken(self, name: str) -> None:
        """Raise ArgumentError where a camera has the name."""
        if name in self._cameras:
            raise ArgumentError(f'there is a camera {name!r} already; remove it first')

    def refuse_beyond_limits(self, cameras: Iterable[CameraDescription]) -> None:
        """Raise SceneFileError for a camera of a scene file that the node cannot publish."""
        for camera in cameras:
            if reason := self.limits.refusal(camera):
                raise camera.where.error(reason)


def megabytes(camera: CameraDescription, images: tuple[str, ...] = ()) -> float:
    """Return how much some images of a camera take [MB]; all that it has where none are named."""
    pixels = camera.intrinsics.width() * camera.intrinsics.height()
    return pixels * sum(_BYTES[kind] for kind in images or camera.images) / 1e6


@dataclass
class CameraLimits:
    """The most that a camera may be; without a node there is no limit."""

    megabytes: float = math.inf  # of one set of images
    name: float = math.inf  # letters

    def of_node(self, full_name: str) -> None:
        """Let names be as long as the topics of a node of that name allow."""
        self.name = LONGEST_TOPIC - len(full_name) - len(_LONGEST_END)

    def refusal(self, camera: CameraDescription) -> str:
        """Return why a camera cannot be, or an empty text."""
        if len(camera.name) > self.name:
            return (
                f'the camera name {camera.name[:40]!r}... has {len(camera.name)} letters; '
                f'{self.name} are the most: its topics would have longer names than the '
                'middleware takes'
            )
        return self.refusal_of_images(camera)

    def refusal_of_images(self, camera: CameraDescription, images: tuple[str, ...] = ()) -> str:
        """Return why some images of a camera cannot be taken, or an empty text."""
        size = megabytes(camera, images)
        if size <= self.megabytes:
            return ''
        k = camera.intrinsics
        return (
            f'images of {k.width()} x {k.height()} take {size:.1f} MB; the parameter '
            f'max_answer_size allows {self.megabytes:g} MB'
        )
