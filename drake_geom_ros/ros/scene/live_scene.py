"""The one live scene of a node: model, poses with their age, names, leases of filters.

No ROS here: times are plain seconds, messages any objects with the right fields.

Several threads meet here. Whoever reads or changes the live scene holds ``lock`` meanwhile;
``view`` takes it for itself and returns a snapshot that needs none.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any

from drake_geom_ros.geometry import (
    ArgumentError,
    Convex,
    FilterId,
    FramePoseVector,
    GeometryId,
    Mesh,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphContext,
    SceneGraphInspector,
    Shape,
    SourceId,
)
from drake_geom_ros.ros.conversions.file_access import ALL_PACKAGES, FileAccess
from drake_geom_ros.ros.conversions.frame_poses import FramePosesReader
from drake_geom_ros.ros.conversions.names import WORLD, NameTable
from drake_geom_ros.ros.scene.scene_view import Moment, SceneView
from drake_geom_ros.scene_files import RobotDescription, SceneDescription, describe, register


class LiveScene:
    """A SceneGraph and a context that shares its model, and what a node must know besides."""

    def __init__(self, accuracy: str, now: Callable[[], float], world_frame: str = WORLD) -> None:
        """``now`` [s] is the clock that ages of poses and leases of filters are measured by."""
        self.lock = threading.RLock()
        self.files = FileAccess([ALL_PACKAGES])
        self.world_frame = world_frame
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

    # The scene as a whole.

    def add(self, description: SceneDescription) -> tuple[int, int]:
        """Register what is described, whole or not at all; return frames, geometries added.

        Frames stand where the description puts them until their first pose comes.
        """
        loaded = register(self.scene_graph, description)
        self.context.UpdateFramePoses(FramePoseVector(loaded.X_PFs))
        self._robots += loaded.robots.values()
        return len(loaded.frames), len(loaded.geometry_ids)

    def replace(self, description: SceneDescription) -> tuple[int, int]:
        """Put another scene in the place of this one, or change nothing; versions go on growing.

        Takes the lock for itself, and only when the other scene is ready to answer.
        """
        scene_graph = SceneGraph(accuracy=self._accuracy)
        loaded = register(scene_graph, description)
        scene_graph.CreateSharedContext().compile_kernels()
        with self.lock:
            scene_graph.set_default_accuracy(self._accuracy)
            self._version_base = self.version + 1
            self._adopt(scene_graph)
            self.context.UpdateFramePoses(FramePoseVector(loaded.X_PFs))
            self._robots += loaded.robots.values()
        return len(loaded.frames), len(loaded.geometry_ids)

    def description(self) -> SceneDescription:
        """Return the scene: persistent filters included, every frame where it is now."""
        query = self.query
        X_PFs = {
            frame: query.X_PF(frame)
            for frame in self.inspector.GetAllFrameIds()
            if frame != self.inspector.world_frame_id()
        }
        return describe(self.scene_graph, X_PFs, self._robots)

    def clear(self) -> None:
        """Forget the scene."""
        self._version_base = self.version + 1
        self._adopt(SceneGraph(accuracy=self._accuracy))

    @property
    def accuracy(self) -> str:
        """The accuracy level of queries that name none."""
        return self._accuracy

    def set_accuracy(self, accuracy: str) -> None:
        """Set the accuracy level of queries that name none."""
        self._accuracy = accuracy
        self.scene_graph.set_default_accuracy(accuracy)
        self.context.set_default_accuracy(accuracy)

    def compile_kernels(self) -> list[str]:
        """Compile what queries of the scene run, beside the cycle; return the kernels."""
        with self.lock:
            context = self.context.what_if()
        return context.compile_kernels()

    def make_ready(self, change: Callable[[SceneGraphContext], object]) -> None:
        """Make a change on a copy of the scene, and what queries need of the changed scene.

        So files are read and kernels compiled beside the cycle, before the change is made in
        earnest: the lock is held only while the scene is copied. Raises what the change raises.
        """
        with self.lock:
            context = self.context.copy()
        change(context)
        context.compile_kernels()

    def calls_for_more(self, shape: Shape, anchored: bool) -> bool:
        """Tell whether queries may have to load or compile something for a shape to come.

        They have not where the scene has such a shape already: it need not be made ready then,
        which for many shapes, one after the other, would cost more than registering them.
        """
        if isinstance(shape, Convex | Mesh):
            return True
        inspector = self.inspector
        world = inspector.world_frame_id()
        return not any(
            type(inspector.GetShape(geometry)) is type(shape)
            and (anchored or inspector.GetFrameId(geometry) != world)
            for geometry in inspector.GetAllGeometryIds(Role.kProximity)
        )

    # Looking at it.

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

    def owned_geometry(self, name: str) -> tuple[SourceId, GeometryId]:
        """Return the source that owns a geometry, and the geometry of that name."""
        geometry = self.names.geometry(name)
        return self.inspector.GetOwningSourceId(geometry), geometry

    def _refresh(self) -> None:
        if self._named_version != self.version:
            self._names = NameTable(self.inspector, self.world_frame)
            self._reader = FramePosesReader(self._names)
            self._named_version = self.version

    def view(self, message: Any = None) -> SceneView:
        """Return the scene of now, with other poses for the frames that a FramePoses names.

        Frames that are not named keep their live poses. Raises RuntimeError for a message that
        ``take_poses`` would refuse.
        """
        with self.lock:
            names = self.names
            poses = None if message is None else self._read(message)
            context = self.context.what_if()
            moment = self.moment()
        if poses is not None and len(poses):
            context.UpdateFramePoses(poses)
        filters = self.scene_graph.collision_filter_manager(context)
        return SceneView(QueryObject(context), filters, names, moment)

    def moment(self) -> Moment:
        """Return which scene and poses an answer of now is for."""
        return Moment(self.version, self.newest_stamp, self.oldest_pose_age(), self.world_frame)

    # Poses.

    def _read(self, message: Any) -> FramePoseVector:
        """Return the poses of a message; raises RuntimeError for what cannot be taken."""
        self._refresh()
        frame_id = message.header.frame_id
        if frame_id not in ('', self.world_frame):
            raise ArgumentError(
                f'header.frame_id is {frame_id[:80]!r}; it must be the world frame, '
                f'{self.world_frame!r}, or empty'
            )
        return self._reader.read(message)

    def take_poses(self, message: Any) -> int:
        """Take a FramePoses message whole, or raise RuntimeError and take nothing of it.

        Returns how many frames it posed.
        """
        poses = self._read(message)
        now = self._now()
        self.pose(poses, dict.fromkeys(poses.id_values().tolist(), now), message.header.stamp)
        return len(poses)

    def pose(self, poses: FramePoseVector, posed_at: dict[int, float], stamp: Any) -> None:
        """Pose frames; ``posed_at`` [s] says since when, by the value of the frame's id."""
        self.context.UpdateFramePoses(poses)
        self._posed_at.update(posed_at)
        self.newest_stamp = stamp

    def pose_ages(self) -> dict[str, float]:
        """Return the age [s] of the pose of every frame by name; inf for one never posed."""
        posed, now = self._posed_at, self._now()
        return {
            name: max(0.0, now - posed.get(frame.get_value(), -math.inf))
            for frame, name in self.names.frame_names.items()
            if frame != self.names.world
        }

    def oldest_pose_age(self) -> float:
        """Return the age [s] of the oldest frame pose; inf when a frame was never posed."""
        frames = len(self.names.frame_names) - 1
        if not frames:
            return 0.0
        if len(self._posed_at) < frames:
            return math.inf
        return max(0.0, self._now() - min(self._posed_at.values()))

    # Leases of transient filters.

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
