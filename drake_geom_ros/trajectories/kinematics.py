"""Forward kinematics of a URDF tree, vectorised over joints and over configurations."""

import math
from collections import Counter
from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry.queries.joint_trees import JointKind, JointTree
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.scene_files.urdf_tree import parents_first, read_link_tree, root_links
from drake_geom_ros.trajectories import autodiff_kinematics
from drake_geom_ros.trajectories.pose_matrices import matrices_of_poses, poses_of_matrices

_KINDS = {
    'revolute': JointKind.REVOLUTE,
    'continuous': JointKind.REVOLUTE,
    'prismatic': JointKind.PRISMATIC,
}
_MOVING = tuple(_KINDS)
# Of joints of several values: what each value does, and about or along which axis of the joint.
_SEVERAL = {
    'planar': {'x': ('prismatic', 0), 'y': ('prismatic', 1), 'theta': ('continuous', 2)},
    'floating': {
        'x': ('prismatic', 0),
        'y': ('prismatic', 1),
        'z': ('prismatic', 2),
        'yaw': ('continuous', 2),
        'pitch': ('continuous', 1),
        'roll': ('continuous', 0),
    },
}
_STAYS = RigidTransform()


class Kinematics:
    """The links of a robot over its independent joints; mimic joints follow their leader.

    ``joined_links`` are the two links of each joint, fixed ones too; ``tree`` is all that a pose
    of a link depends on, as arrays; its first links are those of ``link_names``.

    A planar joint has three values, ``joint/x`` and ``joint/y`` [m] in the plane and
    ``joint/theta`` [rad] about its axis: of the axis z these are along x and y, and with another
    one all three are turned the shortest way from z to it. A floating joint has six, ``joint/x``,
    ``joint/y``, ``joint/z`` [m], ``joint/yaw``, ``joint/pitch`` and ``joint/roll`` [rad], the
    rotation being that of ``RollPitchYaw``. None has limits, and none has a value at rest: see
    ``placed_links``.

    The URDF is read as that of a scene file is. A link called as the world is a link here.
    """

    def __init__(self, urdf: str | LinkTree):
        """Read the URDF at a path, or take the links and joints that a scene file gave.

        Raises ValueError for what is not a tree of simple joints, and SceneFileError, with the
        line, for what is no URDF, and for a link with two parents.
        """
        robot = urdf if isinstance(urdf, LinkTree) else read_link_tree(urdf)
        root = _root(robot)
        joints = parents_first(robot.joints, root)
        leader = _mimicked(robot)
        independent = [
            part for j in robot.joints if leader[j.name][0] == j.name for part in _parts(j)
        ]
        limits = [(j.lower, j.upper, j.max_speed) for j in independent]
        names = Counter(j.name for j in independent)
        if twice := [name for name, count in names.items() if count > 1]:
            raise ValueError(f'{robot.name}: {twice[0]!r} is a joint, and a value of another one')

        self.name: str = robot.name
        self.joint_names = tuple(j.name for j in independent)
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
            *before, last = _parts(joint)
            parent = link_rows[joint.parent]
            for part in before:
                rows.append((part, parent, beyond))
                parent, beyond = beyond, beyond + 1
            rows.append((last, parent, link_rows[joint.child]))
        led = [leader.get(j.name, (j.name, 1.0, 0.0)) for j, _, _ in rows]
        return JointTree(
            leaders=np.array([leaders.get(name, -1) for name, _, _ in led], dtype=np.int64),
            multipliers=np.array([multiplier for _, multiplier, _ in led], dtype=float),
            offsets=np.array([offset for _, _, offset in led], dtype=float),
            kinds=np.array(
                [_KINDS.get(j.type, JointKind.FIXED) for j, _, _ in rows], dtype=np.int64
            ),
            axes=np.array([_unit_axis(j) for j, _, _ in rows], dtype=float).reshape(-1, 3),
            X_PJs=np.array([j.X_PJ.ToArray() for j, _, _ in rows]).reshape(-1, 7),
            parents=np.array([parent for _, parent, _ in rows], dtype=np.int64),
            children=np.array([child for _, _, child in rows], dtype=np.int64),
        )

    def placed_links(self, given: Collection[str]) -> list[int]:
        """Return which links of ``link_names`` stand somewhere when these joints have values.

        Below a planar or floating joint that lacks a value of its own a link may be anywhere, and
        is left out; other joints stand at rest, at 0 or at their limit nearest to 0.
        """
        return [
            row
            for row, link in enumerate(self.link_names)
            if all(name in given for name in self._free_above[link])
        ]

    def link_transforms(self, q: ArrayLike, X_WB: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return X_WL of every link (..., links, 4, 4) for configurations q (..., joints).

        Positions in [m] and angles in [rad], in the order of ``joint_names``; links in the order
        of ``link_names``, the base link B first. ``X_WB`` (4, 4) places it (default: identity).

        Of joint values (joints,) of AutoDiffXd so are the transforms, as
        ``RigidTransform_[AutoDiffXd]`` takes them. ``X_WB`` is of numbers.
        """
        if autodiff_kinematics.is_of_autodiff(q, X_WB):
            return self._of_autodiff(q, X_WB)
        X_WLs = self._all_transforms(q, X_WB)
        return X_WLs[..., : len(self.link_names), :, :]

    def _all_transforms(self, q: ArrayLike, X_WB: ArrayLike | None) -> NDArray[np.float64]:
        """Return X_WL of all links of ``tree``, those without a name last."""
        q = np.asarray(q, dtype=float)
        if q.shape[-1:] != (len(self.joint_names),):
            raise ValueError(
                f'{self.name}: q must have shape (..., {len(self.joint_names)}), one value each '
                f'for {", ".join(self.joint_names)}; got {q.shape}'
            )
        base = poses_of_matrices(np.eye(4) if X_WB is None else X_WB)
        rows = q.reshape(math.prod(q.shape[:-1]), q.shape[-1])
        X_WLs = self.tree.link_poses(rows, base)
        return matrices_of_poses(X_WLs.reshape(*q.shape[:-1], *X_WLs.shape[1:]))

    def _of_autodiff(self, q: Any, X_WB: Any) -> NDArray[Any]:
        """Return X_WL (links, 4, 4) of AutoDiffXd; raises ValueError where it cannot."""
        if autodiff_kinematics.is_of_autodiff(X_WB):
            raise ValueError(
                f'{self.name}: X_WB must be of numbers. Of a base that moves take X_BL from here, '
                'with X_WB left out, and multiply RigidTransform_[AutoDiffXd](X_WB) by each'
            )
        values, rates = autodiff_kinematics.values_and_rates(q, len(self.joint_names))
        X_WLs, Js = self.link_transforms(values, X_WB), self.link_jacobians(values, X_WB)
        return autodiff_kinematics.transforms(X_WLs, Js, rates)

    def link_jacobians(self, q: ArrayLike, X_WB: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return J_WL of every link (..., links, 6, joints): its spatial velocity is J_WL @ qdot.

        Spatial velocities are [w_WL, v_WLo], angular before linear, in World axes, the linear part
        that of the link's origin: what ``SignedDistanceResults.jacobian_by_frames`` takes. Joints
        in the order of ``joint_names``, links in that of ``link_names``, arguments as of
        ``link_transforms``. Raises ValueError for AutoDiffXd, whose second derivatives are not
        kept: take the values, by ExtractValue.
        """
        if autodiff_kinematics.is_of_autodiff(q, X_WB):
            raise ValueError(
                f'{self.name}: link_jacobians takes numbers: ExtractValue(q)[:, 0] are those of '
                'AutoDiffXd. Derivatives of the transforms come with link_transforms(q)'
            )
        X_WLs, tree = self._all_transforms(q, X_WB), self.tree
        p_WLs = X_WLs[..., :3, 3]
        Js = np.zeros((*X_WLs.shape[:-2], 6, len(self.joint_names)))
        for joint, (parent, link) in enumerate(zip(tree.parents, tree.children, strict=True)):
            # The parent's velocity at the child's origin, and the joint's own.
            arms = (p_WLs[..., link, :] - p_WLs[..., parent, :])[..., None]
            Js[..., link, :, :] = Js[..., parent, :, :]
            Js[..., link, 3:, :] += np.cross(Js[..., parent, :3, :], arms, axis=-2)
            if tree.kinds[joint] != JointKind.FIXED:
                axis_W = X_WLs[..., link, :3, :3] @ (tree.multipliers[joint] * tree.axes[joint])
                part = slice(0, 3) if tree.kinds[joint] == JointKind.REVOLUTE else slice(3, 6)
                Js[..., link, part, tree.leaders[joint]] += axis_W
        return Js[..., : len(self.link_names), :, :]


def _root(robot: LinkTree) -> str:
    """Return the name of the one link that no joint has as its child."""
    roots = root_links(robot.joints, robot.links)
    if len(roots) != 1:
        raise ValueError(f'{robot.name}: links must form one tree; roots are {roots}')
    return roots[0]


def _parts(joint: UrdfJoint) -> list[UrdfJoint]:
    """Return joints of one value each, one after another, that together do what a joint does."""
    if joint.type not in _SEVERAL:
        return [joint]
    free = replace(joint, lower=-math.inf, upper=math.inf, max_speed=math.inf, X_PJ=_STAYS)
    R_JA = _turn_from_z(_unit_axis(joint)) if joint.type == 'planar' else np.eye(3)
    parts = []
    for name, (kind, axis) in _SEVERAL[joint.type].items():
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
    """Return of each link the values that have to be known before it stands anywhere."""
    found: dict[str, tuple[str, ...]] = {root: ()}
    for joint in joints:
        own = [part.name for part in _parts(joint)] if joint.type in _SEVERAL else []
        found[joint.child] = (*found[joint.parent], *own)
    return found


def _mimicked(robot: LinkTree) -> dict[str, tuple[str, float, float]]:
    """Return ``(leader, multiplier, offset)`` of each joint, for a fixed one an empty leader."""
    by_name = {j.name: j for j in robot.joints}
    found: dict[str, tuple[str, float, float]] = {}
    for joint in robot.joints:
        if joint.type not in (*_MOVING, 'fixed', *_SEVERAL):
            raise ValueError(
                f'{joint.where.file}: joint {joint.name} has type {joint.type!r}; '
                f'allowed are {", ".join((*_MOVING, "fixed", *_SEVERAL))}'
            )
        if joint.type in _SEVERAL:
            if joint.mimic is not None:
                raise ValueError(
                    f'{joint.where.file}: joint {joint.name} is {joint.type} and mimics '
                    f'{joint.mimic.joint!r}; only a joint of one value can'
                )
            found[joint.name] = (joint.name, 1.0, 0.0)
            continue
        if joint.type == 'fixed':
            found[joint.name] = ('', 0.0, 0.0)
            continue
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
        found[joint.name] = (name, multiplier, offset)
    return found


def _unit_axis(joint: UrdfJoint) -> NDArray[np.float64]:
    """Return the joint's axis with length 1."""
    axis = np.array(joint.axis)
    length = float(np.linalg.norm(axis))
    if joint.type not in ('fixed', 'floating') and not length > 0.0:
        raise ValueError(f'joint {joint.name} has axis {joint.axis}; it must not be zero')
    return axis / length if length > 0.0 else axis
