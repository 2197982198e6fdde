"""The robot_state of MoveIt's planning scenes: joints and bases of robots that no topic drives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from drake_geom_ros.geometry import ArgumentError, FrameId, FramePoseVector, QueryObject
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.inputs.joint_input import BY_SCENE, JointInput
from drake_geom_ros.live.scene.driven_robot import DrivenRobot
from drake_geom_ros.live.scene.feeders import MESSAGES
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.multi_dof_joints import multi_dof_joints
from drake_geom_ros.live.scene.robot_following import pose_followers
from drake_geom_ros.math import RigidTransform

_SENDER = 'planning scene'


@dataclass
class SceneState:
    """Values of joints by ``robot::joint`` and poses of root links, taken from a RobotState.

    ``notes`` describe what is ignored.
    """

    header: Any
    positions: dict[str, float] = field(default_factory=dict)  # [rad] or [m]
    speeds: dict[str, float] = field(default_factory=dict)
    X_PBs: dict[FrameId, RigidTransform] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    @property
    def is_empty(self) -> bool:
        """True if nothing of it counts."""
        return not (self.positions or self.X_PBs)

    def query(self, scene: HeldScene) -> QueryObject:
        """Return a query object of the scene as it is with this state.

        A robot of which other joints were never heard stays as it is there: most of its links
        wait.
        """
        if self.is_empty:
            return scene.query
        view = scene.view()
        view.context.UpdateFramePoses(FramePoseVector(self.X_PBs))
        pose_followers(scene, view, {frame.get_value() for frame in self.X_PBs})
        by_robot: dict[str, dict[str, float]] = {}
        for name, value in self.positions.items():
            by_robot.setdefault(name.split('::', 1)[0], {})[name] = value
        for values in by_robot.values():
            try:
                moved = scene.model.joints.moved(
                    list(values), np.array([*values.values()]), view.query
                )
            except ArgumentError:
                continue
            view.context.UpdateFramePoses(moved)
            pose_followers(scene, view, set(moved.id_values().tolist()))
        return view.query

    def take(self, scene: HeldScene, joints: JointInput) -> None:
        """Pose the robots of a scene."""
        if self.X_PBs:
            since = scene.clocks.arrival().since(0.0)
            posed = {frozenset(frame.get_value() for frame in self.X_PBs): since}
            scene.poses.pose(FramePoseVector(self.X_PBs), posed, self.header.stamp, MESSAGES)
        if self.positions:
            names = list(self.positions)
            speeds = [self.speeds.get(name, math.nan) for name in names]
            message = SimpleNamespace(
                header=self.header,
                name=names,
                position=list(self.positions.values()),
                velocity=speeds,
            )
            joints.take(scene, message, 0.0, BY_SCENE, _SENDER)
        joints.follow(scene)


def read_state(scene: HeldScene, joints: JointInput | None, message: Any) -> SceneState:
    """Return what counts of a RobotState; raises ArgumentError for what cannot be meant.

    Ignored are joints that topics drive, whose values are newer, links that others pose, and names
    that mean no joint of the scene, or several.
    """
    state = SceneState(message.joint_state.header)
    robots = [] if joints is None else joints.undriven(scene)
    ignored = _take_joints(state, robots, message.joint_state)
    ignored += _take_several(state, scene, robots, message.multi_dof_joint_state)
    if ignored:
        state.notes.append(
            f'values of {some_of(ignored)} are ignored: they are no joint of the scene, or of '
            'several robots, or topics pose their links'
        )
    return state


def _take_joints(state: SceneState, robots: Sequence[DrivenRobot], message: Any) -> list[str]:
    """Take the values of a JointState; return the names that are ignored."""
    names, positions, speeds = list(message.name), list(message.position), list(message.velocity)
    for what, values, allowed in (
        ('position', positions, (len(names),)),
        ('velocity', speeds, (0, len(names))),
    ):
        if len(values) not in allowed:
            raise ArgumentError(
                f'robot_state.joint_state: {what} holds {len(values)} numbers for {len(names)} '
                'names; it must hold one for each'
            )
    ignored = []
    for k, name in enumerate(names):
        own = [r for r in robots if name in r.columns or name in r.full_names]
        if any(name in r.others for r in robots):
            continue  # it is fixed, or follows another one
        if len(own) != 1:
            ignored.append(shortened(name))
            continue
        if not math.isfinite(positions[k]):
            raise ArgumentError(
                f'robot_state.joint_state: position of {shortened(name)!r} is {positions[k]}; it '
                'must be finite'
            )
        full = name if name in own[0].full_names else f'{own[0].name}::{name}'
        state.positions[full] = float(positions[k])
        if speeds and math.isfinite(speeds[k]):
            state.speeds[full] = float(speeds[k])
    return ignored


def _take_several(
    state: SceneState, scene: HeldScene, robots: Sequence[DrivenRobot], message: Any
) -> list[str]:
    """Take the transforms of a MultiDOFJointState; return the names that are ignored."""
    names, place = list(message.joint_names), 'robot_state.multi_dof_joint_state'
    if len(message.transforms) != len(names):
        raise ArgumentError(
            f'{place} has {len(message.transforms)} transforms for {len(names)} joints; it must '
            'have one for each'
        )
    driven = {robot.name for robot in robots}
    several = [j for j in multi_dof_joints(scene.model.joints) if j.robot in driven]
    roots, ignored = _roots_by_virtual_joint(scene, robots), []
    for name, transform in zip(names, message.transforms, strict=True):
        own = [joint for joint in several if name in (joint.name, joint.full_name)]
        if len(own) == 1:
            values = own[0].values(transform, place).tolist()
            state.positions.update(zip(own[0].columns, values, strict=True))
        elif len(roots.get(name, ())) == 1:
            X_FB = _pose(transform, f'{place}, joint {shortened(name)!r}')
            state.X_PBs[roots[name][0]] = _frame(scene, message.header.frame_id) @ X_FB
        else:
            ignored.append(shortened(name))
    return ignored


def _roots_by_virtual_joint(
    scene: HeldScene, robots: Sequence[DrivenRobot]
) -> Mapping[str, list[FrameId]]:
    """Return the root links of robots by the names of the virtual joints of their SRDFs.

    Those that stand fixed, hang on a frame or are posed by TF are left out.
    """
    roots: dict[str, list[FrameId]] = {}
    described = {robot.name: robot for robot in scene.model.robots}
    names, welded = scene.model.names, scene.model.filter_manager.welded_frames()
    for robot in robots:
        root, feeders = robot.root, scene.poses.feeders
        if root is None or root in welded or scene.model.is_mounted(root):
            continue
        if feeders.is_fed_by_others(MESSAGES, root.get_value()):
            continue
        for name, link in described[robot.name].virtual_joints.items():
            if names.labels[root] == (robot.name, link):
                roots.setdefault(name, []).append(root)
    return roots


def _frame(scene: HeldScene, name: str) -> RigidTransform:
    """Return the pose of the frame that a virtual joint's transform is measured in."""
    model = scene.model
    if name.removeprefix('/') in ('', model.world_frame):
        return RigidTransform()
    try:
        return scene.poses.pose_in(model.names.frame(name.removeprefix('/')), model.names.world)
    except RuntimeError as error:
        raise ArgumentError(f'robot_state.multi_dof_joint_state: {error}') from error


def _pose(message: Any, place: str) -> RigidTransform:
    p, q = message.translation, message.rotation
    try:
        return RigidTransform.FromArray([p.x, p.y, p.z, q.x, q.y, q.z, q.w])
    except RuntimeError as error:
        raise ArgumentError(f'{place}: {error}') from error
