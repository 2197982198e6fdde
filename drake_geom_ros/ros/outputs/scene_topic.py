"""Publishes ~/scene: the table from ids to names, when it has changed. No ROS import."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from drake_geom_ros.ros.conversions.scene import fill_scene
from drake_geom_ros.ros.scene.live_scene import LiveScene

# [-] times what it took to publish pass before it is done again in a hurry: a large scene that
# changes all the time costs a tenth.
_PAUSE = 10.0


class SceneTopic:
    """Publishes each version of a live scene once, from a view: the cycle does not wait."""

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        types: Any,
        now: Callable[[], Any],
        did: Callable[[int, float], None],
    ) -> None:
        """``types`` holds the message classes, ``now()`` returns a builtin_interfaces/Time.

        ``did(count, seconds)`` is told of each message: how many geometries, how long it took.
        """
        self._did = did
        self._live = live
        self._publisher = publisher
        self._types = types
        self._now = now
        self._version = -1
        self._next = 0.0  # [s] of the steady clock

    def publish_soon(self) -> None:
        """Publish a change at once, unless the one before is not long enough ago."""
        if time.monotonic() > self._next:
            self.publish()

    def publish(self) -> None:
        """Publish the scene when it is not the version that was published last."""
        with self._live.reading() as scene:
            if self._version == scene.version:
                return
        start = time.monotonic()
        view = self._live.view()
        message = self._types.Scene(scene_version=view.moment.version)
        message.header.frame_id = view.moment.world_frame
        message.header.stamp = self._now()
        fill_scene(message, view.query.inspector(), self._types)
        self._publisher.publish(message)
        self._version = view.moment.version
        now = time.monotonic()
        self._next = now + _PAUSE * (now - start)
        self._did(len(message.geometries), now - start)
