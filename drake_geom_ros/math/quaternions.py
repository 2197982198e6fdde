"""``Quaternion`` and ``AngleAxis``, with the names of ``pydrake.common.eigen_geometry``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.arrays import rotation_error
from drake_geom_ros.math.batched import quaternions_from_rotations, rotations_from_quaternions
from drake_geom_ros.math.tolerances import ALMOST_ROTATION, LEAST_SQUARED, UNIT_NORM


class Quaternion:
    """A unit quaternion, in the order w x y z; the identity without arguments.

    Made from four numbers, an array (4,) of them, or the matrix (3, 3) of a ``rotation``. Raises
    RuntimeError if its length differs from 1 by more than ``UNIT_NORM``; it is not normalised.

        >>> Quaternion(w=0, x=1, y=0, z=0).rotation().diagonal().tolist()
        [1.0, -1.0, -1.0]
    """

    __slots__ = ('_wxyz',)

    def __init__(
        self,
        w: Any = None,
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
        *,
        wxyz: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
        other: Quaternion | None = None,
    ) -> None:
        numbers = None if x is None else [w, x, y, z]
        single = w if x is None else None
        source = _only('Quaternion', numbers, single, wxyz, rotation, other)
        if isinstance(source, Quaternion):
            source = source._wxyz
        elif np.shape(source) == (3, 3):
            source = _of_matrix(source)
        self._wxyz: Floats = _unit(
            [1, 0, 0, 0] if source is None else source, 4, 'Quaternion: wxyz'
        )

    @staticmethod
    def Identity() -> Quaternion:
        """Return the identity."""
        return Quaternion()

    def w(self) -> float:
        """Return the scalar part."""
        return float(self._wxyz[0])

    def x(self) -> float:
        """Return the first number of the vector part."""
        return float(self._wxyz[1])

    def y(self) -> float:
        """Return the second number of the vector part."""
        return float(self._wxyz[2])

    def z(self) -> float:
        """Return the third number of the vector part."""
        return float(self._wxyz[3])

    def xyz(self) -> Floats:
        """Return the vector part (3,)."""
        return self._wxyz[1:].copy()

    def wxyz(self) -> Floats:
        """Return the four numbers (4,), w first."""
        return self._wxyz.copy()

    def conjugate(self) -> Quaternion:
        """Return the inverse rotation."""
        return Quaternion(self._wxyz * [1.0, -1.0, -1.0, -1.0])

    def inverse(self) -> Quaternion:
        """Return the inverse rotation."""
        return self.conjugate()

    def rotation(self) -> Floats:
        """Return the rotation matrix (3, 3)."""
        R: Floats = rotations_from_quaternions(np.roll(self._wxyz, -1)[None])[0]
        return R

    def __repr__(self) -> str:
        w, x, y, z = self._wxyz.tolist()
        return f'Quaternion(w={w}, x={x}, y={y}, z={z})'


class AngleAxis:
    """A rotation by ``angle`` [rad] about a unit ``axis`` (3,); the identity without them.

    Made from both, or from a ``quaternion``, or from the matrix (3, 3) of a ``rotation``: then the
    angle is between 0 and pi. Raises RuntimeError for an axis whose length differs from 1 by more
    than ``UNIT_NORM``.

        >>> AngleAxis(math.pi, [0, 0, 1]).inverse().angle() == -math.pi
        True
    """

    __slots__ = ('_angle', '_axis')

    def __init__(
        self,
        angle: float | None = None,
        axis: ArrayLike | None = None,
        *,
        quaternion: Quaternion | None = None,
        rotation: ArrayLike | None = None,
        other: AngleAxis | None = None,
    ) -> None:
        if (angle is None) != (axis is None):
            raise RuntimeError('AngleAxis: give both angle and axis, or neither')
        both = None if axis is None else (angle, axis)
        source: Any = _only('AngleAxis', both, quaternion, rotation, other)
        if source is None:
            source = 0.0, [1.0, 0.0, 0.0]
        elif isinstance(source, AngleAxis):
            source = source._angle, source._axis
        elif source is not both:
            source = _angle_and_axis(Quaternion(source).wxyz())
        self._angle: float = float(source[0])
        self._axis: Floats = _unit(source[1], 3, 'AngleAxis: axis')

    @staticmethod
    def Identity() -> AngleAxis:
        """Return the identity."""
        return AngleAxis()

    def angle(self) -> float:
        """Return the angle [rad]."""
        return self._angle

    def axis(self) -> Floats:
        """Return the axis (3,), of unit length."""
        return self._axis.copy()

    def inverse(self) -> AngleAxis:
        """Return the inverse rotation."""
        return AngleAxis(-self._angle, self._axis)

    def quaternion(self) -> Quaternion:
        """Return the rotation as a quaternion."""
        half = 0.5 * self._angle
        axis = self._axis / np.linalg.norm(self._axis)
        return Quaternion([math.cos(half), *(math.sin(half) * axis)])

    def rotation(self) -> Floats:
        """Return the rotation matrix (3, 3)."""
        return self.quaternion().rotation()

    def __repr__(self) -> str:
        return f'AngleAxis(angle={self._angle}, axis={self._axis.tolist()})'


def _only(kind: str, *values: Any) -> Any:
    """Return the value that is not None, if there is one; raises RuntimeError for several."""
    present = [value for value in values if value is not None]
    if len(present) > 1:
        raise RuntimeError(f'{kind}: give one description of the rotation, not {len(present)}')
    return present[0] if present else None


def _unit(values: ArrayLike, size: int, what: str) -> Floats:
    """Return finite numbers (size,) of unit length; RuntimeError for others."""
    try:
        vector = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise RuntimeError(f'{what} = {values!r} is not {size} numbers') from None
    if vector.shape in ((size, 1), (1, size)):
        vector = vector.reshape(size)
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise RuntimeError(f'{what} = {vector.tolist()} is not {size} finite numbers')
    length = float(np.linalg.norm(vector))
    if not abs(length - 1.0) <= UNIT_NORM:
        raise RuntimeError(f'{what} = {vector.tolist()} has length {length:.9g}; it must be 1')
    return vector


def _of_matrix(rotation: ArrayLike) -> Floats:
    """Return w x y z of a matrix (3, 3); RuntimeError if that is no rotation."""
    R = np.asarray(rotation, dtype=np.float64)
    error = rotation_error(R)
    if not error <= ALMOST_ROTATION:
        raise RuntimeError(
            f'Quaternion: {R.tolist()} is not a rotation: max |R R^T - I| is {error:.2g}'
        )
    return np.roll(quaternions_from_rotations(R[None])[0], 1)


def _angle_and_axis(wxyz: Floats) -> tuple[float, Floats]:
    """Return angle [rad], from 0 to pi, and axis (3,) of a unit quaternion."""
    w, v = abs(float(wxyz[0])), wxyz[1:] * math.copysign(1.0, float(wxyz[0]))
    largest = float(np.abs(v).max())
    if largest == 0.0:
        return 0.0, np.array([1.0, 0.0, 0.0])
    scale = largest if largest < LEAST_SQUARED else 1.0
    v = v / scale
    sine = float(np.linalg.norm(v))
    # The cosine alone would lose all digits of a small angle.
    return 2.0 * math.atan2(sine * scale, w), v / sine
