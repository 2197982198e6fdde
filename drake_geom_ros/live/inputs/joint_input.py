"""Frame poses from joint states: ``sensor_msgs/JointState`` messages move the links of robots.

A robot is one of the scene file or of ``robot_description``. Its base stands wherever its root
link was posed, by the scene file, TF or ``~/frame_poses``, and carries the links along when it
moves; a robot that is mounted on a frame hangs there with all its links. A message may hold some
joints only; of each joint the value that came last counts. Links with a joint of which nothing was
heard wait as every frame without a pose does, or stand as the scene file says.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import ArgumentError, FrameId, FramePoseVector
from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.scene.clocks import ALWAYS, UNKNOWN, Clocks, Since
from drake_geom_ros.live.scene.driven_robot import (
    Base,
    DrivenRobot,
    JointValue,
    LinkPoses,
    Moments,
)
from drake_geom_ros.live.scene.feeders import JOINTS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.robot_joints import JointPlace, look_up
from drake_geom_ros.live.scene.twists import stamp_of

_NANOSECONDS = 1e-9  # [s]
_MOST_LISTS = 64  # lists of names of which it is kept which joints they mean


class NothingOfOursError(ArgumentError):
    """A message of joint values that names no joint of a robot here: it is of another robot."""


class _Move(NamedTuple):
    """The links of a robot where joint values put them, and since when."""

    robot: DrivenRobot
    base: Base
    links: LinkPoses
    posed: Mapping[frozenset[int], Since]
    poses: FramePoseVector


class JointInput:
    """Takes the values of joints as the node hears them, and poses the links that they move."""

    def __init__(self, clocks: Clocks, longest_gap: float, *, by_default: bool) -> None:
        """``by_default``: robots that name no topic of their own are driven, too.

        ``longest_gap`` [s]: values farther apart give no speed.
        """
        self._clocks = clocks
        self._longest_gap = longest_gap
        self._by_default = by_default
        self._version = -1
        self._carriers: dict[str, frozenset[int]] = {}  # of each robot
        # By topic and names: where each number goes, None for a joint of no robot here.
        self._known: dict[tuple[str, tuple[str, ...]], list[JointPlace | None]] = {}

    def topics(self, scene: HeldScene) -> set[str]:
        """Return the topics that robots of the scene name."""
        return {robot.topic for robot in scene.model.joints.robots.values() if robot.topic}

    def take(
        self,
        scene: HeldScene,
        message: Any,
        waited: float,
        topic: str = '',
        sender: str = '',
    ) -> int:
        """Take a JointState whole that came ``waited`` [s] ago; return how many frames it posed.

        ``topic`` is that of robots that name it, empty: the one for all others; ``sender`` is the
        identity of the publisher, empty where nobody knows it. Raises
        ArgumentError for what is wrong, and for a message without a joint of ours.
        """
        places = self.places(scene, topic, tuple(message.name))
        positions, speeds = _numbers(message, places)
        stamp = stamp_of(message.header.stamp)
        since = self._clocks.arrival(waited).since(seconds_of(message.header.stamp))
        robots = scene.model.joints.robots
        before = {place.robot: list(robots[place.robot].values) for place in places if place}
        changed: dict[str, set[int]] = {}
        for place, position, speed in zip(places, positions, speeds, strict=True):
            if place is not None:
                values = robots[place.robot].values
                value = JointValue(position, speed, stamp, since)
                values[place.column] = self._joined(values[place.column], value)
                changed.setdefault(place.robot, set()).add(place.column)
        try:
            moves = [self._move(scene, robots[name], c) for name, c in changed.items()]
        except RuntimeError:  # a link would stand farther than any scene reaches
            for name, values in before.items():
                robots[name].values = values
            raise
        self._note_sender(scene, message, sender, changed)
        if scene.poses.history is not None:
            for name, columns in changed.items():
                scene.model.joints.pasts[name].note(columns)
        return sum(self._pose(scene, move, message.header.stamp) for move in moves if move)

    def _note_sender(
        self, scene: HeldScene, message: Any, sender: str, changed: Mapping[str, set[int]]
    ) -> None:
        """Note who sent values; without an identity by what is listed, and by the values."""
        joints = frozenset((name, column) for name in changed for column in changed[name])
        listed = tuple(message.name), len(message.velocity) > 0, message.header.frame_id
        scene.poses.senders.note_joints(sender or listed, joints)
        if not sender:
            for name, columns in changed.items():
                scene.poses.senders.note_values(scene.model.joints.robots[name], columns)

    def follow(self, scene: HeldScene) -> int:
        """Pose the robots whose base has moved, or that are new; return how many frames.

        What others posed since is left to them where the base stands: joint values are older.
        """
        version, robots = scene.model.model_version, scene.model.joints.robots
        is_new, self._version = self._version != version, version
        if is_new:
            self._carriers = {r.name: carriers_of(scene, r) for r in robots.values()}
        stamp = scene.poses.ages.newest_stamp
        if stamp is None:  # nothing ever came
            return 0
        moved, scene.poses.moved = scene.poses.moved, set()
        moves = []
        for robot in self._driven(scene):
            may_have_moved = robot.base is None or not moved.isdisjoint(self._carriers[robot.name])
            if not (is_new or may_have_moved):
                continue
            others, base = self._are_others(scene, robot), base_of(scene, robot)
            if is_new or _bytes(base) != _bytes(robot.base):
                moves.append(self._move(scene, robot, None, leave_out=others))
            elif base and robot.base and base.since != robot.base.since:
                self._renew(scene, robot, base, others)
        return sum(self._pose(scene, move, stamp) for move in moves if move)

    def has_followed(self, scene: HeldScene) -> bool:
        """Return whether ``follow`` has seen this version of the scene."""
        return self._version == scene.model.model_version

    def troubles(self, scene: HeldScene, stale_after: float) -> list[str]:
        """Return what is wrong with the joints, in words."""
        troubles = []
        if self._by_default:
            refused = scene.model.joints.refused.items()
            troubles = [f'no joint values drive {name!r}: {why}' for name, why in refused]
        age = self._clocks.ages()
        robots = self._driven(scene)
        for robot in robots:
            if base_of(scene, robot) is None:
                troubles.append(
                    f'the base of {robot.name!r} never had a pose, so its links wait: pose its '
                    'root link by the scene file, ~/frame_poses or TF, or let that be the world '
                    'frame (world_frame of a node, --world-frame of a report)'
                )
            if silent := robot.without_value():
                troubles.append(
                    f'{counted(len(silent), "joint")} of {robot.name!r} never had a value, and '
                    f'the links that depend on them wait: {some_of(silent)}; publish them on '
                    f'{robot.topic or "joint_states"}'
                )
            if unheard := robot.unheard():
                troubles.append(
                    f'nothing was heard of {counted(len(unheard), "joint")} of {robot.name!r}; '
                    f'there the scene file counts: {some_of(unheard)}; publish them on '
                    f'{robot.topic or "joint_states"}'
                )
            stale = [
                name
                for name, value in zip(robot.joint_names, robot.values, strict=True)
                if value is not None and value.since != UNKNOWN and stale_after < age(value.since)
            ]
            if stale:
                troubles.append(
                    f'{counted(len(stale), "joint")} of {robot.name!r} {are(len(stale))} stale '
                    f'(older than {stale_after:g} s): {some_of(stale)}'
                )
        if outside := [words for robot in robots for words in robot.outside_limits()]:
            troubles.append(
                f'{counted(len(outside), "joint")} {are(len(outside))} outside their limits: '
                f'{some_of(outside)}'
            )
        return troubles

    def _driven(self, scene: HeldScene) -> list[DrivenRobot]:
        """Return the robots that somebody may drive."""
        robots = scene.model.joints.robots.values()
        return [robot for robot in robots if robot.topic or self._by_default]

    def places(
        self, scene: HeldScene, topic: str, names: tuple[str, ...]
    ) -> list[JointPlace | None]:
        """Return where the numbers of a message go; raises ArgumentError where none goes."""
        if self._version != scene.model.model_version:
            self._known.clear()
        places = self._known.get((topic, names))
        if places is None:
            robots = [robot for robot in self._driven(scene) if robot.topic == topic]
            places = look_up(robots, names)
            if not any(places) and not _are_others(robots, names):
                raise _nothing_of_ours(robots, names)
            if len(self._known) >= _MOST_LISTS:
                self._known.clear()
            self._known[topic, names] = places
        return places

    def _joined(self, before: JointValue | None, value: JointValue) -> JointValue:
        """Return what is known of a joint now: since when, and how fast it moves."""
        if before is None or not (value.stamp and before.stamp):
            return value
        seconds = (value.stamp - before.stamp) * _NANOSECONDS
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

    def _move(
        self,
        scene: HeldScene,
        robot: DrivenRobot,
        changed: set[int] | None,
        leave_out: frozenset[int] = frozenset(),
    ) -> _Move | None:
        """Return where links stand that changed columns move, all for None; raises RuntimeError.

        Links that no joint moves move only where they wait, or with the base. None: no link of
        the robot can be posed. Rows of ``leave_out`` move with the base alone.
        """
        base = base_of(scene, robot)
        if base is None:
            return None
        moved = robot.base is not None and _bytes(base) != _bytes(robot.base)
        waiting = {frame.get_value() for frame in scene.query.waiting_frames()}
        rows = {}
        for columns, some in robot.patterns.items():
            if not columns and not moved:
                some = frozenset(row for row in some if robot.links[row] in waiting)
            elif columns and changed is not None and not moved and changed.isdisjoint(columns):
                continue
            rows[columns] = some if moved else some - leave_out
        moments = robot.since(base, rows)
        if not moments:
            return None
        links = robot.link_poses(base, robot.positions(), set().union(*moments.values()))
        # Of what stands as the scene file says the age stays unknown.
        posed = _frames_since(robot, moments)
        return _Move(robot, base, links, posed, FramePoseVector.FromArrays(links.ids, links.rows))

    def _renew(
        self, scene: HeldScene, robot: DrivenRobot, base: Base, leave_out: frozenset[int]
    ) -> None:
        """Let the links be as new as a base that was posed again where it stands."""
        rows = {columns: some - leave_out for columns, some in robot.patterns.items()}
        robot.base = base
        scene.poses.renew(_frames_since(robot, robot.since(base, rows)))

    def _are_others(self, scene: HeldScene, robot: DrivenRobot) -> frozenset[int]:
        """Return the rows of links that somebody else posed last."""
        by_others = scene.poses.feeders.is_fed_by_others
        return frozenset(row for row, f in robot.links.items() if by_others(JOINTS, f))

    def _pose(self, scene: HeldScene, move: _Move, stamp: Any) -> int:
        """Pose links; return how many."""
        move.robot.base = move.base
        past = scene.model.joints.pasts[move.robot.name]
        scene.poses.pose(move.poses, move.posed, stamp, JOINTS, move.links.rows, past)
        if scene.poses.watches_motion and stamp_of(stamp):
            _tell_twists(scene, move, stamp_of(stamp))
        return len(move.poses)


def _frames_since(robot: DrivenRobot, moments: Moments) -> dict[frozenset[int], Since]:
    """Return since when links hold, by their frames; those of unknown age are left out."""
    return {
        frozenset(robot.links[row] for row in some): since
        for since, some in moments.items()
        if since != UNKNOWN
    }


def base_of(scene: HeldScene, robot: DrivenRobot) -> Base | None:
    """Return where the root link of a robot stands; None where nobody knows."""
    since = None if robot.root is None else scene.poses.since(robot.root)
    return scene.model.joints.base(robot, scene.query, since)


def carriers_of(scene: HeldScene, robot: DrivenRobot) -> frozenset[int]:
    """Return the frames (values of ids) whose poses say where a robot's root link stands."""
    if robot.root is None:
        return frozenset()
    inspector, carriers = scene.model.inspector, set[FrameId]()
    for frame in (robot.root, inspector.GetHomeFrame(robot.root)):
        while frame != inspector.world_frame_id() and frame not in carriers:
            carriers.add(frame)
            frame = inspector.GetParentFrame(frame)
    return frozenset(frame.get_value() for frame in carriers)


