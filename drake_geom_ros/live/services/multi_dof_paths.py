"""A MultiDOFJointTrajectory of a request as values of planar and floating joints.

Such a joint has a value for each of its directions, such as ``joint/x`` and ``joint/theta``.
Between two points all of them go straight.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.robot_joints import RobotJoints
from drake_geom_ros.live.services.joint_paths import POINTS, PathOfJoints, PathPoint
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import OUT_OF_PLANE

_DIRECTIONS = {
    'planar': ('x', 'y', 'theta'),
    'floating': ('x', 'y', 'z', 'yaw', 'pitch', 'roll'),
}
_TURNS = ('theta', 'yaw', 'pitch', 'roll')


class _Joint(NamedTuple):
    """A joint of several values."""

    robot: str
    name: str
    type: str
    R_JA: Floats  # (3, 3) axes of a planar joint: of x, y and theta

    @property
    def columns(self) -> list[str]:
        """The names of its values, as those of joints."""
        return [f'{self.robot}::{self.name}/{each}' for each in _DIRECTIONS[self.type]]


def multi_dof_path(live: LiveScene, message: Any, profile: str = '') -> PathOfJoints:
    """Return the values of a MultiDOFJointTrajectory; raises ArgumentError for what is none.

    So it does for velocities and accelerations, which nobody follows here, unless the ``profile``
    is that of straight ways.
    """
    with live.reading() as scene:
        every = _joints_of(scene.model.joints)
    joints = [_named(every, name) for name in message.joint_names]
    columns = [column for joint in joints for column in joint.columns]
    if len(set(columns)) < len(columns):
        raise ArgumentError(f'multi_dof_path names a joint twice: {some_of(columns)}')
    turns = np.array([name.rsplit('/', 1)[1] in _TURNS for name in columns])
    rows = np.zeros((len(message.points), len(columns)))
    for number, point in enumerate(message.points):
        if len(point.transforms) != len(joints):
            raise ArgumentError(
                f'point {number} of multi_dof_path has {len(point.transforms)} transforms for '
                f'{len(joints)} joints; it must have one for each'
            )
        if profile != POINTS:
            _refuse_derivatives(number, point)
        pairs = zip(joints, point.transforms, strict=True)
        rows[number] = np.concatenate([_values(each, X, number) for each, X in pairs])
        if number:  # by the shorter way
            steps = (rows[number] - rows[number - 1])[turns]
            rows[number, turns] -= 2.0 * math.pi * np.round(steps / (2.0 * math.pi))
    values = zip(rows.tolist(), message.points, strict=True)
    return PathOfJoints(columns, [PathPoint(q, [], [], p.time_from_start) for q, p in values])


def _refuse_derivatives(number: int, point: Any) -> None:
    """Raise ArgumentError for a point with velocities or accelerations."""
    for name in ('velocities', 'accelerations'):
        if len(getattr(point, name)):
            raise ArgumentError(
                f'point {number} of multi_dof_path has {name}, which are not followed: joints of '
                'several values and frames go straight from point to point. Leave them out, or '
                f'give the profile {POINTS!r} to say so'
            )


def _joints_of(robots: RobotJoints) -> list[_Joint]:
    """Return all planar and floating joints."""
    joints = []
    for robot in robots.robots.values():
        axes = {int(leader): robot.tree.axes[j] for j, leader in enumerate(robot.tree.leaders)}
        for column, entry in enumerate(robot.entries):
            name, _, direction = entry.name.rpartition('/')
            if entry.type in _DIRECTIONS and direction == 'x':
                R_JA = np.column_stack([axes[column + k] for k in range(3)])
                joints.append(_Joint(robot.name, name, entry.type, R_JA))
    return joints


def _named(joints: list[_Joint], name: str) -> _Joint:
    matches = [j for j in joints if name in (j.name, f'{j.robot}::{j.name}')]
    if len(matches) != 1:
        raise ArgumentError(
            f'multi_dof_path names {shortened(name)!r}, which is {len(matches)} planar or '
            'floating joints of the scene; there are: '
            f'{some_of([f"{j.robot}::{j.name}" for j in joints]) or "none"}'
        )
    return matches[0]


def _values(joint: _Joint, message: Any, number: int) -> Floats:
    """Return the values of a joint at a geometry_msgs/Transform of its child link."""
    p, q = message.translation, message.rotation
    try:
        X_JC = RigidTransform.FromArray([p.x, p.y, p.z, q.x, q.y, q.z, q.w])
    except RuntimeError as error:
        raise ArgumentError(
            f'point {number} of multi_dof_path, joint {joint.name!r}: {error}'
        ) from None
    if joint.type == 'floating':
        roll, pitch, yaw = RollPitchYaw(X_JC.rotation()).vector().tolist()
        return np.array([*X_JC.translation(), yaw, pitch, roll])
    x, y, away = joint.R_JA.T @ X_JC.translation()
    R = joint.R_JA.T @ X_JC.rotation().matrix() @ joint.R_JA
    if abs(away) > OUT_OF_PLANE or np.abs(R[2, :2]).max() > OUT_OF_PLANE:
        raise ArgumentError(
            f'point {number} of multi_dof_path takes the planar joint {joint.name!r} out of its '
            'plane'
        )
    return np.array([x, y, math.atan2(R[1, 0], R[0, 0])])
