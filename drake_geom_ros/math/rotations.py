"""``RotationMatrix`` and ``RollPitchYaw``."""

from __future__ import annotations

import math
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.arrays import as_vector, orthogonal, rotation_error
from drake_geom_ros.math.batched import quaternions_from_rotations, rotations_from_quaternions
from drake_geom_ros.math.quaternions import AngleAxis, Quaternion
from drake_geom_ros.math.tolerances import ALMOST_ROTATION, DIRECTION_NORM, ROTATION


class RotationMatrix:
    """A rotation R_AB, which takes a vector from B's axes to A's: ``v_A = R_AB @ v_B``.

    Made from nothing (the identity), a matrix (3, 3), a ``RollPitchYaw``, an ``AngleAxis`` or a
    unit quaternion: a ``Quaternion`` or an array w x y z in Drake's order. A matrix that deviates
    from orthogonal by at most ``ALMOST_ROTATION`` is replaced by the nearest rotation; products
    are made orthogonal in the same way, so errors do not grow. Raises RuntimeError for a matrix
    that is not a rotation or a quaternion that is not of unit length.

        >>> R_WA = RotationMatrix.MakeZRotation(math.pi / 2)
        >>> (R_WA @ [1, 0, 0]).round(9).tolist()
        [0.0, 1.0, 0.0]
    """

    __slots__ = ('_R',)

    def __init__(
        self,
        R: RotationMatrix | RollPitchYaw | ArrayLike | None = None,
        *,
        quaternion: Any = None,
        theta_lambda: AngleAxis | None = None,
        rpy: RollPitchYaw | None = None,
        other: RotationMatrix | None = None,
    ) -> None:
        values = (R, quaternion, theta_lambda, rpy, other)
        present = [value for value in values if value is not None]
        if len(present) > 1:
            raise RuntimeError(
                'RotationMatrix: give one of R, quaternion, theta_lambda, rpy, other'
            )
        self._R = _read_only(_matrix_of(present[0]) if present else np.eye(3))

    def set(self, R: ArrayLike) -> None:
        """Set the matrix R (3, 3)."""
        self._R = _read_only(_matrix_of(R))

    @staticmethod
    def Identity() -> RotationMatrix:
        """Return the identity."""
        return RotationMatrix()

    @staticmethod
    def MakeXRotation(theta: float) -> RotationMatrix:
        """Return the rotation by ``theta`` [rad] about x."""
        return RollPitchYaw(theta, 0.0, 0.0).ToRotationMatrix()

    @staticmethod
    def MakeYRotation(theta: float) -> RotationMatrix:
        """Return the rotation by ``theta`` [rad] about y."""
        return RollPitchYaw(0.0, theta, 0.0).ToRotationMatrix()

    @staticmethod
    def MakeZRotation(theta: float) -> RotationMatrix:
        """Return the rotation by ``theta`` [rad] about z."""
        return RollPitchYaw(0.0, 0.0, theta).ToRotationMatrix()

    @staticmethod
    def MakeFromOneVector(b_A: ArrayLike, axis_index: int) -> RotationMatrix:
        """Return an R_AB whose column ``axis_index`` is the direction of ``b_A`` (3,).

        The next column is at right angles to the axis along which ``b_A`` has its smallest
        component. Raises RuntimeError for a vector shorter than 1e-10, or an index other than
        0, 1, 2.
        """
        if axis_index not in (0, 1, 2):
            raise RuntimeError(f'MakeFromOneVector: axis_index = {axis_index} is not 0, 1 or 2')
        b = as_vector(b_A, 'MakeFromOneVector: b_A')
        length = float(np.linalg.norm(b))
        if not length >= DIRECTION_NORM:
            raise RuntimeError(
                f'MakeFromOneVector: |b_A| = {length:g} must be >= {DIRECTION_NORM:g}'
            )
        u = b / length
        v = np.cross(np.eye(3)[np.argmin(np.abs(u))], u)
        v /= np.linalg.norm(v)
        R = np.empty((3, 3))
        R[:, axis_index], R[:, (axis_index + 1) % 3] = u, v
        R[:, (axis_index + 2) % 3] = np.cross(u, v)
        return RotationMatrix._make(R)

    @staticmethod
    def ProjectToRotationMatrix(M: ArrayLike) -> RotationMatrix:
        """Return the rotation nearest to ``M`` (3, 3) in the Frobenius norm.

        Raises RuntimeError if M is singular or nearest to a reflection. Formula: U V^T of the
        singular value decomposition (orthogonal Procrustes problem).
        """
        matrix = np.asarray(M, dtype=np.float64)
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all() or np.linalg.det(matrix) <= 0:
            raise RuntimeError(
                'ProjectToRotationMatrix: M must be finite, (3, 3), with a positive determinant, '
                f'given {matrix.tolist()}'
            )
        U, _, Vt = np.linalg.svd(matrix)
        return RotationMatrix._make(U @ Vt)

    @classmethod
    def _make(cls, R: Floats) -> RotationMatrix:
        """Return the rotation R (3, 3), without a copy and a check."""
        rotation = cls.__new__(cls)
        rotation._R = _read_only(R)
        return rotation

    def matrix(self) -> Floats:
        """Return the matrix (3, 3), read-only."""
        return self._R

    def row(self, index: int) -> Floats:
        """Return row ``index`` (3,): an axis of A in B."""
        row: Floats = self._R[index]
        return row

    def col(self, index: int) -> Floats:
        """Return column ``index`` (3,): an axis of B in A."""
        return self._R[:, index]

    def inverse(self) -> RotationMatrix:
        """Return R_BA."""
        return RotationMatrix._make(self._R.T.copy())

    def transpose(self) -> RotationMatrix:
        """Return R_BA, which is the transpose."""
        return self.inverse()

    def InvertAndCompose(self, other: RotationMatrix) -> RotationMatrix:
        """Return R_BC of this R_AB and the other R_AC."""
        return RotationMatrix._make(orthogonal(self._R.T @ other._R))

    @overload
    def multiply(self, other: RotationMatrix) -> RotationMatrix: ...
    @overload
    def multiply(self, other: ArrayLike) -> Floats: ...
    @overload
    def multiply(self, *, v_B: ArrayLike) -> Floats: ...
    def multiply(self, other: Any = None, *, v_B: ArrayLike | None = None) -> Any:
        """Return R_AC for an R_BC, or v_A, of the same shape, for v_B (3,) or (3, n)."""
        operand = v_B if other is None else other
        if isinstance(operand, RotationMatrix):
            return RotationMatrix._make(orthogonal(self._R @ operand._R))
        v_Bs = np.asarray(operand, dtype=np.float64)
        if v_Bs.ndim not in (1, 2) or v_Bs.shape[0] != 3:
            raise RuntimeError(f'RotationMatrix: cannot rotate shape {v_Bs.shape}, (3,) or (3, n)')
        return self._R @ v_Bs

    __matmul__ = multiply

    def IsValid(self) -> bool:
        """Return whether this is a rotation to working precision (True unless unchecked)."""
        return rotation_error(self._R) <= ROTATION

    def IsExactlyIdentity(self) -> bool:
        """Return whether this is the identity to the last bit."""
        return np.array_equal(self._R, np.eye(3))

    def IsNearlyIdentity(self, tolerance: float = ROTATION) -> bool:
        """Return whether no element differs from the identity's by more than ``tolerance``."""
        return bool(np.abs(self._R - np.eye(3)).max() <= tolerance)

    def IsExactlyEqualTo(self, other: RotationMatrix) -> bool:
        """Return whether the two matrices are the same to the last bit."""
        return self == other

    def IsNearlyEqualTo(self, other: RotationMatrix, tolerance: float) -> bool:
        """Return whether no element differs by more than ``tolerance``."""
        return bool(np.abs(self._R - other._R).max() <= tolerance)

    def ToRollPitchYaw(self) -> RollPitchYaw:
        """Return roll, pitch and yaw, with pitch between -pi/2 and pi/2."""
        return RollPitchYaw(self)

    def ToQuaternionAsVector(self) -> Floats:
        """Return the unit quaternion (4,) w x y z, Drake's order, with w >= 0."""
        return np.roll(quaternions_from_rotations(self._R[None])[0], 1)

    def ToQuaternion(self) -> Quaternion:
        """Return the unit quaternion with w >= 0."""
        return Quaternion(self.ToQuaternionAsVector())

    def ToAngleAxis(self) -> AngleAxis:
        """Return axis and angle, which is between 0 and pi."""
        return AngleAxis(quaternion=self.ToQuaternion())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RotationMatrix):
            return NotImplemented
        return np.array_equal(self._R, other._R)

    def __repr__(self) -> str:
        rows = ',\n'.join(f'  {row}' for row in self._R.tolist())
        return f'RotationMatrix([\n{rows},\n])'


