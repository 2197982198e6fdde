"""Faults of the senders of poses and of their clocks, in words."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.live.conversions.names import NameTable, some_of
from drake_geom_ros.live.scene.robot_joints import RobotJoints
from drake_geom_ros.live.scene.senders import Senders


def sender_troubles(senders: Senders, joints: RobotJoints, names: NameTable) -> list[str]:
    """Return what two senders send in turn."""
    robots = joints.robots
    by_joints = [
        robots[robot].full_names[column]
        for robot, column in senders.contested_joints()
        if robot in robots and column < len(robots[robot].full_names)
    ]
    by_poses = _names(names, senders.contested_poses())
    return [
        f'{counted(len(some), kind)} {are(len(some))} sent by two senders in turn, and the last '
        f'one counts: {some_of(some)}; stop one of the two: see ros2 topic info -v {topic}'
        for some, kind, topic in (
            (by_joints, 'joint', 'joint_states'),
            (by_poses, 'frame pose', '~/frame_poses'),
            (senders.contested_transforms(), 'transform', '/tf'),
        )
        if some
    ]


def clock_troubles(offsets: Mapping[int, float], names: NameTable) -> list[str]:
    """Return which frames have stamps of another clock; ``offsets`` [s] by values of ids."""
    troubles = []
    for side, frames in (
        ('before', {f: s for f, s in offsets.items() if s > 0.0}),
        ('after', {f: -s for f, s in offsets.items() if s < 0.0}),
    ):
        if frames:
            most = max(frames.values())
            troubles.append(
                f'the poses of {counted(len(frames), "frame")} bear stamps of another clock, up '
                f'to {most:.1f} s {side} the time of the node, so they count as '
                f'{"that old" if side == "before" else "of unknown age"}: '
                f'{some_of(_names(names, frames))}; synchronise the clocks, or set use_sim_time '
                'for a recording'
            )
    return troubles


def _names(names: NameTable, frames: Collection[int]) -> list[str]:
    return [name for frame, name in names.frame_names.items() if frame.get_value() in frames]
