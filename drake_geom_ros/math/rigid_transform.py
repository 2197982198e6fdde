"""``RigidTransform``: the pose of one frame in another."""

from __future__ import annotations

from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.arrays import as_vector, orthogonal
from drake_geom_ros.math.batched import matrices_from_poses, poses_from_matrices
from drake_geom_ros.math.quaternions import AngleAxis
from drake_geom_ros.math.rotations import RollPitchYaw, RotationMatrix


class RigidTransform:
    """A pose X_AB of frame B in frame A: ``p_AQ = X_AB @ p_BQ``.

    Made as in pydrake: from nothing (the identity), a rotation and a position p (3,) [m], either
    of them, or a matrix (3, 4) or (4, 4). A rotation is a ``RotationMatrix``, a ``RollPitchYaw``,
    an ``AngleAxis`` or a quaternion, see ``RotationMatrix``. ``FromArray`` takes seven numbers,
    x y z qx qy qz qw. Raises RuntimeError for anything else, or for numbers that are not finite.

        >>> X_WA = RigidTransform(RollPitchYaw(0, 0, 0.5), [1, 2, 3])
        >>> (X_WA.inverse() @ X_WA).IsNearlyIdentity(1e-15)
        True
    """

    __slots__ = ('_R', '_p')

    def __init__(
        self,
        *value: Any,
        p: ArrayLike | None = None,
        R: RotationMatrix | None = None,
        rpy: RollPitchYaw | None = None,
        quaternion: Any = None,
        theta_lambda: AngleAxis | None = None,
        pose: ArrayLike | None = None,
        other: RigidTransform | None = None,
    ) -> None:
        first, p = _split(value, p)
        values = (first, R, rpy, quaternion, theta_lambda, pose, other)
        present = [v for v in values if v is not None]
        if len(present) > 1:
            raise RuntimeError(
                'RigidTransform: give one of R, rpy, quaternion, theta_lambda, pose, other'
            )
        self._R, self._p = _parts(present[0] if present else RotationMatrix(), p)

    @staticmethod
    def Identity() -> RigidTransform:
        """Return the pose of a frame in itself."""
        return RigidTransform()

    @staticmethod
    def FromArray(xyz_qxqyqzqw: ArrayLike) -> RigidTransform:
        """Return the pose of seven numbers, x y z [m] and a unit quaternion qx qy qz qw."""
        Rs, ps = matrices_from_poses(np.asarray(xyz_qxqyqzqw)[None], 'pose')
        return RigidTransform._make(Rs[0], ps[0])

    def ToArray(self) -> Floats:
        """Return seven numbers, x y z [m] and a unit quaternion qx qy qz qw with qw >= 0."""
        return poses_from_matrices(self._R.matrix()[None], self._p[None]).reshape(7)

    @classmethod
    def _make(cls, R: Floats, p: Floats) -> RigidTransform:
        """Return the pose of R (3, 3) and p (3,), without copies and checks."""
        pose = cls.__new__(cls)
        p.flags.writeable = False
        pose._R, pose._p = RotationMatrix._make(R), p
        return pose

    def set(self, R: RotationMatrix, p: ArrayLike) -> None:
        """Set rotation R and position p (3,) [m]."""
        self._R, self._p = _parts(R, p)

    def SetIdentity(self) -> RigidTransform:
        """Set the identity, and return this pose."""
        self._R, self._p = _parts(RotationMatrix(), None)
        return self

    def set_rotation(
        self,
        R: Any = None,
        *,
        rpy: RollPitchYaw | None = None,
        quaternion: Any = None,
        theta_lambda: AngleAxis | None = None,
    ) -> None:
        """Set the rotation: a RotationMatrix, RollPitchYaw, quaternion or AngleAxis."""
        if R is rpy is quaternion is theta_lambda is None:
            raise RuntimeError('set_rotation: give one of R, rpy, quaternion, theta_lambda')
        self._R = RotationMatrix(R, rpy=rpy, quaternion=quaternion, theta_lambda=theta_lambda)

    def set_translation(self, p: ArrayLike) -> None:
        """Set the position p (3,) [m]."""
        self._R, self._p = _parts(self._R, p)

    def rotation(self) -> RotationMatrix:
        """Return R_AB."""
        return self._R

    def translation(self) -> Floats:
        """Return p_AB (3,) [m], read-only."""
        return self._p

    def GetAsMatrix34(self) -> Floats:
        """Return [R p], (3, 4)."""
        return np.column_stack((self._R.matrix(), self._p))

    def GetAsMatrix4(self) -> Floats:
        """Return [R p; 0 1], (4, 4)."""
        return np.vstack((self.GetAsMatrix34(), [0.0, 0.0, 0.0, 1.0]))

    def inverse(self) -> RigidTransform:
        """Return X_BA."""
        R_BA = self._R.matrix().T.copy()
        return RigidTransform._make(R_BA, -(R_BA @ self._p))

    def InvertAndCompose(self, other: RigidTransform) -> RigidTransform:
        """Return X_BC of this X_AB and the other X_AC."""
        R_BA = self._R.matrix().T
        R_BC = orthogonal(R_BA @ other._R.matrix())
        return RigidTransform._make(R_BC, R_BA @ (other._p - self._p))

    @overload
    def multiply(self, other: RigidTransform) -> RigidTransform: ...
    @overload
    def multiply(self, other: ArrayLike) -> Floats: ...
    @overload
    def multiply(self, *, p_BoQ_B: ArrayLike) -> Floats: ...
    @overload
    def multiply(self, *, vec_B: ArrayLike) -> Floats: ...
    def multiply(
        self,
        other: Any = None,
        *,
        p_BoQ_B: ArrayLike | None = None,
        vec_B: ArrayLike | None = None,
    ) -> Any:
        """Return X_AC for an X_BC, or p_AQ, of the same shape, for p_BQ (3,) or (3, n) [m].

        Four numbers (4,) are a point if the last is 1, and a direction, which is only rotated, if
        it is 0; other values raise RuntimeError.
        """
        operand = next((value for value in (other, p_BoQ_B, vec_B) if value is not None), None)
        R = self._R.matrix()
        if isinstance(operand, RigidTransform):
            R_AC = orthogonal(R @ operand._R.matrix())
            return RigidTransform._make(R_AC, self._p + R @ operand._p)
        p_BQ = np.asarray(operand, dtype=np.float64)
        if p_BQ.shape == (4,):
            return self._moved_by_kind(p_BQ)
        if p_BQ.ndim not in (1, 2) or p_BQ.shape[0] != 3:
            raise RuntimeError(
                f'RigidTransform: cannot move shape {p_BQ.shape}; give (3,), (3, n) or (4,)'
            )
        return (self._p + (R @ p_BQ).T).T

    def _moved_by_kind(self, vec_B: Floats) -> Floats:
        """Return a point or a direction (4,), depending on its last number, in A."""
        if vec_B[3] not in (0.0, 1.0):
            raise RuntimeError(f'RigidTransform: the last of {vec_B.tolist()} is not 0 or 1')
        return np.append(self._R.matrix() @ vec_B[:3] + vec_B[3] * self._p, vec_B[3])

    __matmul__ = multiply

    def IsExactlyIdentity(self) -> bool:
        """Return whether this is the identity to the last bit."""
        return self._R.IsExactlyIdentity() and not self._p.any()

    def IsNearlyIdentity(self, translation_tolerance: float) -> bool:
        """Return whether p is within ``translation_tolerance`` [m] of 0 and R is nearly I."""
        return self._R.IsNearlyIdentity() and bool(np.abs(self._p).max() <= translation_tolerance)

    def IsExactlyEqualTo(self, other: RigidTransform) -> bool:
        """Return whether the two poses are the same to the last bit."""
        return self.GetMaximumAbsoluteDifference(other) == 0.0

    def IsNearlyEqualTo(self, other: RigidTransform, tolerance: float) -> bool:
        """Return whether no element of [R p] differs by more than ``tolerance``."""
        return self.GetMaximumAbsoluteDifference(other) <= tolerance

    def GetMaximumAbsoluteDifference(self, other: RigidTransform) -> float:
        """Return the largest difference of any element of [R p]."""
        return float(np.abs(self.GetAsMatrix34() - other.GetAsMatrix34()).max())

    def GetMaximumAbsoluteTranslationDifference(self, other: RigidTransform) -> float:
        """Return the largest difference of any element of p [m]."""
        return float(np.abs(self._p - other._p).max())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RigidTransform):
            return NotImplemented
        return self._R == other._R and np.array_equal(self._p, other._p)

    def __repr__(self) -> str:
        R = repr(self._R).replace('\n', '\n  ')
        return f'RigidTransform(\n  R={R},\n  p={self._p.tolist()},\n)'


