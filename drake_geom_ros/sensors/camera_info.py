"""``CameraInfo``: the intrinsics of a pinhole camera."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


class CameraInfo:
    """Size, focal lengths and principal point of a pinhole camera, in pixels.

    ``CameraInfo(width, height, fov_y)``, with the vertical field of view [rad] and the principal
    point in the centre; ``CameraInfo(width, height, focal_x, focal_y, center_x, center_y)``; or
    ``CameraInfo(width, height, intrinsic_matrix)`` (3, 3).

    The camera looks along +z of its sensor frame, x to the right and y down. As in Drake, the ray
    of pixel (u, v) is ((u + 0.5 - center_x) / focal_x, (v + 0.5 - center_y) / focal_y, 1), and the
    centre is (width / 2 - 0.5, height / 2 - 0.5).

    Raises RuntimeError for a size below 1, a field of view outside (0, pi), focal lengths that are
    not > 0 and a principal point outside the image.
    """

    __slots__ = ('_K', '_height', '_width')

    def __init__(
        self,
        width: int,
        height: int,
        *intrinsics: Any,
        fov_y: float | None = None,
        focal_x: float | None = None,
        focal_y: float | None = None,
        center_x: float | None = None,
        center_y: float | None = None,
        intrinsic_matrix: ArrayLike | None = None,
    ) -> None:
        self._width = _size('width', width)
        self._height = _size('height', height)
        numbers = [n for n in (focal_x, focal_y, center_x, center_y) if n is not None]
        named = [n for n in (fov_y, intrinsic_matrix) if n is not None] + numbers
        values = [*intrinsics, *named]
        if len(values) == 4:
            fx, fy, cx, cy = (_number('intrinsics', n) for n in values)
        elif len(values) == 1 and np.ndim(values[0]) == 2:
            K = _checked_matrix(values[0])
            fx, fy, cx, cy = K[[0, 1, 0, 1], [0, 1, 2, 2]].tolist()
        elif len(values) == 1:
            fx = fy = 0.5 * self._height / math.tan(0.5 * field_of_view('CameraInfo', values[0]))
            cx, cy = 0.5 * self._width - 0.5, 0.5 * self._height - 0.5
        else:
            raise RuntimeError(
                'CameraInfo: give fov_y, or focal_x, focal_y, center_x and center_y, or '
                f'intrinsic_matrix; given {len(values)} values'
            )
        for name, focal in (('focal_x', fx), ('focal_y', fy)):
            if not 0.0 < focal < math.inf:
                raise RuntimeError(f'CameraInfo: {name} = {focal} must be finite and > 0 [pixels]')
        # A margin of half a pixel, since the centre of an image of one pixel is (0, 0).
        for name, centre, size in (('x', cx, self._width), ('y', cy, self._height)):
            if not 0.0 <= centre <= size:
                raise RuntimeError(
                    f'CameraInfo: center_{name} = {centre} must be within the image, 0 to {size}'
                )
        self._K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    def width(self) -> int:
        """Return the number of columns."""
        return self._width

    def height(self) -> int:
        """Return the number of rows."""
        return self._height

    def focal_x(self) -> float:
        """Return the focal length [pixels] along x."""
        return float(self._K[0, 0])

    def focal_y(self) -> float:
        """Return the focal length [pixels] along y."""
        return float(self._K[1, 1])

    def fov_x(self) -> float:
        """Return the horizontal field of view [rad]."""
        return 2.0 * math.atan(0.5 * self._width / self.focal_x())

    def fov_y(self) -> float:
        """Return the vertical field of view [rad]."""
        return 2.0 * math.atan(0.5 * self._height / self.focal_y())

    def center_x(self) -> float:
        """Return x of the principal point [pixels]."""
        return float(self._K[0, 2])

    def center_y(self) -> float:
        """Return y of the principal point [pixels]."""
        return float(self._K[1, 2])

    def intrinsic_matrix(self) -> NDArray[np.float64]:
        """Return the matrix (3, 3) of focal lengths and principal point."""
        return self._K.copy()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, CameraInfo):
            return NotImplemented
        sizes = (self._width, self._height) == (other._width, other._height)
        return sizes and np.array_equal(self._K, other._K)

    def __hash__(self) -> int:
        return hash((self._width, self._height, self._K.tobytes()))

    def __repr__(self) -> str:
        fx, fy, cx, cy = self.focal_x(), self.focal_y(), self.center_x(), self.center_y()
        return (
            f'CameraInfo(width={self._width}, height={self._height}, focal_x={fx!r}, '
            f'focal_y={fy!r}, center_x={cx!r}, center_y={cy!r})'
        )


def field_of_view(what: str, angle: Any) -> float:
    """Return a field of view [rad]; raises RuntimeError for one that is not in (0, pi)."""
    value = _number('fov_y', angle)
    if not 0.0 < value < math.pi:
        raise RuntimeError(f'{what}: fov_y = {value} must be in (0, pi) [rad]')
    return value


def _size(name: str, value: Any) -> int:
    try:
        size = int(value.__index__())
    except AttributeError:
        raise RuntimeError(f'CameraInfo: {name} = {value!r} must be a whole number') from None
    if size < 1:
        raise RuntimeError(f'CameraInfo: {name} = {size} must be >= 1 [pixels]')
    return size


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise RuntimeError(f'CameraInfo: {name} = {value!r} must be a number') from None


def _checked_matrix(matrix: ArrayLike) -> NDArray[np.float64]:
    K = np.asarray(matrix, dtype=np.float64)
    plain = np.zeros((3, 3))
    if K.shape == (3, 3):
        plain[[0, 1, 0, 1, 2], [0, 1, 2, 2, 2]] = K[0, 0], K[1, 1], K[0, 2], K[1, 2], 1.0
    if K.shape != (3, 3) or not np.array_equal(K, plain):
        raise RuntimeError(
            f'CameraInfo: intrinsic_matrix = {K.tolist()} must be [[focal_x, 0, center_x], '
            '[0, focal_y, center_y], [0, 0, 1]]'
        )
    return K
