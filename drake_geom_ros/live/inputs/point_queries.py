"""``~/query_points`` in, ``~/point_distances`` out: distances from clouds of points.

A cloud may be given in the world or in any frame of the scene. Points that are not finite, as
depth cameras send them for what they did not see, are skipped; ``point_index`` counts them.
``query_stamp`` in the answer is the cloud's stamp, by which a client finds its cloud.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.live.conversions.point_cloud import points_from_cloud
from drake_geom_ros.live.conversions.results import fill_point_distances
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.point_blocks import distances_to


class PointQueries:
    """Answers clouds beside the cycle, when somebody listens."""

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        message_class: Any,
        threshold: Callable[[], float],
        is_active: Callable[[], bool],
        did: Callable[[int, float], None],
    ) -> None:
        """``threshold()`` [m] is that of now, and ``is_active()`` whether to publish.

        ``did(count, seconds)`` is called for each answer: number of distances, duration.
        """
        self._is_active = is_active
        self._did = did
        self._live = live
        self._publisher = publisher
        self._message_class = message_class
        self._threshold = threshold

    def take(self, cloud: Any) -> None:
        """Answer a cloud, if the node is active and somebody listens.

        Raises RuntimeError for one that is wrong.
        """
        if not self._is_active() or not self._publisher.get_subscription_count():
            return
        start = time.perf_counter()
        answer = self.answer(cloud)
        if self._is_active():  # it may have taken a while
            self._publisher.publish(answer)
            self._did(len(answer.distance), time.perf_counter() - start)

    def answer(self, cloud: Any) -> Any:
        """Return the PointDistances of a cloud; raises RuntimeError for one that is wrong."""
        view, threshold = self._live.view(), self._threshold()
        points = points_from_cloud(cloud)
        finite = np.flatnonzero(np.isfinite(points).all(axis=1))
        if cloud.header.frame_id:
            frame = view.names.frame(cloud.header.frame_id)
            # What is not finite is skipped anyway, and warned of where it is turned.
            points[finite] = view.query.X_WF(frame).multiply(points[finite].T).T
        parts, blocks = distances_to(view.query, points, finite, threshold)
        message = self._message_class()
        fill_point_distances(message, parts, threshold, blocks)
        view.moment.stamp(message)
        view.waiting().tell_geometries(message)
        message.query_stamp = cloud.header.stamp
        return message