def _tell_twists(scene: HeldScene, move: _Move, stamp: int) -> None:
    """Set the twists of links, where the speeds of joints and base are known."""
    V_PB = np.zeros(6)
    if move.robot.root is not None and move.base.since != ALWAYS:
        V_PR = (scene.poses.twists() or {}).get(move.robot.root)
        if V_PR is None or scene.model.is_mounted(move.robot.root):
            return  # what carries it moves, too: successive poses tell how links move in that
        V_PB = V_PR
    twists = move.robot.twists(move.links.X_PLs, V_PB)
    for frames, since in move.posed.items():
        if moving := [frame for frame in frames if frame in twists]:
            rows = np.array([twists[frame] for frame in moving])
            scene.poses.note_joint_twists(np.array(moving, dtype=np.int64), rows, stamp, since)


def _are_others(robots: Sequence[DrivenRobot], names: Sequence[str]) -> bool:
    """Return whether all names mean joints that move nothing by themselves."""
    others = {alias for r in robots for name in r.others for alias in (name, f'{r.name}::{name}')}
    return bool(names) and others.issuperset(names)


def _nothing_of_ours(robots: Sequence[DrivenRobot], names: Sequence[str]) -> NothingOfOursError:
    joint_names = [alias for r in robots for alias in (*r.joint_names, *r.full_names)]
    shown = some_of([repr(name) for name in names]) or 'no joints at all'
    hint = nearest(names[0], joint_names) if names else ''
    return NothingOfOursError(
        f'no joint of a robot here is in the message{hint}: it names {shown}; there are '
        f'{some_of(joint_names) or "none, for no robot of the scene listens to this topic"}'
    )


