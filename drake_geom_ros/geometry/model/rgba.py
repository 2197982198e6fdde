"""``Rgba``: colours with alpha."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry.errors import ArgumentError


class Rgba:
    """A colour: red, green, blue and alpha, each in [0, 1]; white without arguments.

    Values outside raise RuntimeError and do not change the colour.
    """

    __slots__ = ('_rgba',)
    # ``pydrake.common.yaml`` uses this to read and write a colour.
    __fields__ = (SimpleNamespace(name='rgba', type=np.ndarray),)

    def __init__(self, r: float = 1.0, g: float = 1.0, b: float = 1.0, a: float = 1.0) -> None:
        self._rgba = _checked(r, g, b, a)

    def r(self) -> float:
        """Return red."""
        return self._rgba[0]

    def g(self) -> float:
        """Return green."""
        return self._rgba[1]

    def b(self) -> float:
        """Return blue."""
        return self._rgba[2]

    def a(self) -> float:
        """Return alpha: 0 is clear, 1 is opaque."""
        return self._rgba[3]

    @property
    def rgba(self) -> NDArray[np.float64]:
        """Red, green, blue and alpha, (4,)."""
        return np.array(self._rgba)

    @rgba.setter
    def rgba(self, values: ArrayLike) -> None:
        self.set(rgba=values)

    def set(
        self,
        r: float | ArrayLike | None = None,
        g: float | None = None,
        b: float | None = None,
        a: float = 1.0,
        *,
        rgba: ArrayLike | None = None,
    ) -> None:
        """Set the colour to r, g, b, a, or to an array of three or four of them."""
        if r is not None and g is not None and b is not None and rgba is None:
            self._rgba = _checked(r, g, b, a)
            return
        values = np.asarray(r if rgba is None else rgba, dtype=np.float64).tolist()
        if not isinstance(values, list) or len(values) not in (3, 4):
            raise ArgumentError(f'Rgba: {values!r} must be 3 or 4 numbers')
        self._rgba = _checked(*values)

    def update(
        self,
        r: float | None = None,
        g: float | None = None,
        b: float | None = None,
        a: float | None = None,
    ) -> None:
        """Set some channels; those that are None stay."""
        channels = zip((r, g, b, a), self._rgba, strict=True)
        self._rgba = _checked(*(old if new is None else new for new, old in channels))

    def scale_rgb(self, scale: float) -> Rgba:
        """Return the colour of r, g, b times ``scale`` >= 0, at most 1, and the same alpha."""
        if not scale >= 0.0:
            raise ArgumentError(f'Rgba.scale_rgb: scale = {scale} must be >= 0')
        r, g, b, a = self._rgba
        return Rgba(min(r * scale, 1.0), min(g * scale, 1.0), min(b * scale, 1.0), a)

    def __mul__(self, other: Rgba) -> Rgba:
        """Return the colour whose channels are the products of both colours' channels."""
        if not isinstance(other, Rgba):
            return NotImplemented
        return Rgba(*(self.rgba * other.rgba).tolist())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Rgba):
            return NotImplemented
        return self._rgba == other._rgba

    def __repr__(self) -> str:
        return 'Rgba(r={}, g={}, b={}, a={})'.format(*self._rgba)


def _checked(
    r: float | ArrayLike, g: float, b: float, a: float = 1.0
) -> tuple[float, float, float, float]:
    """Return the four numbers, or raise RuntimeError if any is outside [0, 1]."""
    try:
        red, green, blue, alpha = (float(value) for value in (r, g, b, a))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise ArgumentError(f'Rgba: ({r!r}, {g!r}, {b!r}, {a!r}) must be numbers') from None
    if not all(0.0 <= value <= 1.0 for value in (red, green, blue, alpha)):
        raise ArgumentError(
            'Rgba: values must be in the range [0, 1], given '
            f'(r={red}, g={green}, b={blue}, a={alpha})'
        )
    return red, green, blue, alpha