def _split(value: tuple[Any, ...], p: ArrayLike | None) -> tuple[Any, ArrayLike | None]:
    """Sort positional arguments into a rotation or pose, and a position."""
    if len(value) > 2 or (len(value) == 2 and p is not None):
        raise RuntimeError('RigidTransform: give at most a rotation and one position')
    if len(value) == 2:
        return value
    if len(value) == 1 and p is None and np.shape(value[0]) in ((3,), (3, 1), (1, 3)):
        return None, value[0]
    return (value[0] if value else None), p


def _parts(value: Any, p: ArrayLike | None) -> tuple[RotationMatrix, Floats]:
    """Return rotation and position of a rotation, or of a pose when ``p`` is None."""
    if isinstance(value, RigidTransform) and p is None:
        return value._R, value._p
    matrix = None
    if isinstance(value, (np.ndarray, list, tuple)) and np.shape(value) in ((3, 4), (4, 4)):
        matrix = np.array(value, dtype=np.float64)
        if p is not None or (matrix.shape == (4, 4) and matrix[3].tolist() != [0, 0, 0, 1]):
            raise RuntimeError(f'RigidTransform: {matrix.tolist()} is not [R p; 0 0 0 1]')
        value, p = matrix[:3, :3], matrix[:3, 3]
    elif not isinstance(value, (RotationMatrix, RollPitchYaw, AngleAxis)) and np.shape(value) == (
        3,
        3,
    ):
        raise RuntimeError('RigidTransform: give the rotation as RotationMatrix(R)')
    position = np.zeros(3) if p is None else as_vector(p, 'RigidTransform: p')
    position.flags.writeable = False
    return RotationMatrix(value), position
