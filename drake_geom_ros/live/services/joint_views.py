"""Views of the scene for questions about joints: the present scene, and joints by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drake_geom_ros.batch.joints import Arm, Joints
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.message_types import FramePosesMessage
from drake_geom_ros.live.scene.driven_robot import or_zero
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.robot_following import refuse_carried_robots, refuse_twice_posed
from drake_geom_ros.live.scene.robot_joints import JointPlace, RobotJoints
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.services.moved_frames import MovedFrame, arm_on, lone_arm
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files.link_tree import LinkTree


class GivenJoints(NamedTuple):
    """Values [rad] or [m] of joints in a request, as a JointPositions has them."""

    names: Sequence[str] = ()
    positions: Sequence[float] = ()


NO_JOINTS = GivenJoints()


class JointsNow(NamedTuple):
    """The values of named joints."""

    now: Floats  # (q,) [rad] or [m]; NaN where nobody knows
    speeds: Floats  # (q,) [rad/s] or [m/s]; 0 where a request gave a value, NaN where unknown
    given: list[str]  # those of them that a request gave a value


def view_of_joints(
    live: LiveScene,
    poses: FramePosesMessage | None,
    names: list[str],
    chosen: GivenJoints = NO_JOINTS,
    frames: Sequence[MovedFrame] = (),
) -> tuple[SceneView, Joints, JointsNow]:
    """Return the scene of now with poses and ``chosen`` joints, and the joints that names mean.

    After them come the values of ``frames`` that move. ``poses`` is a FramePoses, or None. Raises
    RuntimeError for names and numbers that cannot be meant, and for a frame that is posed in two
    ways.
    """
    with live.reading() as scene:
        robots, places = scene.model.joints, scene.model.joints.places(names)
        values = _values(robots, chosen)
        named = {place.robot for place in places} | {f.robot for f in frames if f.robot}
        # The links of the robots that are named follow their joints, see _joints_of.
        others = [k for k, place in enumerate(values) if place.robot not in named]
        rest = GivenJoints(
            [chosen.names[k] for k in others], [float(chosen.positions[k]) for k in others]
        )
        view = live.view(poses, rest)
        posed = set[int]()
        if poses is not None:
            posed |= set(scene.model.reader.listed_in(poses).frames)
        joints = _joints_of(scene, names, places, view, values, frames)
        moving = set(joints.id_values.tolist())
        refuse_twice_posed(scene, posed & moving)
        refuse_carried_robots(scene, moving)
        old = scene.poses.links_of_stale_joints(live.stale_after, {*places, *values})
        replaced = view.replaced | moving.difference(old)
        heard = {name: robots.robots[name].values for name in named}
    now, speeds = np.full((2, len(places)), np.nan)
    for k, place in enumerate(places):
        value = heard[place.robot][place.column]
        if place in values:
            now[k], speeds[k] = values[place], 0.0
        elif value is not None:
            now[k], speeds[k] = value.position, value.speed
    if frames:
        now = np.concatenate([now, *(each.now for each in frames)])
        speeds = np.concatenate([speeds, np.full(6 * len(frames), np.nan)])
    both = [name for name, place in zip(names, places, strict=True) if place in values]
    return replace(view, replaced=replaced), joints, JointsNow(now, speeds, both)


def _values(robots: RobotJoints, chosen: GivenJoints) -> dict[JointPlace, float]:
    """Return given values by joint, in their order; raises ArgumentError for what is none."""
    if len(chosen.names) != len(chosen.positions):
        raise ArgumentError(
            f'positions holds {len(chosen.positions)} numbers for {len(chosen.names)} joint '
            'names; it must hold one for each'
        )
    if not len(chosen.names):
        return {}
    if not np.isfinite(chosen.positions).all():
        raise ArgumentError('positions of joints must be finite')
    positions = map(float, chosen.positions)
    return dict(zip(robots.places(list(chosen.names)), positions, strict=True))


def _joints_of(
    scene: HeldScene,
    names: list[str],
    places: Sequence[JointPlace],
    view: SceneView,
    chosen: Mapping[JointPlace, float],
    frames: Sequence[MovedFrame],
) -> Joints:
    """Return the joints of names for batches; the others of their robots stay as they are now.

    Or as they are ``chosen``. The values of frames come after them. Raises ArgumentError for no
    names, and for a robot of which another joint, or the base, is not known.
    """
    if not places and not frames:
        raise ArgumentError('joint_names is empty; name the joints that positions are of')
    robots = scene.model.joints
    bases = {each.robot: k for k, each in enumerate(frames) if each.robot}
    arms, ids = [], []
    for name in dict.fromkeys([*(place.robot for place in places), *bases]):
        robot = robots.robots[name]
        columns = np.full(len(robot.joint_names), -1, dtype=np.int64)
        for k, place in enumerate(places):
            if place.robot == name:
                columns[place.column] = k
        now = robot.positions()
        for place, value in chosen.items():
            if place.robot == name:
                now[place.column] = value
        needed = [c for c in robot.joints_of(robot.links) if columns[c] < 0] if robot.links else []
        robots.require_values(robot, now, needed)
        base = None if name in bases else robots.known_base(robot, view.query)
        if base is None:
            k = bases[name]
            moved = arm_on(
                *(frames[k], len(places) + 6 * k, robot, _tree_of(scene, name), columns, now),
                {label: frame for frame, label in scene.model.names.labels.items()},
            )
            arms.append(moved.arm)
            ids += moved.ids
            continue
        rows = np.array(sorted(robot.links), dtype=np.int64)
        tree = robot.tree.driven_by(columns, or_zero(now))
        arms.append(Arm(tree, base.X_PB, rows))
        ids += [robot.links[row] for row in rows.tolist()]
    for k, each in enumerate(frames):
        if not each.robot:
            moved = lone_arm(each, len(places) + 6 * k)
            arms.append(moved.arm)
            ids += moved.ids
    limits = [
        (robots.robots[p.robot].lower[p.column], robots.robots[p.robot].upper[p.column])
        for p in places
    ]
    lower, upper = np.array([*limits, *[(-np.inf, np.inf)] * (6 * len(frames))]).T
    every = [*names, *(column for each in frames for column in each.columns)]
    return Joints(every, lower, upper, np.array(ids, dtype=np.int64), tuple(arms))


def _tree_of(scene: HeldScene, name: str) -> LinkTree:
    """Return the links and joints of a robot that joint values can pose."""
    (tree,) = [robot.tree for robot in scene.model.robots if robot.name == name]
    assert tree is not None, 'it is driven'
    return tree
