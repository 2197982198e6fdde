"""Joint sliders of a scene's robots, which pose the links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drake_geom_ros.common.frame_names import Frame
from drake_geom_ros.geometry import FrameId, FramePoseVector
from drake_geom_ros.scene_files.description import WORLD
from drake_geom_ros.trajectories.motion import RobotMotion
from drake_geom_ros.trajectories.pose_matrices import poses_of_matrices

# Range of a slider [rad] or [m], in each direction, if the joint has no limit.
_FREE = 2.0 * np.pi


@dataclass(frozen=True)
class JointSlider:
    """A joint of a robot, and the range of its slider: [rad] if it is an angle, otherwise [m]."""

    robot: str
    name: str
    lower: float
    upper: float
    is_angle: bool


class JointSliders:
    """Current joint values of robots, by the names of their sources."""

    def __init__(
        self, robots: Mapping[str, RobotMotion], frames: Mapping[Frame, FrameId], time: float = 0.0
    ) -> None:
        """Start with the values of the robots' motions at ``time`` [s].

        ``frames`` are those of the scene, by source and name.
        """
        self._robots = robots
        self.values = {name: robot.joint_values.value(time) for name, robot in robots.items()}
        self._kept = dict(self.values)
        self._frames = frames
        self._states: Sequence[Mapping[str, float]] = ()
        self._links = {
            name: [k for k, link in enumerate(robot.kinematics.link_names) if link != WORLD]
            for name, robot in robots.items()
        }

    def all(self) -> list[JointSlider]:
        """Return the joints that can be moved."""
        return [
            JointSlider(name, joint, float(max(low, -_FREE)), float(min(high, _FREE)), is_angle)
            for name, robot in self._robots.items()
            for joint, low, high, is_angle in zip(
                *(robot.kinematics.joint_names, robot.kinematics.lower, robot.kinematics.upper),
                robot.kinematics.are_angles,
                strict=True,
            )
            if low < high
        ]

    def keep(self) -> None:
        """Remember the values of now for ``restore``."""
        self._kept = dict(self.values)

    def restore(self) -> None:
        """Take the values that ``keep`` remembered, or those of the beginning; pose no links."""
        self.values = dict(self._kept)

    def value(self, joint: JointSlider) -> float:
        """Return the value [rad] or [m] of a joint."""
        return float(self.values[joint.robot][self._column(joint)])

    def move(self, joint: JointSlider, value: float) -> FramePoseVector:
        """Set a joint, within its limits, and return the poses of its robot's links.

        Raises ValueError for NaN.
        """
        if np.isnan(value):
            raise ValueError(f'{joint.robot}: {joint.name} cannot be set to {value}')
        q = np.array(self.values[joint.robot])
        q[self._column(joint)] = np.clip(value, joint.lower, joint.upper)
        self.values[joint.robot] = q
        return self.poses(joint.robot)

    def take(self, values: Mapping[str, float]) -> None:
        """Set values [rad] or [m] of joints by ``robot::joint``, also beyond their limits.

        This poses no links. Raises KeyError for an unknown joint.
        """
        columns = {
            f'{name}::{joint}': (name, column)
            for name, robot in self._robots.items()
            for column, joint in enumerate(robot.kinematics.joint_names)
        }
        for name, value in values.items():
            robot, column = columns[name]
            q = np.array(self.values[robot])
            q[column] = value
            self.values[robot] = q

    def follow_states(self, states: Sequence[Mapping[str, float]]) -> None:
        """Take the values of states by time, one state each second; see ``take``."""
        self._states = states
        self.follow(0.0)

    def follow(self, time: float) -> None:
        """Take the values of the robots' motions, or of the states, at a time [s]."""
        if self._states:
            self.take(self._states[min(int(time), len(self._states) - 1)])
            return
        for name, robot in self._robots.items():
            self.values[name] = robot.joint_values.value(time)

    def poses(self, robot: str) -> FramePoseVector:
        """Return the poses of a robot's links, whose parent is the world."""
        kinematics, X_WB = self._robots[robot].kinematics, self._robots[robot].X_WB
        X_WLs = kinematics.link_transforms(self.values[robot], X_WB)
        links = self._links[robot]
        ids = [self._frames[robot, kinematics.link_names[k]] for k in links]
        return FramePoseVector.FromArrays(ids, poses_of_matrices(X_WLs[links]))

    def _column(self, joint: JointSlider) -> int:
        return self._robots[joint.robot].kinematics.joint_names.index(joint.name)
