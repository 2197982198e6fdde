"""Links of a robot as a function of its joints: names, limits, mimics, poses of many states."""

import math
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.queries.joint_trees import JointKind, JointTree
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import poses_from_matrices
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.scene_files.urdf_tree import parents_first, root_links

_KINDS = {
    'revolute': JointKind.REVOLUTE,
    'continuous': JointKind.REVOLUTE,
    'prismatic': JointKind.PRISMATIC,
}
_MOVING = tuple(_KINDS)
# Joints of several values: type and axis index of the single joint that each value moves.
SEVERAL = {
    'planar': {'x': ('prismatic', 0), 'y': ('prismatic', 1), 'theta': ('continuous', 2)},
    'floating': {
        'x': ('prismatic', 0),
        'y': ('prismatic', 1),
        'z': ('prismatic', 2),
        'yaw': ('continuous', 2),
        'pitch': ('continuous', 1),
        'roll': ('continuous', 0),
    },
    'ball': {
        'yaw': ('continuous', 2),
        'pitch': ('continuous', 1),
        'roll': ('continuous', 0),
    },
    'universal': {'qx': ('continuous', 0), 'qy': ('continuous', 1)},
}
_STAYS = RigidTransform()


class JointedLinks:
    """Links of a robot over its independent joints; ``Kinematics`` documents the attributes.

    A link that is named as the world is a link here.
    """

    def __init__(self, robot: LinkTree):
        """Build from a URDF; ValueError unless supported joints form one tree of its links."""
        root = _root(robot)
        joints = parents_first(robot.joints, root)
        leader = _mimicked(robot)
        independent = [
            part for j in robot.joints for part in parts_of(j) if leader[part.name][0] == part.name
        ]
        limits = [(j.lower, j.upper, j.max_speed) for j in independent]

        self.name: str = robot.name
        self.joint_names = tuple(j.name for j in independent)
        # Whether the value of each is an angle [rad], not a length [m].
        self.are_angles = tuple(j.type != 'prismatic' for j in independent)
        self.lower, self.upper, self.max_speed = np.array(limits, dtype=float).reshape(-1, 3).T
        self.link_names = (root, *(j.child for j in joints))
        self.joined_links = tuple((j.parent, j.child) for j in joints)
        self._free_above = _free_above(joints, root)
        self.tree = self._tree(joints, leader)

    def _tree(
        self, joints: list[UrdfJoint], leader: dict[str, tuple[str, float, float]]
    ) -> JointTree:
        rows: list[tuple[UrdfJoint, int, int]] = []
        link_rows = {name: row for row, name in enumerate(self.link_names)}
        leaders = {name: row for row, name in enumerate(self.joint_names)}
        beyond = len(self.link_names)  # the links between the parts of a joint have no name
        for joint in joints:
            *before, last = parts_of(joint)
            parent = link_rows[joint.parent]
            for part in before:
                rows.append((part, parent, beyond))
                parent, beyond = beyond, beyond + 1
            rows.append((last, parent, link_rows[joint.child]))
        led = [leader[j.name] for j, _, _ in rows]
        return JointTree(
            leaders=np.array([leaders.get(name, -1) for name, _, _ in led], dtype=np.int64),
            multipliers=np.array([multiplier for _, multiplier, _ in led], dtype=float),
            offsets=np.array([offset for _, _, offset in led], dtype=float),
            kinds=np.array(
                [_KINDS.get(j.type, JointKind.FIXED) for j, _, _ in rows], dtype=np.int64
            ),
            axes=np.array([_unit_axis(j) for j, _, _ in rows], dtype=float).reshape(-1, 3),
            X_PJs=_poses([j.X_PJ for j, _, _ in rows]),
            parents=np.array([parent for _, parent, _ in rows], dtype=np.int64),
            children=np.array([child for _, _, child in rows], dtype=np.int64),
        )

    def placed_links(self, positioned_joints: Collection[str]) -> list[int]:
        """Return the rows of ``link_names`` whose poses are defined if these joints have values.

        Links below a planar or floating joint that lacks a value may be anywhere and are left
        out. Other joints without a value stand at rest, at 0 or at their limit nearest to 0.
        """
        return [
            row
            for row, link in enumerate(self.link_names)
            if all(name in positioned_joints for name in self._free_above[link])
        ]

    def at_rest(self, configuration: Mapping[str, float]) -> NDArray[np.float64]:
        """Return joint values (joints,) of a configuration; others are 0 or the nearest limit."""
        q: NDArray[np.float64] = np.clip(0.0, self.lower, self.upper)
        for name, value in configuration.items():
            q[self.joint_names.index(name)] = value
        return q

    def poses_at(
        self, configuration: Mapping[str, float], X_PB: RigidTransform
    ) -> dict[str, RigidTransform]:
        """Return X_PL by name of the links whose joints all have a value; B is the root link."""
        q, needs = self.at_rest(configuration), self.tree.needs()
        X_PLs = self.tree.link_poses(q[np.newaxis], X_PB.ToArray())[0]
        return {
            link: RigidTransform.FromArray(X_PLs[row])
            for row, link in enumerate(self.link_names)
            if all(self.joint_names[c] in configuration for c in np.flatnonzero(needs[row]))
        }


