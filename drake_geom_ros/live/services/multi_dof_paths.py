"""A MultiDOFJointTrajectory of a request as values of planar and floating joints.

Such a joint has a value for each of its directions, such as ``joint/x`` and ``joint/theta``.
Between two points all of them go straight.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.multi_dof_joints import (
    TURNS,
    MultiDofJoint,
    multi_dof_joints,
)
from drake_geom_ros.live.services.joint_paths import POINTS, PathOfJoints, PathPoint


def multi_dof_path(live: LiveScene, message: Any, profile: str = '') -> PathOfJoints:
    """Return the values of a MultiDOFJointTrajectory; raises ArgumentError for what is none.

    So it does for velocities and accelerations, which nobody follows here, unless the ``profile``
    is that of straight ways.
    """
    with live.reading() as scene:
        every = multi_dof_joints(scene.model.joints)
    joints = [_named(every, name) for name in message.joint_names]
    columns = [column for joint in joints for column in joint.columns]
    if len(set(columns)) < len(columns):
        raise ArgumentError(f'multi_dof_path names a joint twice: {some_of(columns)}')
    turns = np.array([name.rsplit('/', 1)[1] in TURNS for name in columns])
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
        rows[number] = np.concatenate(
            [each.values(X, f'point {number} of multi_dof_path') for each, X in pairs]
        )
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


def _named(joints: list[MultiDofJoint], name: str) -> MultiDofJoint:
    matches = [j for j in joints if name in (j.name, j.full_name)]
    if len(matches) != 1:
        raise ArgumentError(
            f'multi_dof_path names {shortened(name)!r}, which is {len(matches)} planar or '
            'floating joints of the scene; there are: '
            f'{some_of([j.full_name for j in joints]) or "none"}'
        )
    return matches[0]
