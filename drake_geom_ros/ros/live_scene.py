"""The one live scene of a node: model, poses with their age, names, leases of filters.

No ROS here: times are plain seconds, messages any objects with the right fields.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from drake_geom_ros.geometry import (
    FilterId,
    FramePoseVector,
    QueryObject,
    SceneGraph,
    SceneGraphInspector,
)
from drake_geom_ros.ros.conversions import FramePosesReader
from drake_geom_ros.ros.names import NameTable
from drake_geom_ros.scene_files import RobotDescription, load_scene, save_scene


class LiveScene:
    """A SceneGraph and a context that shares its model, and what a node must know besides."""

    def __init__(self, accuracy: str, now: Callable[[], float]) -> None:
        """``now`` [s] is the clock that ages of poses and leases of filters are measured by."""
        self._accuracy = accuracy
        self._now = now
        self._version_base = 0
        self._leases: dict[FilterId, float] = {}
        self._adopt(SceneGraph(accuracy=accuracy))

    def _adopt(self, scene_graph: SceneGraph) -> None:
        """Make ``scene_graph`` the scene; every frame in it still waits for its first pose."""
        self.scene_graph = scene_graph
        self.context = scene_graph.CreateSharedContext()
        self._named_version = -1
        self._posed_at: dict[int, float] = {}
        self._leases.clear()
        self._robots: list[RobotDescription] = []
        self.newest_stamp: Any = None

    def replace(self, scene_graph: SceneGraph) -> None:
        """Put another scene in the place of this one; versions go on growing."""
        self._version_base = self.version + 1
        self._adopt(scene_graph)

    def load(
        self,
        path_or_text: str,
        format: str = '',
        srdf: str = '',
        *,
        replace: bool = False,
    ) -> tuple[int, int]:
        """Load a scene file, or its text, whole or not at all; return frames, geometries added.

        Frames stand where the file puts them until their first pose comes.
        """
        scene_graph = SceneGraph(accuracy=self._accuracy) if replace else self.scene_graph
        loaded = load_scene(path_or_text, scene_graph, format, srdf)
        if replace:
            self.replace(scene_graph)
        self.context.UpdateFramePoses(FramePoseVector(loaded.X_PFs))
        self._robots += loaded.robots.values()
        return len(loaded.frames), len(loaded.geometry_ids)

    def save(self) -> str:
        """Return the scene as YAML: persistent filters included, every frame where it is now."""
        query = self.query
        X_PFs = {
            frame: query.X_PF(frame)
            for frame in self.inspector.GetAllFrameIds()
            if frame != self.inspector.world_frame_id()
        }
        return save_scene(self.scene_graph, X_PFs, self._robots)

    def clear(self) -> None:
        """Forget the scene."""
        self.replace(SceneGraph(accuracy=self._accuracy))

    def set_accuracy(self, accuracy: str) -> None:
        """Set the accuracy level of queries that name none."""
        self._accuracy = accuracy
        self.scene_graph.set_default_accuracy(accuracy)
        self.context.set_default_accuracy(accuracy)

    @property
    def version(self) -> int:
        """The version of the scene: it grows with every change of sources, frames, geometries."""
        return self._version_base + self.scene_graph.model_version()

    @property
    def inspector(self) -> SceneGraphInspector:
        """The inspector of the scene."""
        return self.scene_graph.model_inspector()

    @property
    def query(self) -> QueryObject:
        """The live query object."""
        return self.scene_graph.get_query_output_port().Eval(self.context)

    @property
    def names(self) -> NameTable:
        """The names of this version of the scene."""
        self._refresh()
        return self._names

    def _refresh(self) -> None:
        if self._named_version != self.version:
            self._names = NameTable(self.inspector)
            self._reader = FramePosesReader(self._names)
            self._named_version = self.version

    def take_poses(self, message: Any) -> int:
        """Take a FramePoses message whole, or raise RuntimeError and take nothing of it.

        Returns how many frames it posed.
        """
        self._refresh()
        poses = self._reader.read(message)
        self.context.UpdateFramePoses(poses)
        now = self._now()
        self._posed_at.update(dict.fromkeys(poses.id_values().tolist(), now))
        self.newest_stamp = message.header.stamp
        return len(poses)

    def what_if(self, message: Any) -> QueryObject:
        """Return a query object for the poses of a message, the live one when it names none.

        Frames that are not named keep their live poses, and the live scene does not change.
        """
        self._refresh()
        poses = self._reader.read(message)
        if not len(poses):
            return self.query
        context = self.context.what_if()
        context.UpdateFramePoses(poses)
        return QueryObject(context)

    def pose_ages(self) -> dict[str, float]:
        """Return the age [s] of the pose of every frame by name; inf for one never posed."""
        posed, now = self._posed_at, self._now()
        return {
            name: now - posed.get(frame.get_value(), -math.inf)
            for frame, name in self.names.frame_names.items()
            if '::' in name
        }

    def oldest_pose_age(self) -> float:
        """Return the age [s] of the oldest frame pose; inf when a frame was never posed."""
        frames = len(self.names.frame_names) - 1
        if not frames:
            return 0.0
        if len(self._posed_at) < frames:
            return math.inf
        return self._now() - float(np.min(list(self._posed_at.values())))

    def lease(self, filter_id: FilterId, seconds: float) -> None:
        """Let a transient filter vanish after ``seconds``; 0: it stays."""
        if seconds > 0.0:
            self._leases[filter_id] = self._now() + seconds
        else:
            self._leases.pop(filter_id, None)

    def expire_filters(self) -> list[FilterId]:
        """Remove the transient filters whose lease ran out; return them."""
        now = self._now()
        expired = [f for f, end in self._leases.items() if end <= now]
        manager = self.scene_graph.collision_filter_manager()
        for filter_id in expired:
            del self._leases[filter_id]
            manager.RemoveDeclaration(filter_id)
        return expired
