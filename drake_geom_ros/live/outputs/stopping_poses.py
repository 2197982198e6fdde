"""Publishes ~/stopping_poses, where robots would be while they stop, while somebody looks."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.geometry.queries.fixed_geometries import FixedGeometries
from drake_geom_ros.live.conversions.fields import floats, unsigned
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import poses_from_matrices


class StoppingPoses:
    """Publishes the poses of what moves, at several places of each stop from the present speed."""

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        message: Callable[[], Any],
        did: Callable[[int, float], None],
    ) -> None:
        """``message`` makes a GeometryPoses.

        ``did(count, seconds)`` is called for each message: how many poses, how long it took.
        """
        self._live, self._publisher, self._message, self._did = live, publisher, message, did
        self._had_any = False

    def publish(self) -> None:
        """Publish, if somebody listens; when all stand, once that there is nothing."""
        if not self._publisher.get_subscription_count():
            return
        start = time.perf_counter()
        with self._live.reading() as scene:
            frames, ways = scene.stopping.ways()
            if not (any(map(len, ways)) or self._had_any):
                return
            view = scene.view()
        ids, poses = _moved(view, frames, ways)
        self._had_any = bool(len(ids))
        message = self._message()
        message.header.frame_id = view.moment.world_frame
        if view.moment.newest_stamp is not None:
            message.header.stamp = view.moment.newest_stamp
        message.scene_version = view.moment.version
        message.names_version = view.moment.names_version
        message.ids, message.poses = unsigned(ids), floats(poses.ravel())
        self._publisher.publish(message)
        self._did(len(ids), time.perf_counter() - start)


def _moved(view: SceneView, frames: Indices, ways: list[Floats]) -> tuple[Indices, Floats]:
    """Return ids (k,) and X_WG (k, 7) of the geometries that are elsewhere at places of ways."""
    fixed = FixedGeometries(view.query.inspector())
    *now, placed = fixed.X_WGs(view.context)
    ids, poses = fixed.ids[placed], poses_from_matrices(*now)
    each_ids, each_poses = [ids[:0]], [poses[:0]]
    for way in ways:
        for X_PFs in way:
            view.context.UpdateFramePoses(FramePoseVector.FromArrays(frames, X_PFs))
            *there, still_placed = fixed.X_WGs(view.context)
            X_WGs = poses_from_matrices(*there)
            moved = (X_WGs != poses).any(axis=1) if np.array_equal(placed, still_placed) else []
            each_ids.append(ids[moved])
            each_poses.append(X_WGs[moved])
    return np.concatenate(each_ids), np.concatenate(each_poses)
