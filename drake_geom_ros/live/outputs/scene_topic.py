"""Publishes ~/scene: the table from ids to names, when it has changed.

Every set of names that an answer refers to is published, in order. A version that none refers to,
or that differs in shapes only, may be passed over for a later one where a large scene changes all
the time.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from drake_geom_ros.common.freeing import free_in_pieces
from drake_geom_ros.geometry import FrameId
from drake_geom_ros.live.conversions.scene import fill_scene
from drake_geom_ros.live.scene.driven_robot import JointEntry
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_view import SceneView

# [-] times what it took to publish pass before it is done again without need: a large scene that
# changes all the time costs a tenth.
_PAUSE = 10.0
_MAP_PAUSE = 1.0  # [s] at least, where nothing but the cells of sensed maps changed
_MOST_WAITING = 32  # sets of names that are kept until there is time to publish them


class SceneTopic:
    """Publishes versions of a live scene once, from views: the cycle does not wait."""

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        types: Any,
        now: Callable[[], Any],
        did: Callable[[int, float], None],
    ) -> None:
        """``types`` holds the message classes, ``now()`` returns a builtin_interfaces/Time.

        ``did(count, seconds)`` is called for each message: how many geometries, how long it took.
        """
        self._did = did
        self._live = live
        self._publisher = publisher
        self._types = types
        self._now = now
        self._lock = threading.Lock()  # one publishes at a time, so that versions ascend
        self._version = self._names = self._noted = self._model = -1
        self._next = self._next_maps = 0.0  # [s] of the steady clock
        self._waiting: deque[SceneView] = deque()
        self._touch_links: Mapping[FrameId, tuple[str, ...]] = {}
        self.unpublished = 0  # sets of names that were referred to and for which there was no room
        with live.editing() as scene:
            scene.tell_named = self._note

    def _note(self, scene: HeldScene) -> None:
        """Keep what an answer refers to until it is published; the scene is held meanwhile."""
        if scene.model.names_version == self._noted:
            return
        self._noted = scene.model.names_version  # first: a view refers to the scene, too
        if len(self._waiting) >= _MOST_WAITING:
            self._waiting.popleft()
            self.unpublished += 1
        self._waiting.append(scene.view())

    def publish(self) -> None:
        """Publish what answers refer to, and the newest version unless it is too early for it."""
        with self._lock:
            while (view := self._next_named()) is not None:
                self._publish(view)
            if (now := time.monotonic()) > self._next:
                with self._live.reading() as scene:
                    model = scene.model.model_version
                    is_same = self._touch_links == scene.filters.touch_links.names()
                    if is_same and self._version == scene.model.version:
                        return
                    if is_same and self._model == model and now < self._next_maps:
                        return
                    view = scene.view()
                self._publish(view)
                self._model, self._next_maps = model, now + _MAP_PAUSE

    def _next_named(self) -> SceneView | None:
        """Return the next view whose names are not published yet; None where there is none."""
        with self._live.reading():
            while self._waiting:
                view = self._waiting.popleft()
                if view.moment.names_version > self._names:
                    return view
        return None

    def _publish(self, view: SceneView) -> None:
        start = time.monotonic()
        moment = view.moment
        message = self._types.Scene(
            scene_version=moment.version, names_version=moment.names_version
        )
        message.header.frame_id = moment.world_frame
        message.header.stamp = self._now()
        fill_scene(message, view.query.inspector(), self._types, view.attachments())
        message.joints = [_joint(entry, self._types) for entry in view.joints]
        self._publisher.publish(message)
        self._version, self._names = moment.version, moment.names_version
        self._touch_links = view.touch_links
        now = time.monotonic()
        self._next = now + _PAUSE * (now - start)
        self._did(len(message.geometries), now - start)
        entries = [*message.frames, *message.geometries, *message.joints]
        del message
        free_in_pieces(entries)


def _joint(entry: JointEntry, types: Any) -> Any:
    """Return the SceneJoint message of a joint."""
    return types.SceneJoint(
        robot=entry.robot,
        name=entry.name,
        type=entry.type,
        lower=entry.lower,
        upper=entry.upper,
        frame_id=0 if entry.frame is None else entry.frame.get_value(),
    )
