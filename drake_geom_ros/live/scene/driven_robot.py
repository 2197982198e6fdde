"""A robot of the scene that joint values pose: its links, and what is known of its joints."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.geometry.queries.joint_trees import JointTree
from drake_geom_ros.live.scene.clocks import ALWAYS, UNKNOWN, Since, oldest_of_each
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import WORLD, RobotDescription
from drake_geom_ros.scene_files.jointed_links import SEVERAL, parts_of
from drake_geom_ros.trajectories.kinematics import Kinematics


class JointValue(NamedTuple):
    """The last value of a joint."""

    position: float  # [rad] or [m]
    speed: float  # [1/s]; nan where nobody knows it
    stamp: int  # [ns]; 0: none
    since: Since  # UNKNOWN: nothing was heard, it is the scene file's; ALWAYS: which holds it


class Base(NamedTuple):
    """The pose of the root link in the frame that carries the robot, and since when it holds."""

    X_PB: Floats  # (7,)
    since: Since


class JointEntry(NamedTuple):
    """The entry of a joint in messages."""

    robot: str
    name: str
    type: str  # as in the URDF
    lower: float  # [rad] or [m]
    upper: float
    frame: FrameId | None  # of the link that it moves; None: that link is no frame


class LinkPoses(NamedTuple):
    """Links where joint values put them."""

    ids: NDArray[np.int64]  # (n,) of their frames
    rows: Floats  # (n, 7) X_PL
    X_PLs: Floats  # (m + 1, 7) of all links; those with a joint without a value are meaningless


class DrivenRobot:
    """The joints and links of one robot in one version of a scene, and the values of its joints.

    Raises ValueError for a URDF that is no tree of simple joints.
    """

    def __init__(
        self,
        robot: RobotDescription,
        frames: Mapping[tuple[str, str], FrameId],
        values: Mapping[str, JointValue],
    ) -> None:
        """``frames`` by source and name; ``values`` by joint are those heard already.

        A joint of which nothing was heard stands as the scene file says, if that does.
        """
        assert robot.tree is not None
        kinematics = Kinematics(robot.tree)
        self.name = robot.name
        self.topic = robot.joint_states
        self.tree: JointTree = kinematics.tree
        self.joint_names = kinematics.joint_names
        self.lower, self.upper = kinematics.lower, kinematics.upper
        self.speed_limits: Floats = kinematics.max_speed  # (c,) [1/s]; inf: none
        self.columns = {name: k for k, name in enumerate(self.joint_names)}
        # Joints that move nothing by themselves: they are fixed, or mimic another one.
        self._joints = {p.name: (p, joint) for joint in robot.tree.joints for p in parts_of(joint)}
        joints = {joint.name for joint in robot.tree.joints} | self._joints.keys()
        self.others = joints - set(self.joint_names)
        standing = {
            name: (
                JointValue(value, 0.0, 0, ALWAYS)
                if name in robot.held_joints
                else JointValue(value, math.nan, 0, UNKNOWN)
            )
            for name, value in robot.configuration.items()
        }
        self._held = frozenset(robot.held_joints)
        self.values = [standing.get(name) for name in self.joint_names]
        self.know(values)
        names = kinematics.link_names
        self._frames = {name: frames.get((robot.name, name)) for name in names}
        self.base_is_world = names[0] == WORLD
        self.root = None if self.base_is_world else frames.get((robot.name, names[0]))
        self.root_value = None if self.root is None else self.root.get_value()
        # Rows of all links of the tree: those between the parts of a planar joint have no name.
        self._needs = self.tree.needs(len(self.joint_names))
        ids = [frames.get((robot.name, name)) for name in names]
        # The root is posed by others, and a link called as the world is no frame.
        self.links = {
            k: frame.get_value() for k, frame in enumerate(ids) if frame is not None and k > 0
        }
        self.described_X_PB = robot.X_WB.ToArray()
        self.base: Base | None = None  # that of the poses that were given last
        self._place, self._X_PB = b'', self.described_X_PB

    def know(self, values: Mapping[str, JointValue]) -> None:
        """Have values by joint, of those that are named."""
        rows = zip(self.joint_names, self.values, strict=True)
        self.values = [values.get(name, value) for name, value in rows]

    @property
    def full_names(self) -> list[str]:
        """The joints as ``robot::joint``."""
        return [f'{self.name}::{name}' for name in self.joint_names]

    @cached_property
    def entries(self) -> list[JointEntry]:
        """The entries of the joints in messages."""
        entries = []
        for name, low, high in zip(self.joint_names, self.lower, self.upper, strict=True):
            part, joint = self._joints[name]
            kind = joint.type if joint.type in SEVERAL else part.type
            frame = self._frames[joint.child]
            entries.append(JointEntry(self.name, name, kind, float(low), float(high), frame))
        return entries

    @cached_property
    def patterns(self) -> dict[tuple[int, ...], frozenset[int]]:
        """The rows of links that have frames, by the columns that each depends on."""
        rows = defaultdict(set)
        for row in self.links:
            rows[tuple(np.flatnonzero(self._needs[row]).tolist())].add(row)
        return {columns: frozenset(links) for columns, links in rows.items()}

    def pose_of_base(self, R_PB: Floats, p_PB: Floats) -> Floats:
        """Return the pose of the root link as an array (7,), the same one while it rests."""
        place = R_PB.tobytes() + p_PB.tobytes()
        if place != self._place:
            self._place, self._X_PB = place, RigidTransform(RotationMatrix(R_PB), p_PB).ToArray()
        return self._X_PB

    def positions(self) -> Floats:
        """Return the values (c,) of all joints; nan where nothing was heard."""
        return np.array([math.nan if v is None else v.position for v in self.values])

    def since(self, base: Base, rows: Mapping[tuple[int, ...], frozenset[int]]) -> Moments:
        """Return since when links hold: some rows, by the columns that these depend on.

        Left out are links with a joint of which nothing was heard.
        """
        values = self.values
        heard = [c for c, some in rows.items() if some and all(values[k] for k in c)]
        moments = [(base.since, *(v.since for k in c if (v := values[k]))) for c in heard]
        posed: dict[Since, set[int]] = defaultdict(set)
        for columns, since in zip(heard, oldest_of_each(moments), strict=True):
            posed[since] |= rows[columns]
        return posed

    def frames_since(self, moments: Moments) -> dict[frozenset[int], Since]:
        """Return since when links hold, by their frames; those of unknown age are left out."""
        return {
            frozenset(self.links[row] for row in some): since
            for since, some in moments.items()
            if since != UNKNOWN
        }

    def link_poses(self, base: Base, positions: Floats, rows: Collection[int]) -> LinkPoses:
        """Return where links stand at joint values (c,)."""
        chosen = sorted(rows)
        X_PLs = self.tree.link_poses(or_zero(positions)[np.newaxis], base.X_PB)[0]
        ids = np.array([self.links[row] for row in chosen], dtype=np.int64)
        return LinkPoses(ids, X_PLs[chosen], X_PLs)

    def speeds(self) -> Floats:
        """Return the speeds (c,) of all joints; nan where nobody knows."""
        return np.array([math.nan if v is None else v.speed for v in self.values])

    def twists(self, X_PLs: Floats, V_PB: Floats) -> dict[int, Floats]:
        """Return V_PL (6,) by frame of the links whose joints' speeds are all known."""
        speeds = self.speeds()
        V_PLs = self.tree.link_twists(or_zero(speeds), X_PLs, V_PB)
        unknown = np.any(self._needs & np.isnan(speeds), axis=1).tolist()
        return {frame: V_PLs[row] for row, frame in self.links.items() if not unknown[row]}

    def without_value(self) -> list[str]:
        """Return the joints of which nothing is known."""
        return [n for n, v in zip(self.joint_names, self.values, strict=True) if v is None]

    def unheard(self) -> list[str]:
        """Return the joints that stand as the scene file says, for nothing was heard of them."""
        rows = zip(self.joint_names, self.values, strict=True)
        return [name for name, value in rows if value is not None and value.since == UNKNOWN]

    def held(self) -> list[str]:
        """Return the joints that the scene file holds, and of which nothing was heard."""
        rows = zip(self.joint_names, self.values, strict=True)
        return [name for name, value in rows if value is not None and value.since == ALWAYS]

    def no_longer_held(self) -> list[str]:
        """Return the joints that the scene file holds though values of them were heard."""
        return sorted(self._held.intersection(self.joint_names).difference(self.held()))

    def configuration(self) -> dict[str, float]:
        """Return the values of joints, as far as they are known."""
        rows = zip(self.joint_names, self.values, strict=True)
        return {name: value.position for name, value in rows if value is not None}

    def as_now(self, robot: RobotDescription) -> RobotDescription:
        """Return the description of this robot with the values of its joints of now."""
        return replace(robot, configuration=self.configuration(), held_joints=tuple(self.held()))

    def outside_limits(self) -> list[str]:
        """Return in words which joints stand outside their limits."""
        rows = zip(self.full_names, self.values, self.lower, self.upper, strict=True)
        return [
            f'{name} [{low:.6g}, {high:.6g}]'
            for name, value, low, high in rows
            if value is not None and not low <= value.position <= high
        ]

    def joints_of(self, rows: Collection[int]) -> list[int]:
        """Return the columns that links depend on."""
        return np.flatnonzero(self._needs[sorted(rows)].any(axis=0)).tolist()


Moments = Mapping[Since, Collection[int]]


def or_zero(values: Floats) -> Floats:
    """Return values with 0 for nan: of joints of which nothing was heard, whose links wait."""
    return np.where(np.isnan(values), 0.0, values)
