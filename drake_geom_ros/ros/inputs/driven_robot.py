"""A robot of the scene that joint values pose: its links, and what is known of its joints.

No ROS import here.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import FrameId
from drake_geom_ros.geometry.queries.joint_trees import JointTree
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.scene.clocks import ALWAYS, Since
from drake_geom_ros.scene_files import WORLD, RobotDescription
from drake_geom_ros.trajectories.kinematics import Kinematics

Floats = NDArray[np.float64]
UNKNOWN = Since(-math.inf, -math.inf, -math.inf)  # of a pose of which nobody knows the age
NANOSECONDS = 1e-9  # [s]


class JointValue(NamedTuple):
    """What was heard of a joint last."""

    position: float  # [rad] or [m]
    speed: float  # [1/s]; nan where nobody knows it
    stamp: int  # [ns]; 0: none
    since: Since


class Base(NamedTuple):
    """Where the root link stands, and since when."""

    X_WB: Floats  # (7,)
    since: Since


class Reposed(NamedTuple):
    """Links that have new poses, by since when these hold."""

    ids: NDArray[np.int64]  # (n,) of their frames
    rows: Floats  # (n, 7) X_WL
    posed: Mapping[frozenset[int], Since]
    X_WLs: Floats  # (m + 1, 7) of all links; those that wait are of no meaning


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
        """``frames`` by source and name; ``values`` by joint are those known already."""
        assert robot.tree is not None
        kinematics = Kinematics(robot.tree)
        self.name = robot.name
        self.topic = robot.joint_states
        self.tree: JointTree = kinematics.tree
        self.joint_names = kinematics.joint_names
        self.lower, self.upper = kinematics.lower, kinematics.upper
        self.columns = {name: k for k, name in enumerate(self.joint_names)}
        # Joints that move nothing by themselves: they are fixed, or mimic another one.
        self.others = {joint.name for joint in robot.tree.joints} - set(self.joint_names)
        self.values = [values.get(name) for name in self.joint_names]
        names = kinematics.link_names
        self.root = None if names[0] == WORLD else frames.get((robot.name, names[0]))
        self.base_is_world = names[0] == WORLD
        self._needs = np.zeros((len(names), len(self.joint_names)), dtype=np.bool_)
        found = self.tree.needs()
        self._needs[:, : found.shape[1]] = found
        ids = [frames.get((robot.name, name)) for name in names]
        # The root is posed by others, and a link called as the world is no frame.
        self._links = {
            k: frame.get_value() for k, frame in enumerate(ids) if frame is not None and k > 0
        }
        self.described_X_WB = robot.X_WB.ToArray()
        self.base: Base | None = None  # that of the poses that were given last
        self._place, self._X_WB = b'', self.described_X_WB

    @cached_property
    def _patterns(self) -> dict[tuple[int, ...], frozenset[int]]:
        """The rows of links that have frames, by the columns that each depends on."""
        rows = defaultdict(set)
        for row in self._links:
            rows[tuple(np.flatnonzero(self._needs[row]).tolist())].add(row)
        return {columns: frozenset(found) for columns, found in rows.items()}

    def pose_of_base(self, X_WB: RigidTransform) -> Floats:
        """Return the pose of the root link as an array (7,), the same one while it rests."""
        place = X_WB.GetAsMatrix34().tobytes()
        if place != self._place:
            self._place, self._X_WB = place, X_WB.ToArray()
        return self._X_WB

    def reposed(self, base: Base, changed: set[int] | None, waiting: set[int]) -> Reposed | None:
        """Return the new poses of links where columns changed, of all where that is None.

        Links that no joint moves have one only where they wait, or the base moved. A link with a
        joint of which nothing was heard has none. None: no link has.
        """
        moved = self.base is not None and base.X_WB.tobytes() != self.base.X_WB.tobytes()
        posed: dict[Since, set[int]] = defaultdict(set)
        for columns, rows in self._patterns.items():
            if columns and changed is not None and changed.isdisjoint(columns):
                continue
            if not columns and not moved:
                rows = frozenset(row for row in rows if self._links[row] in waiting)
            values = [self.values[column] for column in columns]
            known = [value.since for value in values if value is not None]
            if rows and len(known) == len(columns):
                posed[_oldest(base.since, *known)] |= rows
        if not posed:
            return None
        chosen = sorted(set().union(*posed.values()))
        X_WLs = self.tree.link_poses(self._positions()[np.newaxis], base.X_WB)[0]
        frames = {
            frozenset(self._links[row] for row in some): since for since, some in posed.items()
        }
        ids = np.array([self._links[row] for row in chosen], dtype=np.int64)
        return Reposed(ids, X_WLs[chosen], frames, X_WLs)

    def twists(self, X_WLs: Floats, V_WB: Floats) -> dict[int, Floats]:
        """Return V_WL (6,) by frame of the links whose joints' speeds are all known."""
        speeds = np.array([math.nan if v is None else v.speed for v in self.values])
        V_WLs = self.tree.link_twists(np.nan_to_num(speeds), X_WLs, V_WB)
        unknown = (self._needs & np.isnan(speeds)).any(axis=1)
        return {frame: V_WLs[row] for row, frame in self._links.items() if not unknown[row]}

    def without_value(self) -> list[str]:
        """Return the joints of which nothing was heard."""
        return [n for n, v in zip(self.joint_names, self.values, strict=True) if v is None]

    def outside_limits(self) -> list[str]:
        """Return in words which joints stand outside their limits."""
        return [
            f'{self.name}::{name} [{low:.6g}, {high:.6g}]'
            for name, value, low, high in zip(
                self.joint_names, self.values, self.lower, self.upper, strict=True
            )
            if value is not None and not low <= value.position <= high
        ]

    def _positions(self) -> Floats:
        return np.array([0.0 if v is None else v.position for v in self.values])


def _oldest(*moments: Since) -> Since:
    """Return since when all hold that hold since some moments."""
    distinct = set(moments)
    distinct.discard(ALWAYS)
    if len(distinct) < 2:
        return distinct.pop() if distinct else ALWAYS
    return Since(*map(min, zip(*distinct, strict=True)))
