"""Publishes ~/geometry_poses, where all geometries are, while somebody looks."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from drake_geom_ros.geometry.queries.fixed_geometries import FixedGeometries
from drake_geom_ros.live.conversions.fields import floats, unsigned
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.math.batched import poses_from_matrices


class GeometryPoses:
    """Publishes the present poses when called, from a view: the cycle does not wait."""

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        message: Callable[[], Any],
        did: Callable[[int, float], None],
    ) -> None:
        """``message`` makes a GeometryPoses.

        ``did(count, seconds)`` is called for each message: how many geometries, how long it took.
        """
        self._did = did
        self._live = live
        self._publisher = publisher
        self._message = message
        self._fixed: FixedGeometries | None = None
        self._version = -1  # of the scene, whose geometries these are

    def publish(self) -> None:
        """Publish, if somebody listens."""
        if not self._publisher.get_subscription_count():
            return
        start = time.perf_counter()
        view = self._live.view()
        if self._fixed is None or self._version != view.moment.version:
            self._fixed = FixedGeometries(view.query.inspector())
            self._version = view.moment.version
        fixed = self._fixed
        R_WGs, p_WGs, placed = fixed.X_WGs(view.context)
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
