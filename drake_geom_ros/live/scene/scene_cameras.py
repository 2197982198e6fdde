"""The cameras of the live scene."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import ArgumentError, FrameId
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.camera_limits import CameraLimits
from drake_geom_ros.scene_files import CameraDescription


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
