"""Forward kinematics of a URDF tree, vectorised over joints and over configurations."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry.queries.joint_trees import JointKind, JointTree
from drake_geom_ros.scene_files.urdf_tree import LinkTree, UrdfJoint, read_link_tree, root_links
from drake_geom_ros.trajectories import autodiff_kinematics
from drake_geom_ros.trajectories.pose_matrices import matrices_of_poses, poses_of_matrices

_KINDS = {
    'revolute': JointKind.REVOLUTE,
    'continuous': JointKind.REVOLUTE,
    'prismatic': JointKind.PRISMATIC,
}
_MOVING = tuple(_KINDS)


class Kinematics:
    """The links of a robot over its independent joints; mimic joints follow their leader.

    ``joined_links`` are the two links of each joint, fixed ones too; ``tree`` is all that a pose
    of a link depends on, as arrays.

    The URDF is read as that of a scene file is. A link called as the world is a link here.
    """

    def __init__(self, urdf_path: str):
        """Read the URDF at a path; raises ValueError for what is not a tree of simple joints.

        Raises SceneFileError, with the line, for what is no URDF, and for a link with two parents.
        """
        robot = read_link_tree(urdf_path)
        root = _root(robot)
        joints = _parents_first(robot, root)
        leader = _mimicked(robot, urdf_path)
        independent = [j for j in robot.joints if leader[j.name][0] == j.name]
        limits = [(j.lower, j.upper, j.max_speed) for j in independent]

        self.name: str = robot.name
        self.joint_names = tuple(j.name for j in independent)
        self.lower, self.upper, self.max_speed = np.array(limits, dtype=float).reshape(-1, 3).T
        self.link_names = (root, *(j.child for j in joints))
        self.joined_links = tuple((j.parent, j.child) for j in joints)

        self.tree = JointTree(
            leaders=np.array([self._leader(leader[j.name][0]) for j in joints], dtype=np.int64),
            multipliers=np.array([leader[j.name][1] for j in joints], dtype=float),
            offsets=np.array([leader[j.name][2] for j in joints], dtype=float),
            kinds=np.array([_KINDS.get(j.type, JointKind.FIXED) for j in joints], dtype=np.int64),
            axes=np.array([_unit_axis(j) for j in joints], dtype=float).reshape(-1, 3),
            X_PJs=np.array([j.X_PJ.ToArray() for j in joints]).reshape(-1, 7),
            parents=np.array([self.link_names.index(j.parent) for j in joints], dtype=np.int64),
            children=np.arange(1, len(joints) + 1),
        )

    def _leader(self, name: str) -> int:
        """Return which independent joint a name is of; -1 for the empty one of a fixed joint."""
        return self.joint_names.index(name) if name else -1

    def link_transforms(self, q: ArrayLike, X_WB: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return X_WL of every link (..., links, 4, 4) for configurations q (..., joints).

        Positions in [m] and angles in [rad], in the order of ``joint_names``; links in the order
        of ``link_names``, the base link B first. ``X_WB`` (4, 4) places it (default: identity).

        Of joint values (joints,) of AutoDiffXd so are the transforms, as
        ``RigidTransform_[AutoDiffXd]`` takes them. ``X_WB`` is of numbers.
        """
        if autodiff_kinematics.is_of_autodiff(q, X_WB):
            return self._of_autodiff(q, X_WB)
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
        X_WLs, tree = self.link_transforms(q, X_WB), self.tree
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
        return Js


def _root(robot: LinkTree) -> str:
    """Return the name of the one link that no joint has as its child."""
    roots = root_links(robot.joints, robot.links)
    if len(roots) != 1:
        raise ValueError(f'{robot.name}: links must form one tree; roots are {roots}')
    return roots[0]


def _parents_first(robot: LinkTree, root: str) -> list[UrdfJoint]:
    """Return the joints so that each one's parent link is the root or a child of one before."""
    placed = {root}
    ordered: list[UrdfJoint] = []
    waiting = list(robot.joints)
    while waiting:
        ready = [j for j in waiting if j.parent in placed]
        ordered += ready
        placed |= {j.child for j in ready}
        waiting = [j for j in waiting if j.child not in placed]
    return ordered


def _mimicked(robot: LinkTree, urdf_path: str) -> dict[str, tuple[str, float, float]]:
    """Return ``(leader, multiplier, offset)`` of each joint, for a fixed one an empty leader."""
    by_name = {j.name: j for j in robot.joints}
    found: dict[str, tuple[str, float, float]] = {}
    for joint in robot.joints:
        if joint.type not in (*_MOVING, 'fixed'):
            raise ValueError(
                f'{urdf_path}: joint {joint.name} has type {joint.type!r}; '
                f'allowed are {", ".join((*_MOVING, "fixed"))}'
            )
        if joint.type == 'fixed':
            found[joint.name] = ('', 0.0, 0.0)
            continue
        name, multiplier, offset = joint.name, 1.0, 0.0
        passed = {name}
        while (mimic := by_name[name].mimic) is not None:
            if mimic.joint not in by_name or mimic.joint in passed:
                raise ValueError(
                    f'{urdf_path}: joint {name} mimics {mimic.joint!r}, which is '
                    f'{"itself mimicking it" if mimic.joint in passed else "not a joint"}'
                )
            offset += multiplier * mimic.offset
            multiplier *= mimic.multiplier
            name = mimic.joint
            passed.add(name)
            if by_name[name].type == 'fixed':
                raise ValueError(f'{urdf_path}: joint {joint.name} mimics {name!r}, a fixed joint')
        found[joint.name] = (name, multiplier, offset)
    return found


def _unit_axis(joint: UrdfJoint) -> NDArray[np.float64]:
    """Return the joint's axis with length 1."""
    axis = np.array(joint.axis)
    length = float(np.linalg.norm(axis))
    if joint.type in _MOVING and not length > 0.0:
        raise ValueError(f'joint {joint.name} has axis {joint.axis}; it must not be zero')
    return axis / length if length > 0.0 else axis
