"""Poses with derivatives, and their conversion to and from poses with spatial velocities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from drake_geom_ros.autodiffutils.arrays import (
    autodiff_array,
    derivatives_of,
    scalar_type,
    values_of,
)
from drake_geom_ros.autodiffutils.transforms import RigidTransformAutoDiffXd
from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentTypeError, UnknownIdError
from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats


class FramePoseVectorAutoDiffXd:
    """Poses X_PF of frames in their parents, with derivatives.

    A pose is a ``RigidTransform_[AutoDiffXd]`` of this package or of pydrake.
    """

    def __init__(self, poses: Mapping[FrameId, Any] | None = None) -> None:
        self._poses: dict[FrameId, Any] = {}
        for frame_id, X_PF in (poses or {}).items():
            self.set_value(frame_id, X_PF)

    def set_value(self, id: FrameId, value: Any) -> None:
        """Set X_PF of a frame."""
        checked_type(id, FrameId, 'FramePoseVector.set_value: id')
        if isinstance(value, RigidTransform) or not hasattr(value, 'GetAsMatrix34'):
            raise ArgumentTypeError(
                f'FramePoseVector_[AutoDiffXd].set_value was given {value!r}; it takes a '
                'RigidTransform_[AutoDiffXd], which can be made of it.'
            )
        self._poses[id] = RigidTransformAutoDiffXd(value)

    def value(self, id: FrameId) -> RigidTransformAutoDiffXd:
        """Return X_PF of a frame; raises RuntimeError without a pose of it."""
        if id not in self._poses:
            raise UnknownIdError(f'FramePoseVector: no pose of {id!r} among {self.size()} frames')
        return RigidTransformAutoDiffXd(self._poses[id])

    def has_id(self, id: FrameId) -> bool:
        """Return whether the vector has a pose of the frame."""
        return id in self._poses

    def ids(self) -> list[FrameId]:
        """Return the ids of the frames, in the order of the poses."""
        return list(self._poses)

    frame_ids = ids

    def size(self) -> int:
        """Return the number of poses."""
        return len(self._poses)

    def clear(self) -> None:
        """Remove all poses."""
        self._poses.clear()

    def __len__(self) -> int:
        return len(self._poses)

    def scalar(self) -> Any:
        """Return the type of the numbers: that of the first one with derivatives."""
        return scalar_type(*(X.GetAsMatrix34() for X in self._poses.values()))

    def taken_apart(self) -> tuple[FramePoseVector, dict[int, Floats]]:
        """Return the poses, and V_PF (6, n) by id value: spatial velocities for each variable."""
        poses, velocities = {}, {}
        for frame, X in self._poses.items():
            matrix = X.GetAsMatrix34()
            values, rates = values_of(matrix), derivatives_of(matrix)
            poses[frame] = RigidTransform(RotationMatrix(values[:, :3]), values[:, 3])
            velocities[frame.get_value()] = _velocity(values[:, :3], rates)
        return FramePoseVector(poses), velocities


def _velocity(R: Floats, rates: Floats) -> Floats:
    """Return [w, v] (6, n) of R (3, 3) and the derivatives (3, 4, n) of [R p]: [w] = dR R^T.

    A dR of numbers that are not exactly orthogonal may leave the rotations; only its tangential
    part is used.
    """
    W = np.einsum('ijn,kj->ikn', rates[:, :3], R)
    w = 0.5 * np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]])
    return np.concatenate((w, rates[:, 3]))


def with_derivatives(X: RigidTransform, V: Floats, scalar: Any) -> RigidTransformAutoDiffXd:
    """Return a pose of numbers of a scalar type, from its spatial velocities V (6, n)."""
    matrix = X.GetAsMatrix34()
    rates = np.zeros((3, 4, V.shape[1]))
    for column in range(3):
        rates[:, column] = np.cross(V[:3], matrix[:, column, None], axis=0)
    rates[:, 3] = V[3:]
    return RigidTransformAutoDiffXd(autodiff_array(matrix, rates, scalar))
