"""The optical frames of cameras for TF: /tf_static for those at rest, /tf for those that move."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable
from typing import Any

from geometry_msgs.msg import TransformStamped

from drake_geom_ros.live.conversions.cameras import optical_frame
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import CameraDescription


class CameraTransforms:
    """Sends X_WC of cameras, in whose optical frames (REP 103) x is to the right, z ahead.

    Their parent is the world, not the frames that carry them: those are posed by messages
    and need not be in TF. Nothing is opened before there is a camera, and nothing is sent without
    tf2_msgs, which not everybody has.
    """

    def __init__(self, surface: Any, world_frame: str, resting: Any, moving: Any) -> None:
        """``resting`` and ``moving`` are the profiles of /tf_static and /tf."""
        self._surface, self._world_frame = surface, world_frame
        self._profiles = {'/tf_static': resting, '/tf': moving}
        self._publishers: dict[str, Any] = {}
        self._fixed: list[str] = []  # the cameras that were told to rest

    def fix(self, cameras: Iterable[CameraDescription]) -> None:
        """Send all cameras that are fixed in the world, latched for late subscribers."""
        fixed = list(cameras)
        if fixed or self._fixed:
            self._fixed = [camera.name for camera in fixed]
            self._send('/tf_static', [self._entry(camera, camera.X_FC) for camera in fixed])

    def move(self, camera: CameraDescription, X_WC: RigidTransform, stamp: Any) -> None:
        """Send the pose of a camera when its image was taken."""
        self._send('/tf', [self._entry(camera, X_WC, stamp)])

    def _send(self, topic: str, entries: list[TransformStamped]) -> None:
        if importlib.util.find_spec('tf2_msgs') is None:
            return
        from tf2_msgs.msg import TFMessage

        if topic not in self._publishers:
            profile = self._profiles[topic]
            self._publishers[topic] = self._surface.publisher(TFMessage, topic, profile)
        self._publishers[topic].publish(TFMessage(transforms=entries))

    def _entry(
        self, camera: CameraDescription, X_WC: RigidTransform, stamp: Any = None
    ) -> TransformStamped:
        entry = TransformStamped(child_frame_id=optical_frame(camera))
        entry.header.frame_id = self._world_frame
        if stamp is not None:
            entry.header.stamp = stamp
        p, q = entry.transform.translation, entry.transform.rotation
        p.x, p.y, p.z, q.x, q.y, q.z, q.w = X_WC.ToArray().tolist()
        return entry
