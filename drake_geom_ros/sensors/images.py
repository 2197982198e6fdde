"""Images: rows from top to bottom, columns from left to right, a few channels each."""

from __future__ import annotations

from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

_I = TypeVar('_I', bound='Image')


class Image:
    """Base of images of all pixel types: ``data`` (height, width, channels)."""

    __slots__ = ('_data',)
    _TYPE: ClassVar[type[np.generic]]
    _CHANNELS: ClassVar[int]

    def __init__(
        self, width: int | None = None, height: int | None = None, initial_value: float = 0
    ) -> None:
        if not hasattr(self, '_TYPE'):
            raise TypeError('Image: make one of a pixel type, for instance ImageDepth32F(4, 3)')
        size = (height or 0, width or 0)
        if (width is None) != (height is None) or min(size) < 0:
            raise RuntimeError(
                f'{type(self).__name__}: width = {width} and height = {height} must be >= 0'
            )
        self._data: NDArray[Any] = np.full((*size, self._CHANNELS), initial_value, self._TYPE)

    @classmethod
    def of(cls: type[_I], data: NDArray[Any]) -> _I:
        """Return the image whose ``data`` is this array (height, width, channels), not a copy.

        Raises RuntimeError for another shape or another type.
        """
        if data.ndim != 3 or data.shape[2] != cls._CHANNELS or data.dtype != cls._TYPE:
            raise RuntimeError(
                f'{cls.__name__}: data of shape {data.shape} and type {data.dtype} must be '
                f'(height, width, {cls._CHANNELS}) of {np.dtype(cls._TYPE)}'
            )
        image = cls()
        image._data = data
        return image

    def width(self) -> int:
        """Return the number of columns."""
        return int(self._data.shape[1])

    def height(self) -> int:
        """Return the number of rows."""
        return int(self._data.shape[0])

    def size(self) -> int:
        """Return the number of values: columns times rows times channels."""
        return int(self._data.size)

    def resize(self, width: int, height: int) -> None:
        """Change the size and set all values to 0."""
        self._data = type(self)(width, height)._data

    def at(self, x: int, y: int) -> NDArray[Any]:
        """Return the writable channels of the pixel in column ``x`` and row ``y``.

        Raises RuntimeError for a pixel outside the image.
        """
        if not (0 <= x < self.width() and 0 <= y < self.height()):
            raise RuntimeError(
                f'{type(self).__name__}.at: ({x}, {y}) must be within {self.width()} columns and '
                f'{self.height()} rows'
            )
        channels: NDArray[Any] = self._data[y, x]
        return channels

    @property
    def data(self) -> NDArray[Any]:
        """The values (height, width, channels), read-only."""
        view = self._data.view()
        view.flags.writeable = False
        return view

    @property
    def mutable_data(self) -> NDArray[Any]:
        """The values (height, width, channels), writable."""
        return self._data

    @property
    def shape(self) -> tuple[int, ...]:
        """Rows, columns and channels."""
        return tuple(self._data.shape)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return np.array_equal(self._data, other._data)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f'<{type(self).__name__} of {self.width()} x {self.height()}>'


class ImageRgba8U(Image):
    """Red, green, blue and alpha, each from 0 to 255."""

    __slots__ = ()
    _TYPE = np.uint8
    _CHANNELS = 4


class ImageDepth32F(Image):
    """Depth [m] along the camera's axis: 0 for too close, infinity for too far or background."""

    __slots__ = ()
    _TYPE = np.float32
    _CHANNELS = 1


class ImageLabel16I(Image):
    """Labels of pixels, see ``RenderLabel``."""

    __slots__ = ()
    _TYPE = np.int16
    _CHANNELS = 1
