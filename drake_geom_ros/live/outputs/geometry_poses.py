"""Publishes ~/geometry_poses, where all geometries are, while somebody looks."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from drake_geom_ros.geometry.queries.fixed_geometries import FixedGeometries
from drake_geom_ros.live.conversions.fields import floats, unsigned
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import poses_from_matrices


class PosesTopic(ABC):
    """Publishes poses of geometries when called, from a view: the cycle does not wait."""

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

    def publish(self) -> None:
        """Publish, if somebody listens."""
        if not self._publisher.get_subscription_count():
            return
        start = time.perf_counter()
        if (poses := self._poses()) is None:
            return
        view, ids, X_WGs = poses
        message = self._message()
        view.moment.stamp_header(message)
        message.names_version = view.moment.names_version
        message.ids, message.poses = unsigned(ids), floats(X_WGs.ravel())
        self._publisher.publish(message)
        self._did(len(ids), time.perf_counter() - start)

    @abstractmethod
    def _poses(self) -> tuple[SceneView, Indices, Floats] | None:
        """Return a view, and ids (k,) and X_WG (k, 7) in it; None: there is no news."""


class GeometryPoses(PosesTopic):
    """Publishes the present poses."""

    _fixed: FixedGeometries | None = None
    _version = -1  # of the scene, whose geometries these are

    def _poses(self) -> tuple[SceneView, Indices, Floats]:
        view = self._live.view()
        if self._fixed is None or self._version != view.moment.version:
            self._fixed = FixedGeometries(view.query.inspector())
            self._version = view.moment.version
        R_WGs, p_WGs, placed = self._fixed.X_WGs(view.context)
        return view, self._fixed.ids[placed], poses_from_matrices(R_WGs, p_WGs)
