"""Forward kinematics of a URDF tree, vectorised over joints and over configurations."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry.queries.joint_trees import JointKind
from drake_geom_ros.scene_files.jointed_links import JointedLinks
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.scene_files.urdf_tree import read_link_tree
from drake_geom_ros.trajectories import autodiff_kinematics
from drake_geom_ros.trajectories.pose_matrices import matrices_of_poses, poses_of_matrices


class Kinematics(JointedLinks):
    """Poses and Jacobians of a robot's links by its independent joints; mimic joints follow.

    ``joined_links`` are the two links of each joint, fixed ones included; ``tree`` is the
    kinematic tree as arrays, whose first links are those of ``link_names``.

    A planar joint has three values, ``joint/x`` and ``joint/y`` [m] in the plane and
    ``joint/theta`` [rad] about its axis. For the axis z they are along x and y; for another axis
    all three are rotated the shortest way from z to it. A floating joint has six, ``joint/x``,
    ``joint/y``, ``joint/z`` [m], ``joint/yaw``, ``joint/pitch`` and ``joint/roll`` [rad], with the
    rotation of ``RollPitchYaw``. These values have neither limits nor a rest value: see
    ``placed_links``.

    The URDF is parsed as in a scene file. A link with the name of the world is an ordinary link.
    """

    def __init__(self, urdf: str | LinkTree):
        """Read the URDF at a path, or use the links and joints of a scene file.

        Raises ValueError unless it is a tree of simple joints, and SceneFileError, with the line,
        for an invalid URDF and for a link with two parents.
        """
        super().__init__(urdf if isinstance(urdf, LinkTree) else read_link_tree(urdf))

    def link_transforms(self, q: ArrayLike, X_WB: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return X_WL of every link (..., links, 4, 4) for configurations q (..., joints).

        Positions in [m] and angles in [rad], in the order of ``joint_names``; links in the order
        of ``link_names``, the base link B first. ``X_WB`` (4, 4) places it (default: identity).

        For joint values (joints,) of AutoDiffXd the transforms are of AutoDiffXd, in the form that
        ``RigidTransform_[AutoDiffXd]`` takes. ``X_WB`` must be of floats.
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
        """Return X_WL (links, 4, 4) of AutoDiffXd; raises ValueError for other shapes of q."""
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
        that of the link's origin, as in ``SignedDistanceResults.jacobian_by_frames``. Joints are
        in the order of ``joint_names``, links in that of ``link_names``; arguments are those of
        ``link_transforms``. Raises ValueError for AutoDiffXd, which has no second derivatives:
        pass the values, by ExtractValue.
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
