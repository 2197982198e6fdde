"""Frames that a path moves: each as a link behind a floating joint, with its robot if it has one.

The values of such a joint are those of a floating joint of a URDF, x y z yaw pitch roll, and say
where the frame is in its parent.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.batch.joints import Arm
from drake_geom_ros.geometry import ArgumentError, FrameId
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.scene.driven_robot import DrivenRobot, or_zero
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.multi_dof_joints import MultiDofJoint
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.trajectories.kinematics import Kinematics

_PLACE = '<place>'  # the link and the joint in front of a frame, which no file has
_AXIS = 1.0, 0.0, 0.0


class MovedFrame(NamedTuple):
    """A frame that a path moves; ``robot`` is that whose root link it is, empty for none."""

    name: str
    frame: FrameId
    robot: str
    now: Floats  # (6,) values of now; NaN while it waits

    @property
    def joint(self) -> MultiDofJoint:
        """The joint in front of it, with the names of its values."""
        return MultiDofJoint('', self.name, 'floating', np.eye(3))

    @property
    def columns(self) -> list[str]:
        """The names of its values."""
        return [f'{self.name}/{each.rpartition("/")[2]}' for each in self.joint.columns]


class MovedArm(NamedTuple):
    """A frame with what hangs on it by joints, and the frames (values of ids) that it poses."""

    arm: Arm
    ids: list[int]


def moved_frame(scene: HeldScene, name: str, header_frame: str) -> MovedFrame:
    """Return the frame that a path calls so, by its name or by the virtual joint of its robot.

    ``header_frame`` is what its poses are measured in: empty, or its parent. Raises ArgumentError
    for a frame that cannot be moved so.
    """
    names, inspector = scene.model.names, scene.model.inspector
    frame = root_by_virtual_joint(scene, name) or names.frame(name)
    if frame == names.world:
        raise ArgumentError(f'multi_dof_path moves {shortened(name)!r}, which is the world')
    source, _ = names.labels[frame]
    robots = scene.model.joints.robots
    robot = robots.get(source)
    if robot is not None and frame != robot.root:
        raise ArgumentError(
            f'multi_dof_path moves {shortened(name)!r}, a link that joints of {source!r} move: '
            'name these, or its root link'
        )
    parent = inspector.GetParentFrame(frame)
    if inspector.IsAttached(frame):
        raise ArgumentError(
            f'multi_dof_path moves {shortened(name)!r}, which is attached to '
            f'{names.frame_names[parent]}: move that'
        )
    called = {'', names.frame_names[parent], names.labels.get(parent, ('', ''))[1]}
    if parent == names.world:
        called.add(scene.model.world_frame)
    if header_frame.removeprefix('/') not in called:
        raise ArgumentError(
            f'multi_dof_path has the frame_id {shortened(header_frame)!r}; the poses of '
            f'{shortened(name)!r} are those in its parent, {names.frame_names[parent]}'
        )
    moved = [frame] if robot is None else [frame, *map(FrameId, robot.links.values())]
    welded = scene.model.filter_manager.welded_frames()
    if still := [names.frame_names[each] for each in moved if each in welded]:
        raise ArgumentError(
            f'multi_dof_path moves {shortened(name)!r}, and {some_of(still)} is welded to the '
            'world: pairs with what is anchored would be left out'
        )
    now = np.full(6, np.nan)
    if scene.query.is_placed(frame):
        now = values_at(scene.query.X_PF(frame))
    return MovedFrame(name, frame, '' if robot is None else source, now)


def values_at(X_PF: RigidTransform) -> Floats:
    """Return the values of a floating joint at a pose of its child."""
    return MultiDofJoint('', '', 'floating', np.eye(3)).values_of(X_PF, '')


def root_by_virtual_joint(scene: HeldScene, name: str) -> FrameId | None:
    """Return the root link of the one robot whose SRDF has a virtual joint of that name."""
    robots = scene.model.joints.robots
    roots = [
        robots[each.name].root
        for each in scene.model.robots
        if name in each.virtual_joints and each.name in robots
    ]
    return roots[0] if len(roots) == 1 else None


def lone_arm(moved: MovedFrame, first: int) -> MovedArm:
    """Return a frame without a robot, whose values are in the columns from ``first`` on."""
    joint = _floating(moved.name)
    kinematics = Kinematics(LinkTree(moved.name, (_PLACE, moved.name), (joint,)))
    tree = kinematics.tree.driven_by(first + np.arange(6), np.zeros(6))
    arm = Arm(tree, RigidTransform().ToArray(), np.array([1], dtype=np.int64))
    return MovedArm(arm, [moved.frame.get_value()])


def arm_on(
    moved: MovedFrame,
    first: int,
    robot: DrivenRobot,
    tree: LinkTree,
    columns: Indices,
    now: Floats,
    frames: Mapping[tuple[str, str], FrameId],
) -> MovedArm:
    """Return a robot on its root link, which a path moves.

    ``columns`` (c,) are those of its joints, -1 where they stay as they are ``now`` (c,).
    """
    root = next(link for (source, link), f in frames.items() if f == moved.frame)
    joints = (_floating(root), *tree.joints)
    kinematics = Kinematics(LinkTree(tree.name, (_PLACE, *tree.links), joints))
    own = dict(zip(robot.joint_names, columns.tolist(), strict=True))
    rest = dict(zip(robot.joint_names, or_zero(now).tolist(), strict=True))
    moving = {name: first + k for k, name in enumerate(kinematics.joint_names[:6])}
    every = {**own, **moving}
    chosen = np.array([every[name] for name in kinematics.joint_names], dtype=np.int64)
    at_rest = np.array([rest.get(name, 0.0) for name in kinematics.joint_names])
    links = [
        (row, frames[robot.name, name].get_value())
        for row, name in enumerate(kinematics.link_names)
        if (robot.name, name) in frames
    ]
    rows = np.array([row for row, _ in links], dtype=np.int64)
    arm = Arm(kinematics.tree.driven_by(chosen, at_rest), RigidTransform().ToArray(), rows)
    return MovedArm(arm, [id for _, id in links])


def _floating(child: str) -> UrdfJoint:
    return UrdfJoint('floating', _PLACE, child, _PLACE, RigidTransform(), _AXIS)


def nearest_turns(values: Floats, before: Floats, turns: Any) -> Floats:
    """Return values (q,) with turns by the shorter way from those before, if these are known."""
    steps = np.where(turns & np.isfinite(before), values - before, 0.0)
    return np.asarray(values - 2.0 * np.pi * np.round(steps / (2.0 * np.pi)))