def _numbers(message: Any, places: Sequence[JointPlace | None]) -> tuple[list[float], list[float]]:
    """Return the positions and speeds of a message; raises ArgumentError for what is wrong."""
    positions = np.asarray(message.position, dtype=np.float64)
    speeds = np.asarray(message.velocity, dtype=np.float64)
    expected = f'for {counted(len(places), "name")}; it must hold one for each'
    if len(positions) != len(places):
        raise ArgumentError(f'position holds {counted(len(positions), "number")} {expected}')
    if len(speeds) not in (0, len(places)):
        raise ArgumentError(f'velocity holds {counted(len(speeds), "number")} {expected}, or none')
    is_own = np.array([place is not None for place in places], dtype=np.bool_)
    # A driver without an interface for velocities sends NaN for each: it is not known then.
    allowed = np.isfinite(positions), np.isfinite(speeds) | np.isnan(speeds)
    for what, numbers, good in zip(
        ('position', 'velocity'), (positions, speeds), allowed, strict=True
    ):
        wrong = np.flatnonzero(is_own[: len(numbers)] & ~good)
        if wrong.size:
            k = int(wrong[0])
            raise ArgumentError(
                f'{what} of joint {shortened(message.name[k])!r} is {numbers[k]}; '
                'it must be finite'
            )
    unknown = [math.nan] * len(places)
    return positions.tolist(), speeds.tolist() if len(speeds) else unknown


def _bytes(base: Base | None) -> bytes:
    """Return where a base stands, to be compared."""
    return b'' if base is None else base.X_PB.tobytes()
