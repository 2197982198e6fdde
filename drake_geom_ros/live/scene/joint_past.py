"""The values of the joints of a robot in the last seconds, and where its links were.

Base and joints are received at times of their own: the links of a time are those of the base and
of each joint of that very time, and not of what came last of each by then.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from drake_geom_ros.live.scene.driven_robot import DrivenRobot, or_zero
from drake_geom_ros.live.scene.pose_history import PoseThen, Then
from drake_geom_ros.live.scene.tracks import Bracket, Track, UnknownThenError
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files.jointed_links import SEVERAL


class JointPast:
    """Past values of the joints of a robot by name: the parts of the poses of its links."""

    def __init__(self, robot: DrivenRobot, before: JointPast | None = None) -> None:
        """``before`` is that of the same robot in an earlier version of the scene."""
        self._robot = robot
        tracks = {} if before is None else before._tracks
        self._tracks: dict[str, Track[float]] = {
            name: tracks.get(name) or Track() for name in robot.joint_names
        }

    def note(self, columns: Collection[int]) -> None:
        """Keep the values that some joints have now."""
        robot = self._robot
        for column in columns:
            if (value := robot.values[column]) is not None:
                self._tracks[robot.joint_names[column]].note(value.position, value.since)

    def frames(self) -> Collection[int]:
        """Return the frames of the links, by the values of their ids."""
        return self._robot.links.values()

    def around(self, time: float) -> PoseThen:
        """Return the poses of links at a time [s]."""
        robot = self._robot
        brackets = [self._tracks[name].around(time) for name in robot.joint_names]
        rows = {frame: row for row, frame in robot.links.items()}
        links: list[Floats] = []

        def pose(frame: int, then: Then) -> Floats:
            for column in robot.joints_of([rows[frame]]):
                _position(robot.entries[column].type, brackets[column])
            if not links:
                types = [entry.type for entry in robot.entries]
                values = [_or_nan(t, b) for t, b in zip(types, brackets, strict=True)]
                positions = or_zero(np.array(values))[np.newaxis]
                links.append(robot.tree.link_poses(positions, _base(robot, then))[0])
            row: Floats = links[0][rows[frame]]
            return row

        return pose


class LinksPast:
    """The past of all links of several robots: the parts of poses that came in one message."""

    def __init__(self, pasts: Mapping[str, JointPast]) -> None:
        """``pasts`` are by robot; those that are added later count, too."""
        self._pasts = pasts

    def around(self, time: float) -> PoseThen:
        """Return the poses of links at a time [s]."""
        poses: dict[int, PoseThen] = {}
        for past in self._pasts.values():
            poses.update(dict.fromkeys(past.frames(), past.around(time)))
        return lambda frame, then: poses[frame](frame, then)


def _position(joint: str, bracket: Bracket[float]) -> float:
    """Return the value of a joint of some type; raises UnknownThenError."""
    first, last, share = bracket.between()
    way = last - first
    if joint == 'continuous':
        way = math.remainder(way, math.tau)  # by the shorter way round
    elif joint in SEVERAL and abs(way) > math.pi:
        raise UnknownThenError(is_later=False)  # angles go round, and who tells that from a way?
    return first + share * way


def _or_nan(joint: str, bracket: Bracket[float]) -> float:
    try:
        return _position(joint, bracket)
    except UnknownThenError:
        return math.nan


def _base(robot: DrivenRobot, then: Then) -> Floats:
    """Return where the root link was in what carries the robot, as ``RobotJoints.base``."""
    root = robot.root
    if root is None:
        return robot.described_X_PB
    home = then.inspector.GetHomeFrame(root)
    if home == then.inspector.GetParentFrame(root):
        return then.X_PF(root).ToArray()
    return then.X_WF(home).InvertAndCompose(then.X_WF(root)).ToArray()  # attached
