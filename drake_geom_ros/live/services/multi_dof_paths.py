"""A MultiDOFJointTrajectory of a request as values of planar and floating joints, and of frames.

A joint has a value for each of its directions, such as ``joint/x`` and ``joint/theta``, a frame
those of a floating joint. Between two points all of them go straight.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.message_types import MultiDofTrajectoryMessage
from drake_geom_ros.live.conversions.names import UnknownNameError, shortened, some_of
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.multi_dof_joints import (
    TURNS,
    MultiDofJoint,
    multi_dof_joints,
)
from drake_geom_ros.live.services.joint_paths import POINTS, PathOfJoints, PathPoint
from drake_geom_ros.live.services.moved_frames import MovedFrame, moved_frame, nearest_turns


class MultiDofPath(NamedTuple):
    """Values of joints, and after them those of frames."""

    path: PathOfJoints
    frames: list[MovedFrame]

    @property
    def joint_names(self) -> list[str]:
        """The names of its values but those of frames."""
        return self.path.joint_names[: len(self.path.joint_names) - 6 * len(self.frames)]


def multi_dof_path(
    live: LiveScene, message: MultiDofTrajectoryMessage, profile: str = ''
) -> MultiDofPath:
    """Return the values of a MultiDOFJointTrajectory; raises ArgumentError for what is none.

    A name is a planar or floating joint, a virtual joint of an SRDF, or a frame. Velocities and
    accelerations are refused, for nobody follows them here, unless the ``profile`` is that of
    straight ways.
    """
    if not message.joint_names and not message.points:
        return MultiDofPath(PathOfJoints([], []), [])
    with live.reading() as scene:
        every = multi_dof_joints(scene.model.joints)
        named = [_named(every, scene, name, message) for name in message.joint_names]
    frames = [each for each in named if isinstance(each, MovedFrame)]
    order = sorted(range(len(named)), key=lambda k: isinstance(named[k], MovedFrame))
    columns = [column for k in order for column in named[k].columns]
    if len(set(columns)) < len(columns) or len({f.frame for f in frames}) < len(frames):
        raise ArgumentError(f'multi_dof_path names a joint twice: {some_of(columns)}')
    turns = np.array([name.rsplit('/', 1)[1] in TURNS for name in columns])
    rows = np.zeros((len(message.points), len(columns)))
    before = np.full(len(columns), np.nan)
    if frames:
        before[-6 * len(frames) :] = np.concatenate([each.now for each in frames])
    for number, point in enumerate(message.points):
        if len(point.transforms) != len(named):
            raise ArgumentError(
                f'point {number} of multi_dof_path has {len(point.transforms)} transforms for '
                f'{len(named)} joints; it must have one for each'
            )
        if profile != POINTS:
            _refuse_derivatives(number, point)
        place = f'point {number} of multi_dof_path'
        joints = (each.joint if isinstance(each, MovedFrame) else each for each in named)
        values = [j.values(X, place) for j, X in zip(joints, point.transforms, strict=True)]
        row = np.concatenate([values[k] for k in order])
        before = rows[number] = nearest_turns(row, before, turns)
    several = zip(rows.tolist(), message.points, strict=True)
    points = [PathPoint(q, [], [], p.time_from_start) for q, p in several]
    return MultiDofPath(PathOfJoints(columns, points), frames)


def _refuse_derivatives(number: int, point: Any) -> None:
    """Raise ArgumentError for a point with velocities or accelerations."""
    for name in ('velocities', 'accelerations'):
        if len(getattr(point, name)):
            raise ArgumentError(
                f'point {number} of multi_dof_path has {name}, which are not followed: joints of '
                'several values and frames go straight from point to point. Leave them out, or '
                f'give the profile {POINTS!r} to say so'
            )


def _named(
    joints: list[MultiDofJoint], scene: HeldScene, name: str, message: MultiDofTrajectoryMessage
) -> MultiDofJoint | MovedFrame:
    """Return the joint or the frame that a name means."""
    matches = [j for j in joints if name in (j.name, j.full_name)]
    if len(matches) == 1:
        return matches[0]
    try:
        return moved_frame(scene, name, message.header.frame_id)
    except UnknownNameError as error:
        raise ArgumentError(
            f'multi_dof_path names {shortened(name)!r}, which is {len(matches)} planar or '
            'floating joints of the scene, and no frame; joints are: '
            f'{some_of([j.full_name for j in joints]) or "none"}. {error}'
        ) from error
