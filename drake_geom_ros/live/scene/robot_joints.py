"""The joints of a scene's robots: what they are called, and which links they move."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    FramePoseVector,
    PoseError,
    QueryObject,
)
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.scene.clocks import ALWAYS, UNKNOWN, Since
from drake_geom_ros.live.scene.driven_robot import Base, DrivenRobot, JointEntry, JointValue
from drake_geom_ros.live.scene.joint_past import JointPast, LinksPast
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import RobotDescription


class JointPlace(NamedTuple):
    """The robot of a joint, and its index there."""

    robot: str
    column: int


class RobotJoints:
    """The robots of one version of a scene that joint values can pose, with these values."""

    def __init__(
        self,
        robots: Sequence[RobotDescription],
        frames: Mapping[tuple[str, str], FrameId],
        before: RobotJoints | None = None,
    ) -> None:
        """``frames`` by source and name; values of ``before`` go on where names are the same."""
        self.robots: dict[str, DrivenRobot] = {}
        self.routed = 0  # how often a robot got another topic
        self.pasts: dict[str, JointPast] = {}  # of these, filled where somebody has to know
        self.past_of_links = LinksPast(self.pasts)
        self._homes: dict[str, tuple[FrameId | None, bool]] = {}
        self.refused: dict[str, str] = {}  # robots that no joint values can pose, and why
        for robot in robots:
            if robot.tree is None:
                continue
            previous = None if before is None else before.robots.get(robot.name)
            values = {} if previous is None else _heard_by(previous)
            try:
                driven = DrivenRobot(robot, frames, values)
            except ValueError as error:
                self.refused[robot.name] = str(error)
                continue
            past = None if before is None else before.pasts.get(robot.name)
            self.robots[robot.name] = driven
            self.pasts[robot.name] = JointPast(driven, past)

    def route(self, name: str, topic: str) -> None:
        """Have the joints of a robot be those of a topic, and of no other one."""
        self.robots[name].topic = topic
        self.routed += 1

    def go_on_as(self, before: RobotJoints) -> None:
        """Know of joints what was known before, of robots that were there."""
        for name, robot in self.robots.items():
            if (former := before.robots.get(name)) is not None:
                robot.know(_heard_by(former))

    @cached_property
    def entries(self) -> tuple[JointEntry, ...]:
        """The entries of the joints of all robots in messages."""
        return tuple(entry for robot in self.robots.values() for entry in robot.entries)

    def base(self, robot: DrivenRobot, query: QueryObject, since: Since | None) -> Base | None:
        """Return where the root link of a robot stands ``since`` when; None where it waits.

        That is in the frame that carries the robot, or in the world.
        """
        return self.bases([robot], query, [since])[0]

    def bases(
        self,
        robots: Sequence[DrivenRobot],
        query: QueryObject,
        sinces: Sequence[Since | None],
    ) -> list[Base | None]:
        """Return where robots stand, as ``base``; those that stand in the world at one look."""
        bases: list[Base | None] = [None] * len(robots)
        in_world, values = list[int](), list[int]()
        for k, robot in enumerate(robots):
            if robot.base_is_world:
                bases[k] = Base(robot.described_X_PB, ALWAYS)
            elif robot.root is None or robot.root_value is None:
                continue
            elif self._home(robot.name, robot.root, query)[0] is None:
                in_world.append(k)
                values.append(robot.root_value)
            else:
                bases[k] = self._carried_base(robot, robot.root, query, sinces[k])
        if values:
            for k, R_PB, p_PB, is_placed in zip(in_world, *query.X_WFs(values), strict=True):
                if is_placed:
                    X_PB = robots[k].pose_of_base(R_PB, p_PB)
                    bases[k] = Base(X_PB, sinces[k] or UNKNOWN)
        return bases

    def _carried_base(
        self, robot: DrivenRobot, root: FrameId, query: QueryObject, since: Since | None
    ) -> Base | None:
        """Return where a robot stands in the frame that carries it."""
        home, is_attached = self._home(robot.name, root, query)
        assert home is not None
        try:
            X_PB = (
                query.X_WF(home).InvertAndCompose(query.X_WF(root))
                if is_attached
                else query.X_PF(root)
            )
        except PoseError:
            return None
        X = robot.pose_of_base(X_PB.rotation().matrix(), X_PB.translation())
        return Base(X, since or UNKNOWN)

    def _home(self, name: str, root: FrameId, query: QueryObject) -> tuple[FrameId | None, bool]:
        """Return the frame that carries a robot, None for the world, and whether it is attached.

        Looked up once: a change of either makes another version of the scene.
        """
        if name not in self._homes:
            inspector = query.inspector()
            home = inspector.GetHomeFrame(root)
            is_attached = home != inspector.GetParentFrame(root)
            carrier = None if home == inspector.world_frame_id() else home
            self._homes[name] = carrier, is_attached
        return self._homes[name]

    def places(self, names: Sequence[str]) -> list[JointPlace]:
        """Return which joints names mean; raises ArgumentError for one that means none."""
        places = look_up(list(self.robots.values()), names)
        for name, place in zip(names, places, strict=True):
            if place is None:
                full_names = [full for robot in self.robots.values() for full in robot.full_names]
                raise ArgumentError(
                    f'there is no joint {shortened(name)!r} with a value of its own'
                    f'{nearest(name, full_names)}. Joints: {some_of(full_names) or "none"}. '
                    'See the topic ~/scene'
                )
        return [place for place in places if place is not None]

    def are_known(self, names: Sequence[str]) -> list[bool]:
        """Return which names mean a joint; raises ArgumentError for an ambiguous one."""
        return [place is not None for place in look_up(list(self.robots.values()), names)]

    def every_place(self) -> list[JointPlace]:
        """Return all joints, robot by robot."""
        robots = self.robots.items()
        return [JointPlace(name, k) for name, r in robots for k in range(len(r.joint_names))]

    def moved(
        self, names: Sequence[str], positions: Floats, query: QueryObject
    ) -> FramePoseVector:
        """Return the poses of the links that joints move, the other joints being as they are.

        The base of a robot is that of the query. Raises ArgumentError for names that mean no
        joint, for numbers that are none, and where another joint or the base is not known.
        """
        if len(names) != len(positions):
            raise ArgumentError(
                f'positions holds {len(positions)} numbers for {len(names)} joint names; it must '
                'hold one for each'
            )
        if not np.isfinite(positions).all():
            raise ArgumentError('positions of joints must be finite')
        changed: dict[str, dict[int, float]] = {}
        for place, position in zip(self.places(names), positions.tolist(), strict=True):
            changed.setdefault(place.robot, {})[place.column] = position
        ids, rows = [], []
        for name, values in changed.items():
            robot = self.robots[name]
            base = self.known_base(robot, query)
            now = robot.positions()
            now[list(values)] = list(values.values())
            links = {
                row
                for columns, some in robot.patterns.items()
                if not values.keys().isdisjoint(columns)
                for row in some
            }
            self.require_values(robot, now, robot.joints_of(links) if links else [])
            poses = robot.link_poses(base, now, links)
            ids.append(poses.ids)
            rows.append(poses.rows)
        if not ids:
            return FramePoseVector()
        return FramePoseVector.FromArrays(np.concatenate(ids), np.concatenate(rows))

    def known_base(self, robot: DrivenRobot, query: QueryObject) -> Base:
        """Return where a robot stands; raises ArgumentError where nobody knows."""
        base = self.base(robot, query, ALWAYS)
        if base is None:
            raise ArgumentError(
                f'the base of {robot.name!r} never had a pose, so its links stand nowhere: pose '
                'its root link by the scene file, ~/frame_poses or TF'
            )
        return base

    def require_values(
        self, robot: DrivenRobot, positions: Floats, columns: Sequence[int]
    ) -> None:
        """Raise ArgumentError where a joint that matters has no value (nan)."""
        if missing := [robot.full_names[c] for c in columns if np.isnan(positions[c])]:
            raise ArgumentError(
                f'nothing was heard of the joints {some_of(missing)}, which move the same links: '
                'name them too'
            )


def _heard_by(robot: DrivenRobot) -> dict[str, JointValue]:
    """Return the values of joints that were heard of, by name."""
    heard = zip(robot.joint_names, robot.values, strict=True)
    of_files = UNKNOWN, ALWAYS
    return {name: value for name, value in heard if value and value.since not in of_files}


def look_up(robots: Sequence[DrivenRobot], names: Sequence[str]) -> list[JointPlace | None]:
    """Return which joint each name means, ``joint`` or ``robot::joint``; None for none.

    Raises ArgumentError for a name of joints of two robots, and for a joint named twice.
    """
    meant: dict[str, list[JointPlace]] = {}
    for robot in robots:
        for joint, column in robot.columns.items():
            for alias in (joint, f'{robot.name}::{joint}'):
                meant.setdefault(alias, []).append(JointPlace(robot.name, column))
    places: list[JointPlace | None] = []
    for name in names:
        matches = meant.get(name, [])
        if len(matches) > 1:
            both = ' and '.join(repr(f'{p.robot}::{shortened(name)}') for p in matches)
            raise ArgumentError(
                f'joint {shortened(name)!r} is one of {len(matches)} robots: name it as {both}, '
                'or give each robot a topic of its own (joint_states of the scene file, or of '
                'the parameter robot_descriptions)'
            )
        places.append(matches[0] if matches else None)
    if twice := [p for p, n in Counter(filter(None, places)).items() if n > 1]:
        name = names[places.index(twice[0])]
        raise ArgumentError(f'joint {shortened(name)!r} is named twice')
    return places
