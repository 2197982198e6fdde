"""Rotations and poses of AutoDiffXd, as ``drake_geom_ros.math`` has them for floats."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.autodiffutils.arrays import values_of
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix

Objects = NDArray[np.object_]


class RollPitchYawAutoDiffXd:
    """Three angles [rad] about fixed axes: roll about x, then pitch about y, yaw about z."""

    def __init__(self, roll: Any, pitch: Any = None, yaw: Any = None) -> None:
        angles = roll if pitch is None else [roll, pitch, yaw]
        if isinstance(angles, RollPitchYaw):
            angles = angles.vector()
        self._rpy = _vector(angles, 'RollPitchYaw: rpy')

    def vector(self) -> Objects:
        """Return roll, pitch, yaw (3,) [rad]."""
        return self._rpy.copy()

    def ToRotationMatrix(self) -> RotationMatrixAutoDiffXd:
        """Return R = Rz(yaw) Ry(pitch) Rx(roll)."""
        make = RotationMatrixAutoDiffXd
        roll, pitch, yaw = self._rpy
        turned = make.MakeZRotation(yaw) @ make.MakeYRotation(pitch)
        product: RotationMatrixAutoDiffXd = turned @ make.MakeXRotation(roll)
        return product


class RotationMatrixAutoDiffXd:
    """A rotation R_AB of numbers with derivatives: a ``RotationMatrix`` of AutoDiffXd.

    Made from nothing, a matrix (3, 3), roll, pitch and yaw, a quaternion w x y z (4,) of unit
    length, or a ``RotationMatrix``. Raises RuntimeError if the values are no rotation.
    """

    def __init__(self, R: Any = None) -> None:
        if isinstance(R, RotationMatrixAutoDiffXd):
            R = R._R
        elif isinstance(R, (RollPitchYawAutoDiffXd, RollPitchYaw)):
            R = R.ToRotationMatrix().matrix()
        elif hasattr(R, 'matrix'):
            R = R.matrix()
        elif np.shape(R) == (4,):
            R = _of_quaternion(R)
        matrix = np.array(np.eye(3) if R is None else R, dtype=object)
        RotationMatrix(values_of(matrix))  # raises if it is no rotation
        self._R: Objects = matrix

    @classmethod
    def _make(cls, R: Objects) -> RotationMatrixAutoDiffXd:
        rotation = cls.__new__(cls)
        rotation._R = R
        return rotation

    @staticmethod
    def Identity() -> RotationMatrixAutoDiffXd:
        """Return the identity."""
        return RotationMatrixAutoDiffXd()

    @staticmethod
    def MakeXRotation(theta: Any) -> RotationMatrixAutoDiffXd:
        """Return the rotation by ``theta`` [rad] about x."""
        return _about_axis(0, theta)

    @staticmethod
    def MakeYRotation(theta: Any) -> RotationMatrixAutoDiffXd:
        """Return the rotation by ``theta`` [rad] about y."""
        return _about_axis(1, theta)

    @staticmethod
    def MakeZRotation(theta: Any) -> RotationMatrixAutoDiffXd:
        """Return the rotation by ``theta`` [rad] about z."""
        return _about_axis(2, theta)

    def matrix(self) -> Objects:
        """Return the matrix (3, 3)."""
        return self._R.copy()

    def inverse(self) -> RotationMatrixAutoDiffXd:
        """Return R_BA."""
        return RotationMatrixAutoDiffXd._make(self._R.T.copy())

    transpose = inverse

    def multiply(self, other: Any) -> Any:
        """Return R_AC for an R_BC, or v_A, of the same shape, for v_B (3,) or (3, n)."""
        if isinstance(other, (RotationMatrixAutoDiffXd, RotationMatrix)):
            return RotationMatrixAutoDiffXd._make(self._R @ other.matrix().astype(object))
        return self._R @ np.asarray(other, dtype=object)

    __matmul__ = multiply


class RigidTransformAutoDiffXd:
    """A pose X_AB of numbers with derivatives: a ``RigidTransform`` of AutoDiffXd.

    Made from nothing, a rotation and a position p (3,) [m], either of them, a matrix (3, 4) or
    (4, 4), or a ``RigidTransform``; a rotation is anything that ``RotationMatrix_[AutoDiffXd]``
    takes. Raises RuntimeError if the values are no pose.
    """

    def __init__(self, value: Any = None, p: Any = None) -> None:
        if p is None and np.shape(value) in ((3,), (3, 1)):
            value, p = None, value
        if p is None and hasattr(value, 'GetAsMatrix34'):
            value = value.GetAsMatrix34()
        if p is None and np.shape(value) in ((3, 4), (4, 4)):
            matrix = np.asarray(value, dtype=object)
            value, p = matrix[:3, :3], matrix[:3, 3]
        self.set(RotationMatrixAutoDiffXd(value), np.zeros(3) if p is None else p)

    @classmethod
    def _make(cls, R: Objects, p: Objects) -> RigidTransformAutoDiffXd:
        pose = cls.__new__(cls)
        pose._R, pose._p = RotationMatrixAutoDiffXd._make(R), p
        return pose

    @staticmethod
    def Identity() -> RigidTransformAutoDiffXd:
        """Return the pose of a frame in itself."""
        return RigidTransformAutoDiffXd()

    def set(self, R: Any, p: Any) -> None:
        """Set rotation R and position p (3,) [m]."""
        self.set_rotation(R)
        self.set_translation(p)

    def set_rotation(self, R: Any) -> None:
        """Set the rotation."""
        self._R = RotationMatrixAutoDiffXd(R)

    def set_translation(self, p: Any) -> None:
        """Set the position p (3,) [m]."""
        self._p = _vector(p, 'RigidTransform: p')

    def rotation(self) -> RotationMatrixAutoDiffXd:
        """Return R_AB."""
        return self._R

    def translation(self) -> Objects:
        """Return p_AB (3,) [m]."""
        return self._p.copy()

    def GetAsMatrix34(self) -> Objects:
        """Return [R p], (3, 4)."""
        return np.column_stack((self._R.matrix(), self._p))

    def GetAsMatrix4(self) -> Objects:
        """Return [R p; 0 1], (4, 4)."""
        return np.vstack((self.GetAsMatrix34(), np.array([0.0, 0.0, 0.0, 1.0], dtype=object)))

    def inverse(self) -> RigidTransformAutoDiffXd:
        """Return X_BA."""
        R_BA = self._R.matrix().T.copy()
        return RigidTransformAutoDiffXd._make(R_BA, -(R_BA @ self._p))

    def InvertAndCompose(self, other: Any) -> RigidTransformAutoDiffXd:
        """Return X_BC of this X_AB and the other X_AC."""
        composed: RigidTransformAutoDiffXd = self.inverse() @ other
        return composed

    def multiply(self, other: Any) -> Any:
        """Return X_AC for an X_BC, or p_AQ, of the same shape, for p_BQ (3,) or (3, n) [m]."""
        R = self._R.matrix()
        if isinstance(other, (RigidTransformAutoDiffXd, RigidTransform)):
            R_BC = other.rotation().matrix().astype(object)
            return RigidTransformAutoDiffXd._make(R @ R_BC, self._p + R @ other.translation())
        return (self._p + (R @ np.asarray(other, dtype=object)).T).T

    __matmul__ = multiply


def _vector(value: Any, what: str) -> Objects:
    """Return three numbers as an array (3,) of objects; raises RuntimeError for others."""
    vector = np.array(value, dtype=object)
    if vector.shape == (3, 1):
        vector = vector[:, 0]
    if vector.shape != (3,) or not np.isfinite(values_of(vector)).all():
        raise RuntimeError(f'{what} = {value!r} is not three finite numbers')
    return vector


def _about_axis(axis: int, theta: Any) -> RotationMatrixAutoDiffXd:
    """Return the rotation about a coordinate axis."""
    c, s = np.cos(theta), np.sin(theta)
    R = np.eye(3).astype(object)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R[j, j], R[k, k], R[j, k], R[k, j] = c, c, -s, s
    return RotationMatrixAutoDiffXd._make(R)


def _of_quaternion(wxyz: Any) -> Objects:
    """Return the rotation matrix of a quaternion w x y z, which need not be of unit length."""
    w, x, y, z = np.asarray(wxyz, dtype=object)
    q = np.array([x, y, z], dtype=object)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]], dtype=object)
    two = 2.0 / (w * w + q @ q)
    turned: Objects = np.eye(3) + two * (w * cross + cross @ cross)
    return turned
