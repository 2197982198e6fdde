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
from typing import NamedTuple

import numpy as np

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import ArgumentError, FrameId, FramePoseVector
from drake_geom_ros.live.conversions.fields import nanoseconds_of, seconds_of
from drake_geom_ros.live.conversions.message_types import (
    JointStateMessage,
    TimeMessage,
)
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.scene.clocks import ALWAYS, UNKNOWN, Clocks, Since
from drake_geom_ros.live.scene.driven_robot import (
    Base,
    DrivenRobot,
    JointValue,
    LinkPoses,
)
from drake_geom_ros.live.scene.feeders import JOINTS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.robot_joints import JointPlace, look_up
from drake_geom_ros.math.array_types import Floats

_NANOSECONDS = 1e-9  # [s]
_NO_IDS = np.zeros(0, dtype=np.int64)
BY_SCENE = '<planning scene>'  # instead of a topic: of robots that no topic drives
_MOST_LISTS = 64  # lists of names of which it is kept which joints they mean


class NothingOfOursError(ArgumentError):
    """A message of joint values that names no joint of a robot here: it is of another robot."""


class _Move(NamedTuple):
    """The links of a robot where joint values put them, and since when."""

    robot: DrivenRobot
    base: Base
    links: LinkPoses
    posed: Mapping[frozenset[int], Since]


class _Moves(NamedTuple):
    """The links of all robots that a message moves."""

    each: list[_Move]
    poses: FramePoseVector
    rows: Floats  # (n, 7) of these


