"""A change of the live scene on a copy, with all that cycles need of the changed scene.

What takes long is done here, beside the cycles, which go on with the scene as it was. The live
scene then becomes the draft in a moment: see ``EditableScene.take_over``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from drake_geom_ros.geometry import QueryObject, SceneGraphContext
from drake_geom_ros.live.conversions.frame_poses import FramePosesReader
from drake_geom_ros.live.conversions.names import NameTable
from drake_geom_ros.live.scene.held_scene import HeldScene, attached_in, is_large
from drake_geom_ros.live.scene.robot_joints import RobotJoints
from drake_geom_ros.live.scene.scene_rules import BoundRules
from drake_geom_ros.scene_files import RobotDescription

Tell = Callable[[str, int, int], None]


class Named(NamedTuple):
    """Names of a scene, and the tables that follow from them."""

    names: NameTable
    reader: FramePosesReader
    joints: RobotJoints
    attached: frozenset[int]


class SceneDraft:
    """A copy of the live scene, to be changed and made ready by one thread.

    ``context`` holds the copy. The live scene is held by who makes a draft, and by nobody while it
    is changed and made ready.
    """

    def __init__(self, scene: HeldScene) -> None:
        self.context: SceneGraphContext = scene.copy()
        self.robots = scene.robots
        self.named: Named | None = None  # None: as in the live scene
        self.rules: BoundRules | None = None
        self.is_large = scene.is_large
        self._maps, self._world_frame = scene.maps_source, scene.world_frame
        self._rules, self._joints = scene.rules, scene.joints

    def name_all(self, robots: Iterable[RobotDescription] = ()) -> None:
        """Know what is called how, once the copy was changed and has some ``robots`` more.

        Only shapes may have changed where this is left out.
        """
        inspector = QueryObject(self.context).inspector()
        self.is_large = is_large(inspector)
        there = set(map(inspector.GetName, inspector.GetAllSourceIds()))
        self.robots = [robot for robot in (*self.robots, *robots) if robot.name in there]
        prefixes = {robot.name: robot.frame_prefix for robot in self.robots}
        names = NameTable(inspector, self._world_frame, prefixes, maps=self._maps)
        frames = {label: frame for frame, label in names.labels.items()}
        joints = RobotJoints(self.robots, frames, self._joints)
        _ = joints.entries
        self.named = Named(names, FramePosesReader(names), joints, attached_in(inspector))

    def get_ready(
        self,
        rehearse: Callable[[QueryObject], object] = lambda query: None,
        tell: Tell | None = None,
    ) -> None:
        """Make all that cycles need, once the copy was changed.

        ``rehearse`` asks the queries that cycles ask.
        """
        self.context.compile_kernels(tell)
        query = QueryObject(self.context)
        rehearse(query)
        query.num_waiting_pairs()
        query.waiting_frames()
        if self._rules.rules:
            self.rules = self._rules.prepared(query, same_names=self.named is None)
            rehearse(self.rules.narrowed)
        query.inspector().geometry_version()
        self.context.what_if()  # views of the scene share what this makes
