"""The scene graph of the live scene, and what is kept of its present version."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from drake_geom_ros.geometry import (
    CollisionFilterManager,
    FrameId,
    GeometryId,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
    SceneGraphInspector,
    SourceId,
)
from drake_geom_ros.live.conversions.frame_poses import FramePosesReader
from drake_geom_ros.live.conversions.names import TRACKED, NameTable
from drake_geom_ros.live.scene.robot_joints import RobotJoints
from drake_geom_ros.scene_files import RobotDescription, add_renderers

# Frames and geometries; of 1000 each the tables that a change makes anew take some 50 ms.
_MANY = 1000


class ModelTables(NamedTuple):
    """The names of one version of a scene, and what follows from them. Nobody changes these."""

    names: NameTable
    reader: FramePosesReader
    joints: RobotJoints
    attached: frozenset[int]  # the frames that are attached to others, by the values of their ids

    @classmethod
    def of(
        cls,
        inspector: SceneGraphInspector,
        world_frame: str,
        robots: Sequence[RobotDescription],
        maps_source: SourceId | None,
        before: RobotJoints,
    ) -> ModelTables:
        """Return the tables of a scene; values of joints go on that were known ``before``."""
        prefixes = {robot.name: robot.frame_prefix for robot in robots}
        names = NameTable(inspector, world_frame, prefixes, maps=maps_source)
        frames = {label: frame for frame, label in names.labels.items()}
        joints = RobotJoints(robots, frames, before)
        attached = frozenset(
            frame.get_value()
            for frame in inspector.GetAllFrameIds()
            if inspector.IsAttached(frame)
        )
        return cls(names, FramePosesReader(names), joints, attached)


class SceneModel:
    """The scene graph, a context that shares it, and the tables of this version.

    All attributes are of the present version: the scene is changed by ``HeldScene.make`` alone,
    which calls ``refresh``. A table is replaced and never changed, so one that is kept beyond the
    block in which the scene was held stays what it was.

    - ``version`` grows with every change of sources, frames and geometries. Since
      ``model_version`` at most the cells of sensed maps changed; since ``names_version`` nothing
      came or went, and names and roles are the same.
    - ``robots`` are in the order in which they came. ``maps_source`` is the source of the sensed
      maps, None where there is none.
    """

    scene_graph: SceneGraph
    filter_manager: CollisionFilterManager
    inspector: SceneGraphInspector
    context: SceneGraphContext
    query: QueryObject  # live: it sees later poses
    version: int
    model_version: int
    names_version: int
    names: NameTable
    reader: FramePosesReader
    joints: RobotJoints
    attached: frozenset[int]

    def __init__(self, scene_graph: SceneGraph, world_frame: str, version: int) -> None:
        """``version`` is that of an empty scene."""
        self.world_frame = world_frame
        self.joints = RobotJoints((), {})
        self.adopt(scene_graph, shared_context(scene_graph), version)

    def adopt(
        self,
        scene_graph: SceneGraph,
        context: SceneGraphContext,
        version: int,
        robots: Sequence[RobotDescription] = (),
        maps_source: SourceId | None = None,
        tables: ModelTables | None = None,
    ) -> None:
        """Be about another scene graph, with a context that shares it, from a version on.

        ``tables`` are those of that scene where somebody has made them.
        """
        self.scene_graph, self.context = scene_graph, context
        self.filter_manager = scene_graph.collision_filter_manager()
        self.inspector = scene_graph.model_inspector()
        self.query = scene_graph.get_query_output_port().Eval(context)
        self.robots, self.maps_source = list(robots), maps_source
        self._base, self._cell_changes = version, 0
        self._come_to(tables)

    def take_over(
        self,
        context: SceneGraphContext,
        robots: Sequence[RobotDescription],
        maps_source: SourceId | None,
        tables: ModelTables | None,
    ) -> bool:
        """Become a changed copy; return False where the scene has changed since it was made.

        ``tables`` are those of the copy; None: all but shapes and filters is as it was.
        """
        if not self.scene_graph.TakeOver(context, self.context):
            return False
        self.robots, self.maps_source = list(robots), maps_source
        if tables is None:
            self.refresh(same_content=True)
        else:
            self._come_to(tables)
        return True

    def refresh(self, *, same_content: bool = False) -> None:
        """Have everything be of the scene graph as it is now.

        ``same_content``: at most shapes and filters changed, so that the tables stay.
        """
        version = self._base + self.scene_graph.model_version()
        if version == self.version:
            return
        if same_content:
            self._cell_changes += version - self.version
            self.version = version
        else:
            self._come_to(None)

    def _come_to(self, tables: ModelTables | None) -> None:
        """Come to the version of the scene graph; ``tables`` that are None are made."""
        self.version = self._base + self.scene_graph.model_version()
        self.names_version = self._base + self.scene_graph.names_version()
        self.model_version = self.version - self._cell_changes
        if tables is None:
            tables = ModelTables.of(
                self.inspector, self.world_frame, self.robots, self.maps_source, self.joints
            )
        else:
            tables.joints.go_on_as(self.joints)
        self.names, self.reader, self.joints, self.attached = tables

    @property
    def is_large(self) -> bool:
        """True if making all tables of the scene takes longer than a cycle may wait."""
        return is_large(self.inspector)

    def robot_names(self) -> set[str]:
        """Return the sources of the robots."""
        return {robot.name for robot in self.robots}

    def route_joints(self, robot: str, topic: str) -> None:
        """Have the joints of a robot be those of a topic, and of no other one."""
        self.robots = [
            replace(each, joint_states=topic) if each.name == robot else each
            for each in self.robots
        ]
        if robot in self.joints.robots:
            self.joints.route(robot, topic)

    def owned_geometry(self, name: str) -> tuple[SourceId, GeometryId]:
        """Return the source that owns a geometry, and the geometry of that name."""
        geometry = self.names.geometry(name)
        return self.inspector.GetOwningSourceId(geometry), geometry

    def is_tracked(self, source: SourceId) -> bool:
        """Return whether a source is that of tracked bodies, which has a heartbeat."""
        return self.names.has_heartbeat and self.inspector.GetName(source) == TRACKED

    def is_mounted(self, frame: FrameId) -> bool:
        """Return whether the home of a frame is one of another source."""
        inspector = self.inspector
        home = inspector.GetHomeFrame(frame)
        owner = inspector.GetOwningSourceId(frame)
        return home != self.names.world and owner != inspector.GetOwningSourceId(home)


def shared_context(scene_graph: SceneGraph) -> SceneGraphContext:
    """Return a context for a live scene, whose frames may wait for their first poses."""
    add_renderers(scene_graph)
    return scene_graph.CreateSharedContext(partial=True)


def is_large(inspector: SceneGraphInspector) -> bool:
    """Return whether tables of all that there is take longer than a cycle may wait."""
    return is_many(inspector.num_geometries() + inspector.num_frames())


def is_many(count: int) -> bool:
    """Return whether tables of so many frames and geometries take longer than a cycle may wait."""
    return count > _MANY
