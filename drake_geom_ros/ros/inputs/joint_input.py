"""Frame poses from joint states: ``sensor_msgs/JointState`` messages move the links of robots.

A robot is one of the scene file or of ``robot_description``. Its base stands wherever its root
link was posed, by the scene file, TF or ``~/frame_poses``, and carries the links along when it
moves. A message may hold some joints only; of each joint the value that came last counts. Links
with a joint of which nothing was heard wait as every frame without a pose does. No ROS import.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import ArgumentError, FramePoseVector
from drake_geom_ros.ros.conversions.fields import seconds_of
from drake_geom_ros.ros.conversions.names import shortened, some_of
from drake_geom_ros.ros.inputs.driven_robot import (
    NANOSECONDS,
    UNKNOWN,
    Base,
    DrivenRobot,
    JointValue,
    Reposed,
)
from drake_geom_ros.ros.scene.clocks import ALWAYS, Clocks
from drake_geom_ros.ros.scene.editable_scene import EditableScene
from drake_geom_ros.ros.scene.feeders import JOINTS
from drake_geom_ros.ros.scene.held_scene import HeldScene
from drake_geom_ros.ros.scene.twists import stamp_of

Floats = NDArray[np.float64]
_MOST_LISTS = 64  # lists of names of which it is kept which joints they mean


class _Target(NamedTuple):
    """Where a number of a message goes."""

    robot: str
    column: int


class _Move(NamedTuple):
    """The links of a robot where joint values put them."""

    robot: DrivenRobot
    base: Base
    reposed: Reposed
    poses: FramePoseVector


class JointInput:
    """The values of joints as the node hears them, and the links that they move."""

    def __init__(self, clocks: Clocks, longest_gap: float, *, by_default: bool) -> None:
        """``by_default``: robots that name no topic of their own are driven, too.

        ``longest_gap`` [s]: values farther apart tell no speed.
        """
        self._clocks = clocks
        self._longest_gap = longest_gap
        self._by_default = by_default
        self._version = -1
        self._robots: dict[str, DrivenRobot] = {}
        self._refused: dict[str, str] = {}  # robots that no joint values drive, and why
        # By topic's robot and names: where each number goes, None for a joint of no robot here.
        self._known: dict[tuple[str, tuple[str, ...]], tuple[_Target | None, ...]] = {}

    def topics(self, scene: HeldScene) -> set[str]:
        """Return the topics that robots of the scene name."""
        self._refresh(scene)
        return {robot.topic for robot in self._robots.values() if robot.topic}

    def take(self, scene: EditableScene, message: Any, waited: float, topic: str = '') -> int:
        """Take a JointState whole that came ``waited`` [s] ago; return how many frames it posed.

        ``topic`` is that of robots that name it; empty: the one for all others. Raises
        ArgumentError for what is wrong, and for a message without a joint of ours.
        """
        self._refresh(scene)
        targets = self._targets(topic, tuple(message.name))
        positions, speeds = _numbers(message, targets)
        stamp = stamp_of(message.header.stamp)
        since = self._clocks.arrival(waited).since(seconds_of(message.header.stamp))
        changed: dict[str, set[int]] = {}
        before = {name: list(robot.values) for name, robot in self._robots.items()}
        for target, position, speed in zip(targets, positions, speeds, strict=True):
            if target is not None:
                robot, column = self._robots[target.robot], target.column
                value = JointValue(position, speed, stamp, since)
                robot.values[column] = self._joined(robot.values[column], value)
                changed.setdefault(target.robot, set()).add(column)
        try:
            moves = [self._move(scene, self._robots[name], c) for name, c in changed.items()]
        except RuntimeError:  # a link would stand farther than any scene reaches
            for name, values in before.items():
                self._robots[name].values = values
            raise
        return sum(self._pose(scene, move, message.header.stamp) for move in moves if move)

    def follow(self, scene: EditableScene) -> int:
        """Pose the robots whose base has moved, or that are new; return how many frames."""
        is_new, stamp = self._refresh(scene), scene.newest_stamp
        moves = [
            self._move(scene, robot, None)
            for robot in self._robots.values()
            if is_new or _bytes(self._base(scene, robot)) != _bytes(robot.base)
        ]
        if stamp is None:  # nothing ever came
            return 0
        return sum(self._pose(scene, move, stamp) for move in moves if move)

    def troubles(self, scene: HeldScene, stale_after: float) -> list[str]:
        """Return what is wrong with the joints, in words."""
        self._refresh(scene)
        told = [f'no joint values drive {name!r}: {why}' for name, why in self._refused.items()]
        age = self._clocks.ages()
        for robot in self._robots.values():
            if silent := robot.without_value():
                told.append(
                    f'{counted(len(silent), "joint")} of {robot.name!r} never had a value, and '
                    f'the links that depend on them wait: {some_of(silent)}'
                )
            stale = [
                name
                for name, value in zip(robot.joint_names, robot.values, strict=True)
                if value is not None and stale_after < age(value.since)
            ]
            if stale:
                told.append(
                    f'{counted(len(stale), "joint")} of {robot.name!r} {are(len(stale))} stale '
                    f'(older than {stale_after:g} s): {some_of(stale)}'
                )
        if outside := [words for r in self._robots.values() for words in r.outside_limits()]:
            told.append(
                f'{counted(len(outside), "joint")} {are(len(outside))} outside their limits: '
                f'{some_of(outside)}'
            )
        return told

    def _refresh(self, scene: HeldScene) -> bool:
        """Take over the robots of a scene that has changed; return whether it has."""
        if self._version == scene.version:
            return False
        frames = {label: frame for frame, label in scene.names.labels.items()}
        before, self._robots, self._refused = self._robots, {}, {}
        for robot in scene.robots:
            if robot.tree is None or not (robot.joint_states or self._by_default):
                continue
            known = before.get(robot.name)
            values = {}
            if known is not None:
                heard = zip(known.joint_names, known.values, strict=True)
                values = {name: value for name, value in heard if value is not None}
            try:
                self._robots[robot.name] = DrivenRobot(robot, frames, values)
            except ValueError as error:
                self._refused[robot.name] = str(error)
        self._known.clear()
        self._version = scene.version
        return True

    def _targets(self, topic: str, names: tuple[str, ...]) -> tuple[_Target | None, ...]:
        """Return where the numbers of a message go; raises ArgumentError where none goes."""
        targets = self._known.get((topic, names))
        if targets is None:
            targets = _look_up(
                [robot for robot in self._robots.values() if robot.topic == topic], names
            )
            if len(self._known) >= _MOST_LISTS:
                self._known.clear()
            self._known[topic, names] = targets
        return targets

    def _joined(self, before: JointValue | None, value: JointValue) -> JointValue:
        """Return what is known of a joint now: since when, and how fast it moves."""
        if before is None or not (value.stamp and before.stamp):
            return value
        seconds = (value.stamp - before.stamp) * NANOSECONDS
        if seconds > self._longest_gap or value.since.epoch != before.since.epoch:
            return value
        speed, since = value.speed, value.since
        if seconds == 0.0:
            since = since.said_again(before.since)
        if math.isnan(speed):
            if seconds > 0.0:
                speed = (value.position - before.position) / seconds
            elif seconds == 0.0:
                speed = before.speed
        return JointValue(value.position, speed, value.stamp, since)

    def _base(self, scene: HeldScene, robot: DrivenRobot) -> Base | None:
        """Return where the root link of a robot stands; None where nobody knows."""
        if robot.base_is_world:
            return Base(robot.described_X_WB, ALWAYS)
        if robot.root is None or not scene.query.is_placed(robot.root):
            return None
        since = scene.posed_since(robot.root)
        return Base(robot.pose_of_base(scene.query.X_WF(robot.root)), since or UNKNOWN)

    def _move(
        self, scene: HeldScene, robot: DrivenRobot, changed: set[int] | None
    ) -> _Move | None:
        """Return where links stand that changed columns move, all for None; raises RuntimeError.

        None: no link of the robot can be posed.
        """
        base = self._base(scene, robot)
        if base is None:
            return None
        if _bytes(base) != _bytes(robot.base):
            changed = None
        waiting = {frame.get_value() for frame in scene.query.waiting_frames()}
        reposed = robot.reposed(base, changed, waiting)
        if reposed is None:
            return None
        poses = FramePoseVector.FromArrays(reposed.ids, reposed.rows)
        return _Move(robot, base, reposed, poses)

    def _pose(self, scene: EditableScene, move: _Move, stamp: Any) -> int:
        """Pose links; return how many."""
        move.robot.base = move.base
        scene.pose(move.poses, move.reposed.posed, stamp, JOINTS)
        self._tell_twists(scene, move.robot, move.reposed, stamp)
        return len(move.poses)

    def _tell_twists(
        self, scene: EditableScene, robot: DrivenRobot, reposed: Reposed, stamp: Any
    ) -> None:
        """Tell how links move, as far as the speeds of joints and of the base are known."""
        if not scene.watches_motion or not stamp_of(stamp):
            return
        V_WB = np.zeros(6)
        if robot.root is not None and robot.base is not None and robot.base.since != ALWAYS:
            known = (scene.twists() or {}).get(robot.root)
            if known is None:
                return
            V_WB = known
        twists = robot.twists(reposed.X_WLs, V_WB)
        for frames, since in reposed.posed.items():
            if moving := [frame for frame in frames if frame in twists]:
                ids = np.array(moving, dtype=np.int64)
                rows = np.array([twists[frame] for frame in moving])
                scene.note_twists(ids, rows, stamp_of(stamp), since)


def _look_up(robots: Sequence[DrivenRobot], names: tuple[str, ...]) -> tuple[_Target | None, ...]:
    """Return which joint each name means; None for one of no robot, and for what is not free.

    Raises ArgumentError where no name means a joint of a robot, where one is of two robots, and
    where one is given twice.
    """
    meant: dict[str, list[_Target]] = {}
    others: set[str] = set()
    for robot in robots:
        for joint, column in robot.columns.items():
            for alias in {joint, f'{robot.name}::{joint}'}:
                meant.setdefault(alias, []).append(_Target(robot.name, column))
        others |= robot.others | {f'{robot.name}::{name}' for name in robot.others}
    targets: list[_Target | None] = []
    for name in names:
        found = meant.get(name, [])
        if len(found) > 1:
            both = ' and '.join(repr(f'{t.robot}::{shortened(name)}') for t in found)
            raise ArgumentError(
                f'joint {shortened(name)!r} is one of {len(found)} robots: send it as {both}, or '
                'give each robot a topic of its own with its key `joint_states`'
            )
        targets.append(found[0] if found else None)
    if twice := [t for t, n in Counter(filter(None, targets)).items() if n > 1]:
        name = names[targets.index(twice[0])]
        raise ArgumentError(f'joint {shortened(name)!r} is named twice')
    if not any(targets) and not (names and others.issuperset(names)):
        shown = some_of([repr(name) for name in names]) or 'no joints at all'
        hint = nearest(names[0], meant) if names else ''
        raise ArgumentError(
            f'no joint of a robot here is in the message{hint}: it names {shown}; there are '
            f'{some_of(list(meant)) or "none, for no robot of the scene listens to this topic"}'
        )
    return tuple(targets)


def _numbers(message: Any, targets: Sequence[_Target | None]) -> tuple[list[float], list[float]]:
    """Return the positions and speeds of a message; raises ArgumentError for what is wrong."""
    positions = np.asarray(message.position, dtype=np.float64)
    speeds = np.asarray(message.velocity, dtype=np.float64)
    asked = f'for {counted(len(targets), "name")}; it must hold one for each'
    if len(positions) != len(targets):
        raise ArgumentError(f'position holds {counted(len(positions), "number")} {asked}')
    if len(speeds) not in (0, len(targets)):
        raise ArgumentError(f'velocity holds {counted(len(speeds), "number")} {asked}, or none')
    ours = np.array([target is not None for target in targets], dtype=np.bool_)
    for what, numbers in (('position', positions), ('velocity', speeds)):
        wrong = np.flatnonzero(ours[: len(numbers)] & ~np.isfinite(numbers))
        if wrong.size:
            k = int(wrong[0])
            raise ArgumentError(
                f'{what} of joint {shortened(message.name[k])!r} is {numbers[k]}; '
                'it must be finite'
            )
    unknown = [math.nan] * len(targets)
    return positions.tolist(), speeds.tolist() if len(speeds) else unknown


def _bytes(base: Base | None) -> bytes:
    """Return where a base stands, to be compared."""
    return b'' if base is None else base.X_WB.tobytes()