class RollPitchYaw:
    """A rotation by angles [rad] about fixed axes: roll about x, then pitch about y, yaw about z.

    Made from three angles, an array (3,) of them, a ``RotationMatrix``, a matrix (3, 3), or a unit
    quaternion as for ``RotationMatrix``. R = Rz(yaw) Ry(pitch) Rx(roll).
    """

    __slots__ = ('_rpy',)

    def __init__(
        self,
        roll: Any = None,
        pitch: float | None = None,
        yaw: float | None = None,
        *,
        rpy: ArrayLike | None = None,
        R: RotationMatrix | None = None,
        quaternion: Any = None,
        matrix: ArrayLike | None = None,
        other: RollPitchYaw | None = None,
    ) -> None:
        angles = None if pitch is None or yaw is None else [roll, pitch, yaw]
        single = roll if pitch is None and yaw is None else None
        present = [
            value
            for value in (angles, single, rpy, R, quaternion, matrix, other)
            if value is not None
        ]
        if len(present) != 1:
            raise RuntimeError(
                'RollPitchYaw: give roll, pitch, yaw, or one of rpy, R, quaternion, matrix, other'
            )
        self._rpy = _read_only(_angles_of(present[0]))

    def vector(self) -> Floats:
        """Return roll, pitch, yaw (3,) [rad], read-only."""
        return self._rpy

    def roll_angle(self) -> float:
        """Return the angle [rad] about x."""
        return float(self._rpy[0])

    def pitch_angle(self) -> float:
        """Return the angle [rad] about y."""
        return float(self._rpy[1])

    def yaw_angle(self) -> float:
        """Return the angle [rad] about z."""
        return float(self._rpy[2])

    def ToRotationMatrix(self) -> RotationMatrix:
        """Return R = Rz(yaw) Ry(pitch) Rx(roll)."""
        (sr, sp, sy), (cr, cp, cy) = np.sin(self._rpy), np.cos(self._rpy)
        return RotationMatrix._make(
            np.array(
                [
                    [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                    [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                    [-sp, cp * sr, cp * cr],
                ]
            )
        )

    def ToQuaternionAsVector(self) -> Floats:
        """Return the unit quaternion (4,) w x y z, Drake's order, with w >= 0."""
        return self.ToRotationMatrix().ToQuaternionAsVector()

    def ToQuaternion(self) -> Quaternion:
        """Return the unit quaternion with w >= 0."""
        return self.ToRotationMatrix().ToQuaternion()

    def IsNearlyEqualTo(self, other: RollPitchYaw, tolerance: float) -> bool:
        """Return whether no angle [rad] differs by more than ``tolerance``; full turns count."""
        return bool(np.abs(self._rpy - other._rpy).max() <= tolerance)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, RollPitchYaw):
            return NotImplemented
        return np.array_equal(self._rpy, other._rpy)

    def __repr__(self) -> str:
        roll, pitch, yaw = self._rpy.tolist()
        return f'RollPitchYaw(roll={roll}, pitch={pitch}, yaw={yaw})'


def _read_only(array: Floats) -> Floats:
    """Make an array read-only, so that values can share it, and return it."""
    array.flags.writeable = False
    return array


def _matrix_of(rotation: Any) -> Floats:
    """Return the matrix (3, 3) of any description of a rotation."""
    if isinstance(rotation, RotationMatrix):
        return rotation._R
    if isinstance(rotation, RollPitchYaw):
        return rotation.ToRotationMatrix()._R
    if isinstance(rotation, AngleAxis):
        return rotation.rotation()
    try:
        wxyz_or_R = np.array(
            rotation.wxyz() if hasattr(rotation, 'wxyz') else rotation, dtype=np.float64
        )
    except (TypeError, ValueError):
        raise RuntimeError(f'RotationMatrix: {rotation!r} is not a rotation') from None
    if wxyz_or_R.shape == (4,):
        Rs = rotations_from_quaternions(np.roll(wxyz_or_R, -1)[None], 'quaternion')
        return np.ascontiguousarray(Rs[0])
    if wxyz_or_R.shape != (3, 3):
        raise RuntimeError(f'RotationMatrix: shape {wxyz_or_R.shape} is neither (3, 3) nor (4,)')
    error = rotation_error(wxyz_or_R)
    if not error <= ALMOST_ROTATION:
        raise RuntimeError(
            f'RotationMatrix: {wxyz_or_R.tolist()} is not a rotation: max |R R^T - I| is '
            f'{error:.2g}, allowed {ALMOST_ROTATION:g}; see RotationMatrix.ProjectToRotationMatrix'
        )
    return orthogonal(wxyz_or_R)


def _angles_of(value: Any) -> Floats:
    """Return roll, pitch, yaw (3,) of any description of a rotation."""
    if isinstance(value, RollPitchYaw):
        return value._rpy
    if not isinstance(value, RotationMatrix) and np.shape(value) in ((3,), (3, 1), (1, 3)):
        return as_vector(value, 'RollPitchYaw: rpy')
    return _angles_of_matrix(_matrix_of(value))


def _angles_of_matrix(R: Floats) -> Floats:
    """Return roll, pitch, yaw (3,) of R (3, 3), as well conditioned as R at every pitch.

    Pitch is computed from R's elements, sum and difference of roll and yaw from its quaternion, so
    there is no division by cos(pitch) (P. Mitiguy's algorithm, in Drake's RollPitchYaw).
    """
    cos_pitch = math.sqrt(0.5 * (R[2, 2] ** 2 + R[2, 1] ** 2 + R[1, 0] ** 2 + R[0, 0] ** 2))
    pitch = math.atan2(-R[2, 0], cos_pitch)
    x, y, z, w = quaternions_from_rotations(R[None])[0].tolist()
    half_sum = math.atan2(x + z, w - y)
    half_difference = math.atan2(z - x, w + y)
    roll, yaw = half_sum - half_difference, half_sum + half_difference
    return np.array([math.remainder(roll, math.tau), pitch, math.remainder(yaw, math.tau)])
