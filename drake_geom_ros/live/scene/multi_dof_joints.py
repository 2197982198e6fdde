"""Planar and floating joints: their values at a transform of their child link.

Such a joint has a value for each of its directions, such as ``joint/x`` and ``joint/theta``.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.scene.robot_joints import RobotJoints
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import OUT_OF_PLANE

_DIRECTIONS = {
    'planar': ('x', 'y', 'theta'),
    'floating': ('x', 'y', 'z', 'yaw', 'pitch', 'roll'),
}
TURNS = ('theta', 'yaw', 'pitch', 'roll')


class MultiDofJoint(NamedTuple):
    """A joint of several values."""

    robot: str
    name: str
    type: str
    R_JA: Floats  # (3, 3) axes of a planar joint: of x, y and theta

    @property
    def full_name(self) -> str:
        """The joint as ``robot::joint``."""
        return f'{self.robot}::{self.name}'

    @property
    def columns(self) -> list[str]:
        """The names of its values, as those of joints."""
        return [f'{self.full_name}/{each}' for each in _DIRECTIONS[self.type]]

    def values(self, message: Any, place: str) -> Floats:
        """Return the values at a geometry_msgs/Transform of the child link.

        Raises ArgumentError, which begins with ``place``, for one that the joint cannot reach.
        """
        p, q = message.translation, message.rotation
        try:
            X_JC = RigidTransform.FromArray([p.x, p.y, p.z, q.x, q.y, q.z, q.w])
        except RuntimeError as error:
            raise ArgumentError(f'{place}, joint {self.name!r}: {error}') from None
        return self.values_of(X_JC, place)

    def values_of(self, X_JC: RigidTransform, place: str) -> Floats:
        """Return the values at a pose of the child link; raises as ``values``."""
        if self.type == 'floating':
            roll, pitch, yaw = RollPitchYaw(X_JC.rotation()).vector().tolist()
            return np.array([*X_JC.translation(), yaw, pitch, roll])
        x, y, away = self.R_JA.T @ X_JC.translation()
        R = self.R_JA.T @ X_JC.rotation().matrix() @ self.R_JA
        if abs(away) > OUT_OF_PLANE or np.abs(R[2, :2]).max() > OUT_OF_PLANE:
            raise ArgumentError(f'{place} takes the planar joint {self.name!r} out of its plane')
        return np.array([x, y, math.atan2(R[1, 0], R[0, 0])])


def multi_dof_joints(robots: RobotJoints) -> list[MultiDofJoint]:
    """Return all planar and floating joints."""
    joints = []
    for robot in robots.robots.values():
        axes = {int(leader): robot.tree.axes[j] for j, leader in enumerate(robot.tree.leaders)}
        for column, entry in enumerate(robot.entries):
            name, _, direction = entry.name.rpartition('/')
            if entry.type in _DIRECTIONS and direction == 'x':
                R_JA = np.column_stack([axes[column + k] for k in range(3)])
                joints.append(MultiDofJoint(robot.name, name, entry.type, R_JA))
    return joints
