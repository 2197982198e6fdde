"""``SceneMark``: detects whether a scene has changed since something was prepared from it."""

from __future__ import annotations

import threading

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.model.scene_content import SceneHolder, content_of
from drake_geom_ros.geometry.queries.posed_scene import PosedScene
from drake_geom_ros.math.array_types import Indices


class SceneMark:
    """State of a scene that answers depend on, apart from the poses of the queried states.

    That is its content, its filters, and the poses of the frames that no state poses.
    ``frame_ids`` (n,) are id values of the frames that states pose.
    """

    def __init__(self, scene: SceneHolder, frame_ids: Indices) -> None:
        self._content, self._frame_ids = content_of(scene), frame_ids
        self._lock = threading.Lock()
        self._posed = self._content if isinstance(self._content, PosedScene) else None
        if self._posed is not None:
            world = self._posed.up_to_date_world()
            world.update()  # so that a query changes no revision
            self._still = self._poses(world)
        self._seen = self._now()
        self._pose_holder = self._place()  # a reference, so that no other object gets its id

    def is_of_now(self) -> bool:
        """Return whether the scene is unchanged; setting equal poses again is no change."""
        if self._now() == self._seen:
            return True
        with self._lock:
            return self._looks_the_same()

    def _looks_the_same(self) -> bool:
        now, seen = self._now(), self._seen
        if self._posed is None or now[:3] != seen[:3]:
            return False
        world = self._posed.up_to_date_world()
        if not np.array_equal(self._poses(world), self._still):
            return False
        world.update()
        self._seen, self._pose_holder = self._now(), self._place()
        return True

    def _now(self) -> tuple[object, ...]:
        """Return values that differ after a possible change, the first three after a sure one."""
        model, filters = self._content.model, self._content.filters
        versions = (model.versions.frames, model.versions.proximity, filters.version)
        place = id(self._place())
        if self._posed is None:
            return *versions, place
        world = self._posed.world
        return *versions, place, world.revision, world.is_stale

    def _place(self) -> object:
        """Return the holder of the poses, another object if they may have changed."""
        if self._posed is None:
            return self._content.model.first_X_PFs
        return self._posed.world

    def _poses(self, world: World) -> NDArray[np.float64]:
        """Return the poses (k, 12) of the frames that no state poses."""
        others = ~np.isin(world.frames.ids, self._frame_ids)
        return np.hstack((world.R_PFs[others].reshape(-1, 9), world.p_PFs[others]))
