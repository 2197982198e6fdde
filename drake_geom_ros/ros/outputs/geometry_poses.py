"""Publishes ~/geometry_poses, where all geometries are, while somebody looks. No ROS import."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.geometry import SceneGraphInspector
from drake_geom_ros.math.batched import compose, poses_from_matrices
from drake_geom_ros.ros.conversions.fields import floats, unsigned
from drake_geom_ros.ros.scene.live_scene import LiveScene


class GeometryPoses:
    """Publishes the poses of now whenever it is told to, from a view: the cycle does not wait."""

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        message: Callable[[], Any],
        did: Callable[[int, float], None],
    ) -> None:
        """``message`` makes a GeometryPoses.

        ``did(count, seconds)`` is told of each message: how many geometries, how long it took.
        """
        self._did = did
        self._live = live
        self._publisher = publisher
        self._message = message
        self._fixed: _Fixed | None = None

    def publish(self) -> None:
        """Publish, if somebody listens."""
        if not self._publisher.get_subscription_count():
            return
        start = time.perf_counter()
        view = self._live.view()
        if self._fixed is None or self._fixed.version != view.moment.version:
            self._fixed = _Fixed(view.query.inspector(), view.moment.version)
        fixed = self._fixed
        R_WFs, p_WFs, placed = view.context.X_WFs(fixed.frames)
        R_WGs, p_WGs = compose(
            *(R_WFs[placed], p_WFs[placed]), *(fixed.R_FGs[placed], fixed.p_FGs[placed])
        )
        message = self._message()
        message.header.frame_id = view.moment.world_frame
        if view.moment.newest_stamp is not None:
            message.header.stamp = view.moment.newest_stamp
        message.scene_version = view.moment.version
        message.names_version = view.moment.names_version
        message.ids = unsigned(fixed.ids[placed])
        message.poses = floats(poses_from_matrices(R_WGs, p_WGs).ravel())
        self._publisher.publish(message)
        self._did(len(message.ids), time.perf_counter() - start)


class _Fixed:
    """What does not move: the geometries of a version of the scene, and X_FG of each."""

    def __init__(self, inspector: SceneGraphInspector, version: int) -> None:
        self.version = version
        ids = inspector.GetAllGeometryIds()
        self.ids = np.array([id.get_value() for id in ids], dtype=np.int64)
        frames = [inspector.GetFrameId(id).get_value() for id in ids]
        self.frames = np.array(frames, dtype=np.int64)
        X_FGs = [inspector.GetPoseInFrame(id) for id in ids]
        self.R_FGs = np.array([X.rotation().matrix() for X in X_FGs]).reshape(-1, 3, 3)
        self.p_FGs = np.array([X.translation() for X in X_FGs]).reshape(-1, 3)
