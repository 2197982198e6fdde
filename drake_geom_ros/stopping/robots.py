"""Robots that brake: their joints and bases, and how these move now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.queries.joint_trees import (
    JointChain,
    JointKind,
    JointTree,
    side_by_side,
)
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import rotations_from_quaternions
from drake_geom_ros.stopping.braking import Braking, BrakingError

BASE = ('x', 'y', 'theta')  # components of the twist of a base, in its own axes
# [m] A base whose turning circle is larger moves straight and turns, instead of along the circle.
_LARGEST_CIRCLE = 1e3
_AT_ORIGIN = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])


class Robot(NamedTuple):
    """A robot with joints; ``tree`` is driven by the values of ``joint_names``."""

    name: str
    joint_names: tuple[str, ...]
    tree: JointTree
    links: Indices  # (n,) rows of the links that are frames, without the root
    frame_ids: Indices  # (n,) of their frames
    root: int = 0  # id value of the root link's frame; 0: it is none


class RobotState(NamedTuple):
    """The motion of a robot at the stamp of its joints."""

    X_PB: Floats  # (7,) x y z [m] qx qy qz qw, the root link in what carries the robot
    positions: Floats  # (c,) [rad] or [m]; NaN: unknown
    velocities: Floats  # (c,) [rad/s] or [m/s]; NaN: unknown
    V_PB: Floats | None = None  # (6,) [w, v] of the root link, in the axes of P; None: unknown
    age: float = 0.0  # [s]


class _ArmLike(Protocol):
    tree: JointTree
    X_WB: Floats
    links: Indices


class JointsLike(Protocol):
    """The part of ``batch.Joints`` that ``robots_of`` uses."""

    names: tuple[str, ...]
    id_values: Indices
    arms: tuple[_ArmLike, ...]


def robots_of(joints: JointsLike) -> list[Robot]:
    """Return the robots of ``batch.Joints``, each with the joints of all columns.

    A joint that does not move a robot is one of its ``joint_names`` all the same, so that all
    their states have the columns of ``joints``. Names are ``robot::joint``.
    """
    robots, first = [], 0
    for k, arm in enumerate(joints.arms):
        ids = joints.id_values[first : first + len(arm.links)]
        first += len(arm.links)
        is_root = arm.links == 0
        root = int(ids[is_root][0]) if is_root.any() else 0
        moved = sorted({int(v) for v in arm.tree.leaders.tolist() if v >= 0})
        columns = np.full(len(joints.names), -1, dtype=np.int64)
        columns[moved] = np.arange(len(moved))
        tree = arm.tree.driven_by(columns, np.zeros(len(columns)))
        names = tuple(joints.names[v] for v in moved)
        name = names[0].split('::')[0] if names else f'{k}'
        robots.append(Robot(name, names, tree, arm.links[~is_root], ids[~is_root], root))
    return robots


class Columns(NamedTuple):
    """Columns of one path for several robots: their joints, then one for each base that brakes.

    A base has one value: the time [s] that it has gone on at its present twist.
    """

    robots: tuple[Robot, ...]
    firsts: tuple[int, ...]  # column of the first joint of each robot
    bases: tuple[int, ...]  # column of each robot's base; -1: it stands
    width: int

    @classmethod
    def of(cls, robots: Sequence[Robot], with_base: Sequence[bool]) -> Columns:
        """Return the columns of robots, with a base for those flagged."""
        sizes = [len(robot.joint_names) for robot in robots]
        firsts = np.concatenate(([0], np.cumsum(sizes))).astype(int).tolist()
        bases, count = [], firsts[-1]
        for has_base in with_base:
            bases.append(count if has_base else -1)
            count += has_base
        return cls(tuple(robots), tuple(firsts[:-1]), tuple(bases), count)

    def names(self) -> list[str]:
        """Return what each column is called."""
        joints = [
            name if name.startswith(f'{robot.name}::') else f'{robot.name}::{name}'
            for robot in self.robots
            for name in robot.joint_names
        ]
        with_base = zip(self.robots, self.bases, strict=True)
        return joints + [f'the base of {robot.name}' for robot, base in with_base if base >= 0]

    def chain(self) -> JointChain:
        """Return the chain of all robots, whose numbers ``driven`` replaces."""
        states = [
            RobotState(_AT_ORIGIN, np.zeros(len(r.joint_names)), np.zeros(len(r.joint_names)))
            for r in self.robots
        ]
        return self.driven(states)

    def frame_ids(self) -> Indices:
        """Return the id values (f,) of the frames of the chain's links."""
        each = [
            np.append(robot.root, robot.frame_ids) if base >= 0 else robot.frame_ids
            for robot, base in zip(self.robots, self.bases, strict=True)
        ]
        return np.concatenate(each).astype(np.int64)

    def driven(self, states: Sequence[RobotState]) -> JointChain:
        """Return the chain of all robots where they are now; a base moves by its twist."""
        trees, roots, links = [], [], []
        for k, (robot, state) in enumerate(zip(self.robots, states, strict=True)):
            first, base = self.firsts[k], self.bases[k]
            shift = np.where(robot.tree.leaders >= 0, robot.tree.leaders + first, -1)
            tree = replace(robot.tree, leaders=shift)
            if base < 0:
                trees.append(tree)
                roots.append(state.X_PB)
                links.append(robot.links)
                continue
            trees.append(_on_base(tree, state, base))
            roots.append(_AT_ORIGIN)
            links.append(np.append(0, robot.links) + 2)
        return side_by_side(trees, np.array(roots).reshape(-1, 7), links)

    def positions(self, states: Sequence[RobotState]) -> Floats:
        """Return the values (c,) of all columns; bases are at 0."""
        every = np.zeros(self.width)
        for first, state in zip(self.firsts, states, strict=True):
            every[first : first + len(state.positions)] = state.positions
        return every

    def velocities(self, states: Sequence[RobotState]) -> Floats:
        """Return the velocities (c,) of all columns; that of a base that moves is 1."""
        every = np.zeros(self.width)
        for first, base, state in zip(self.firsts, self.bases, states, strict=True):
            every[first : first + len(state.velocities)] = state.velocities
            if base >= 0:
                every[base] = float(np.isnan(twist := base_twist(state)).any() or twist.any())
        return every