def _poses(X_PJs: list[RigidTransform]) -> NDArray[np.float64]:
    """Return poses (n, 7) as ``ToArray`` has them, of thousands at once."""
    Rs = np.array([X_PJ.rotation().matrix() for X_PJ in X_PJs]).reshape(-1, 3, 3)
    ps = np.array([X_PJ.translation() for X_PJ in X_PJs]).reshape(-1, 3)
    return poses_from_matrices(Rs, ps)


def _root(robot: LinkTree) -> str:
    """Return the name of the one link that no joint has as its child."""
    roots = root_links(robot.joints, robot.links)
    if len(roots) != 1:
        raise ValueError(f'{robot.name}: links must form one tree; roots are {roots}')
    return roots[0]


def parts_of(joint: UrdfJoint) -> list[UrdfJoint]:
    """Return a chain of joints of at most one value each that is equivalent to a joint."""
    if joint.parts:
        return list(joint.parts)
    if joint.type not in SEVERAL:
        return [joint]
    free = replace(joint, lower=-math.inf, upper=math.inf, max_speed=math.inf, X_PJ=_STAYS)
    R_JA = _turn_from_z(_unit_axis(joint)) if joint.type == 'planar' else np.eye(3)
    parts = []
    for name, (kind, axis) in SEVERAL[joint.type].items():
        x, y, z = R_JA[:, axis].tolist()
        parts.append(replace(free, name=f'{joint.name}/{name}', type=kind, axis=(x, y, z)))
    return [replace(parts[0], X_PJ=joint.X_PJ), *parts[1:]]


def _turn_from_z(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation (3, 3) that takes z to a unit axis by the shortest way, -z about x."""
    x, y, z = axis
    if z < 0.0:
        return _turn_from_z(-axis) @ np.diag([1.0, -1.0, -1.0])
    # Rodrigues' formula for the rotation about z x axis, whose sine and cosine are x, y and z.
    f = 1.0 / (1.0 + z)
    return np.array([[1 - f * x * x, -f * x * y, x], [-f * x * y, 1 - f * y * y, y], [-x, -y, z]])


def _free_above(joints: list[UrdfJoint], root: str) -> dict[str, tuple[str, ...]]:
    """Return by link the values of planar and floating joints above it, which define its pose."""
    values: dict[str, tuple[str, ...]] = {root: ()}
    for joint in joints:
        own = [p.name for p in parts_of(joint) if p.type != 'fixed']
        own = own if joint.type in SEVERAL else []
        values[joint.child] = (*values[joint.parent], *own)
    return values


def _mimicked(robot: LinkTree) -> dict[str, tuple[str, float, float]]:
    """Return ``(leader, multiplier, offset)`` by single joint; that of a fixed one is empty."""
    by_name = {joint.name: joint for joint in robot.joints}
    for joint in robot.joints:
        _check_type(joint)
    parts = [part for joint in robot.joints for part in parts_of(joint)]
    names = Counter(part.name for part in parts)
    if twice := [name for name, count in names.items() if count > 1]:
        raise ValueError(f'{robot.name}: {twice[0]!r} is a joint, and a value of another one')
    singles = {part.name: part for part in parts}
    leaders = by_name | singles
    return {part.name: _leader(part, leaders) for part in singles.values()}


def _check_type(joint: UrdfJoint) -> None:
    allowed = (*_MOVING, 'fixed', *SEVERAL)
    if joint.type not in allowed and not joint.parts:
        raise ValueError(
            f'{joint.where.file}: joint {joint.name} has type {joint.type!r}; '
            f'allowed are {", ".join(allowed)}'
        )
    if joint.type in SEVERAL and joint.mimic is not None:
        raise ValueError(
            f'{joint.where.file}: joint {joint.name} is {joint.type} and mimics '
            f'{joint.mimic.joint!r}; only a joint of one value can'
        )


def _leader(joint: UrdfJoint, by_name: Mapping[str, UrdfJoint]) -> tuple[str, float, float]:
    """Return the joint that a single joint follows, itself if none, with multiplier and offset."""
    if joint.type == 'fixed':
        return '', 0.0, 0.0
    name, multiplier, offset = joint.name, 1.0, 0.0
    passed = {name}
    while (mimic := by_name[name].mimic) is not None:
        if mimic.joint not in by_name or mimic.joint in passed:
            raise ValueError(
                f'{joint.where.file}: joint {name} mimics {mimic.joint!r}, which is '
                f'{"itself mimicking it" if mimic.joint in passed else "not a joint"}'
            )
        offset += multiplier * mimic.offset
        multiplier *= mimic.multiplier
        name = mimic.joint
        passed.add(name)
        if (kind := by_name[name].type) not in _MOVING:
            raise ValueError(
                f'{joint.where.file}: joint {joint.name} mimics {name!r}, a {kind} joint'
            )
    return name, multiplier, offset


def _unit_axis(joint: UrdfJoint) -> NDArray[np.float64]:
    """Return the joint's axis with length 1."""
    axis = np.array(joint.axis)
    length = float(np.linalg.norm(axis))
    if joint.type in (*_MOVING, 'planar') and not length > 0.0:
        raise ValueError(f'joint {joint.name} has axis {joint.axis}; it must not be zero')
    return axis / length if length > 0.0 else axis