class JointInput:
    """Takes joint values from messages, and poses the links that they move."""

    def __init__(self, clocks: Clocks, longest_gap: float, *, by_default: bool) -> None:
        """``by_default``: robots that name no topic of their own are driven, too.

        ``longest_gap`` [s]: values farther apart give no speed.
        """
        self._clocks = clocks
        self._longest_gap = longest_gap
        self._by_default = by_default
        self._by_scene: set[str] = set()  # robots that planning scenes drive
        self._version = self._routed = -1
        self._carriers: dict[str, frozenset[int]] = {}  # of each robot
        # By topic and names: where each number goes, None for a joint of no robot here.
        self._known: dict[tuple[str, tuple[str, ...]], list[JointPlace | None]] = {}

    def topics(self, scene: HeldScene) -> set[str]:
        """Return the topics that robots of the scene name."""
        return {robot.topic for robot in scene.model.joints.robots.values() if robot.topic}

    def take(
        self,
        scene: HeldScene,
        message: JointStateMessage,
        waited: float,
        topic: str = '',
        sender: str = '',
    ) -> int:
        """Take a JointState whole that came ``waited`` [s] ago; return how many frames it posed.

        ``topic`` is that of robots that name it, empty: the one for all others, BY_SCENE: a
        planning scene; ``sender`` is the identity of the publisher, empty where nobody knows it.
        Raises ArgumentError for what is wrong, and for a message without a joint of ours.
        """
        places = self.places(scene, topic, tuple(message.name))
        positions, speeds = _numbers(message, places)
        stamp, held = nanoseconds_of(message.header.stamp), seconds_of(message.header.stamp)
        since = self._clocks.arrival(waited).since(held)
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
            moves = self._moves(scene, [(robots[name], changed[name]) for name in changed])
        except RuntimeError:  # a link would stand farther than any scene reaches
            for name, values in before.items():
                robots[name].values = values
            raise
        if topic == BY_SCENE:
            self._by_scene.update(changed)
        self._note_sender(scene, message, sender, changed)
        if scene.poses.history is not None:
            for name, columns in changed.items():
                scene.model.joints.pasts[name].note(columns)
        return self._pose(scene, moves, message.header.stamp)

    def _note_sender(
        self,
        scene: HeldScene,
        message: JointStateMessage,
        sender: str,
        changed: Mapping[str, set[int]],
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
        standing = []
        for robot in self._driven(scene):
            may_have_moved = robot.base is None or not moved.isdisjoint(self._carriers[robot.name])
            if not (is_new or may_have_moved):
                continue
            base = base_of(scene, robot)
            if is_new or _bytes(base) != _bytes(robot.base):
                standing.append((robot, None))
            elif base and robot.base and base.since != robot.base.since:
                self._renew(scene, robot, base, self._are_others(scene, robot))
        return self._pose(scene, self._moves(scene, standing), stamp) if standing else 0

    def has_followed(self, scene: HeldScene) -> bool:
        """Return whether ``follow`` has seen this version of the scene."""
        return self._version == scene.model.model_version

    def troubles(self, scene: HeldScene, stale_after: float) -> list[str]:
        """Return faults of the joints, in words."""
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
            if heard := robot.no_longer_held():
                troubles.append(
                    f'held_joints of {robot.name!r} names {some_of(heard)}, of which values are '
                    'published: these count, and grow old; leave them out of one of the two'
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
        by_scene = self._by_scene
        return [r for r in robots if r.topic or self._by_default or r.name in by_scene]

    def undriven(self, scene: HeldScene) -> list[DrivenRobot]:
        """Return the robots that no topic drives, and whose links no other input poses."""
        if self._by_default:
            return []
        robots = scene.model.joints.robots.values()
        return [r for r in robots if not (r.topic or self._are_others(scene, r))]

    def places(
        self, scene: HeldScene, topic: str, names: tuple[str, ...]
    ) -> list[JointPlace | None]:
        """Return where the numbers of a message go; raises ArgumentError where none goes."""
        routed = scene.model.joints.routed
        if self._version != scene.model.model_version or self._routed != routed:
            self._known.clear()
            self._routed = routed
        places = None if topic == BY_SCENE else self._known.get((topic, names))
        if places is None:
            if topic == BY_SCENE:
                robots = self.undriven(scene)
            else:
                robots = [robot for robot in self._driven(scene) if robot.topic == topic]
            places = look_up(robots, names)
            if not any(places) and not _are_others(robots, names):
                raise _nothing_of_ours(robots, names)
            if len(self._known) >= _MOST_LISTS:
                self._known.clear()
            self._known[topic, names] = places
        return places

    def _joined(self, before: JointValue | None, value: JointValue) -> JointValue:
        """Return the time of a joint's value, and its speed."""
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

    def _moves(
        self, scene: HeldScene, changed: Sequence[tuple[DrivenRobot, set[int] | None]]
    ) -> _Moves:
        """Return where links stand that changed columns move; None: all follow a base.

        Left out are robots of which no link can be posed. Raises RuntimeError for a place beyond
        that of any scene.
        """
        bases = bases_of(scene, [robot for robot, _ in changed])
        waiting = {frame.get_value() for frame in scene.query.waiting_frames()}
        choices = []
        for (robot, columns), base in zip(changed, bases, strict=True):
            if base is not None:
                others = frozenset() if columns is not None else self._are_others(scene, robot)
                rows = _rows_to_pose(robot, base, columns, others, waiting)
                choices.append((robot, base, rows))
        moves = []
        for robot, base, rows in choices:
            if moments := robot.since(base, rows):
                links = robot.link_poses(base, robot.positions(), set().union(*moments.values()))
                # Of what stands as the scene file says the age stays unknown.
                moves.append(_Move(robot, base, links, robot.frames_since(moments)))
        ids = [move.links.ids for move in moves]
        rows_of_all = np.concatenate([move.links.rows for move in moves] or [np.zeros((0, 7))])
        poses = FramePoseVector.FromArrays(np.concatenate(ids or [_NO_IDS]), rows_of_all)
        return _Moves(moves, poses, rows_of_all)

    def _renew(
        self, scene: HeldScene, robot: DrivenRobot, base: Base, leave_out: frozenset[int]
    ) -> None:
        """Let the links be as new as a base that was posed again where it stands."""
        rows = {columns: some - leave_out for columns, some in robot.patterns.items()}
        robot.base = base
        scene.poses.renew(robot.frames_since(robot.since(base, rows)))

    def _are_others(self, scene: HeldScene, robot: DrivenRobot) -> frozenset[int]:
        """Return the rows of links that another input posed last."""
        by_others = scene.poses.feeders.is_fed_by_others
        return frozenset(row for row, f in robot.links.items() if by_others(JOINTS, f))

    def _pose(self, scene: HeldScene, moves: _Moves, stamp: TimeMessage) -> int:
        """Pose links, all at once; return how many."""
        if not moves.each:
            return 0
        for move in moves.each:
            move.robot.base = move.base
        posed = {frames: since for move in moves.each for frames, since in move.posed.items()}
        past = scene.model.joints.past_of_links
        scene.poses.pose(moves.poses, posed, stamp, JOINTS, moves.rows, past)
        if scene.poses.watches_motion and (time := nanoseconds_of(stamp)):
            for move in moves.each:
                _tell_twists(scene, move, time)
        return len(moves.rows)


def _rows_to_pose(
    robot: DrivenRobot,
    base: Base,
    changed: set[int] | None,
    leave_out: frozenset[int],
    waiting: set[int],
) -> dict[tuple[int, ...], frozenset[int]]:
    """Return the rows of links that changed columns move, all for None, by what they depend on.

    Links that no joint moves move only where they wait, or with the base. Rows of ``leave_out``
    move with the base alone.
    """
    moved = robot.base is not None and _bytes(base) != _bytes(robot.base)
    rows = {}
    for columns, some in robot.patterns.items():
        if not columns and not moved:
            some = frozenset(row for row in some if robot.links[row] in waiting)
        elif columns and changed is not None and not moved and changed.isdisjoint(columns):
            continue
        rows[columns] = some if moved else some - leave_out
    return rows


def base_of(scene: HeldScene, robot: DrivenRobot) -> Base | None:
    """Return the pose of the root link of a robot; None if unknown."""
    return bases_of(scene, [robot])[0]


def bases_of(scene: HeldScene, robots: Sequence[DrivenRobot]) -> list[Base | None]:
    """Return the poses of the root links of robots; None if unknown."""
    since, values = scene.poses.ages.since, [robot.root_value for robot in robots]
    sinces = [None if value is None else since(value) for value in values]
    return scene.model.joints.bases(robots, scene.query, sinces)


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


def _numbers(
    message: JointStateMessage, places: Sequence[JointPlace | None]
) -> tuple[list[float], list[float]]:
    """Return the positions and speeds of a message; raises ArgumentError for what is wrong."""
    positions = np.asarray(message.position, dtype=np.float64)
    speeds = np.asarray(message.velocity, dtype=np.float64)
    for what, numbers, allowed in (
        ('position', positions, (len(places),)),
        ('velocity', speeds, (0, len(places))),
    ):
        if len(numbers) not in allowed:
            raise ArgumentError(
                f'{what} holds {counted(len(numbers), "number")} for '
                f'{counted(len(places), "name")}; it must hold one for each'
                f'{", or none" if 0 in allowed else ""}'
            )
    is_own = np.array([place is not None for place in places], dtype=np.bool_)
    # A driver without an interface for velocities sends NaN for each: it is not known then.
    finite = np.isfinite(positions), np.isfinite(speeds) | np.isnan(speeds)
    for what, numbers, good in zip(
        ('position', 'velocity'), (positions, speeds), finite, strict=True
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