def base_twist(state: RobotState) -> Floats:
    """Return x, y [m/s] and theta [rad/s] (3,) of a base in its own axes; NaN: unknown."""
    if state.V_PB is None:
        return np.full(3, np.nan)
    R_PB = rotations_from_quaternions(state.X_PB[None, 3:])[0]
    turn, straight = (R_PB.T @ part for part in np.reshape(state.V_PB, (2, 3)))
    return np.array([straight[0], straight[1], turn[2]])


def _on_base(tree: JointTree, state: RobotState, column: int) -> JointTree:
    """Return a tree on a base that moves by its present twist, by a column with seconds.

    A turning base goes along the circle about its instantaneous centre. Two joints stand for it:
    the first turns about that centre or slides along its velocity, the second turns the base where
    it slides.
    """
    x, y, theta = np.nan_to_num(base_twist(state)).tolist()
    R_PB = rotations_from_quaternions(state.X_PB[None, 3:])[0]
    speed = float(np.hypot(x, y))
    on_circle = abs(theta) > 0.0 and speed <= _LARGEST_CIRCLE * abs(theta)
    centre = np.array([-y / theta, x / theta, 0.0]) if on_circle else np.zeros(3)
    along = np.array([x, y, 0.0]) / speed if speed > 0.0 else np.array([1.0, 0.0, 0.0])
    # The first joint's axes are those of P, the second one's those of the base.
    X_PJ = np.concatenate((state.X_PB[:3] + R_PB @ centre, [0.0, 0.0, 0.0, 1.0]))
    X_JB = np.concatenate((R_PB @ -centre, state.X_PB[3:]))
    first = JointKind.REVOLUTE if on_circle else JointKind.PRISMATIC
    turning = 0.0 if on_circle else theta
    two = np.zeros(2)
    return JointTree(
        leaders=np.concatenate(([column, column], tree.leaders)),
        multipliers=np.concatenate(([theta if on_circle else speed, turning], tree.multipliers)),
        offsets=np.concatenate((two, tree.offsets)),
        kinds=np.concatenate(([first, JointKind.REVOLUTE], tree.kinds)).astype(np.int64),
        axes=np.vstack((R_PB[:, 2] if on_circle else R_PB @ along, [0.0, 0.0, 1.0], tree.axes)),
        X_PJs=np.vstack((X_PJ, X_JB, tree.X_PJs)),
        parents=np.concatenate(([0, 1], tree.parents + 2)),
        children=np.concatenate(([1, 2], tree.children + 2)),
    )


def arc_deviation(state: RobotState, seconds: float) -> float:
    """Return how far [s] of its speed a sliding base deviates from its circle, at most.

    Of a base on its circle that is 0. A chord in the direction of the tangent deviates by at most
    half of ``theta t^2`` of the way.
    """
    x, y, theta = np.nan_to_num(base_twist(state)).tolist()
    if np.hypot(x, y) <= _LARGEST_CIRCLE * abs(theta):
        return 0.0
    return float(0.5 * abs(theta) * seconds * seconds)


class BrakedJoints(NamedTuple):
    """The joints that one braking is about: columns, and components of twists of bases."""

    joints: tuple[tuple[int, int], ...]  # (robot, joint) in the order of decelerations
    bases: tuple[tuple[int, int], ...]  # (robot, component of BASE), likewise
    order: tuple[bool, ...]  # True for joints, False for bases, in the order of decelerations
    trouble: str = ''  # why it is about nothing

    @classmethod
    def of_nothing(cls, trouble: str) -> BrakedJoints:
        """Return none, and why."""
        return cls((), (), (), trouble)

    def columns(self, columns: Columns) -> NDArray[np.int64]:
        """Return the columns of these joints and bases, each once."""
        joints = [columns.firsts[robot] + joint for robot, joint in self.joints]
        bases = [columns.bases[robot] for robot, _ in self.bases]
        return np.unique(np.array([*joints, *bases], dtype=np.int64))

    def by_column(self, columns: Columns, times: Floats) -> Floats:
        """Return the times (c,) of columns, of a base the longest, from those in order (n,)."""
        every, left = np.zeros(columns.width), iter(times.tolist())
        joints, bases = iter(self.joints), iter(self.bases)
        for is_joint in self.order:
            robot, part = next(joints if is_joint else bases)
            at = columns.firsts[robot] + part if is_joint else columns.bases[robot]
            every[at] = max(every[at], next(left))
        return every

    def velocities(self, states: Sequence[RobotState]) -> Floats:
        """Return the velocities (n,) in the order of decelerations; NaN: unknown."""
        joints = iter(states[robot].velocities[joint] for robot, joint in self.joints)
        bases = iter(base_twist(states[robot])[part] for robot, part in self.bases)
        return np.array([next(joints if is_joint else bases) for is_joint in self.order])


def braked_joints(
    robots: Sequence[Robot], braking: Braking, chosen: Sequence[int]
) -> BrakedJoints:
    """Return the joints that a braking names, ``joint`` or ``robot::joint``, also x, y and theta.

    Without names they are all joints of the ``chosen`` robots, and names mean joints of these.
    Raises BrakingError for a name that means nothing, or joints of two robots.
    """
    names = braking.joint_names
    if not names:
        every = [(k, j) for k in chosen for j in range(len(robots[k].joint_names))]
        return BrakedJoints(tuple(every), (), (True,) * len(every))
    meant: dict[str, list[tuple[bool, int, int]]] = {}
    for k in chosen:
        robot = robots[k]
        own = {name: (True, k, j) for j, name in enumerate(robot.joint_names)}
        if robot.root:
            own = {name: (False, k, j) for j, name in enumerate(BASE)} | own
        for name, place in own.items():
            short = name.removeprefix(f'{robot.name}::')
            for alias in {short, f'{robot.name}::{short}'}:
                meant.setdefault(alias, []).append(place)
    for name in names:
        places = meant.get(name, [])
        if len(places) != 1:
            robots_named = ', '.join(robots[k].name for k in chosen) or 'none'
            problem = 'joints of several robots' if places else 'no joint, nor base,'
            raise BrakingError(
                f'joint_names has {name!r}, which means {problem} of set_a (robots: '
                f'{robots_named}); name it as robot::joint. A base has x, y and theta where the '
                "robot's root link is a frame"
            )
    braked = [meant[name][0] for name in names]
    return BrakedJoints(
        tuple((k, j) for is_joint, k, j in braked if is_joint),
        tuple((k, j) for is_joint, k, j in braked if not is_joint),
        tuple(is_joint for is_joint, _, _ in braked),
    )
