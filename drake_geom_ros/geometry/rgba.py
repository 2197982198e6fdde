"""Colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry.errors import ArgumentError


class Rgba:
    """A colour: red, green, blue and alpha, each in [0, 1]; white when nothing is given.

    Values outside raise RuntimeError, and leave the colour as it was.
    """

    __slots__ = ('_rgba',)

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

    def set(
        self,
        r: float | ArrayLike,
        g: float | None = None,
        b: float | None = None,
        a: float = 1.0,
    ) -> None:
        """Become the colour r, g, b, a, or that of one array of three or four of them."""
        if g is None or b is None:
            values = np.asarray(r, dtype=np.float64).tolist()
            if not isinstance(values, list) or len(values) not in (3, 4):
                raise ArgumentError(f'Rgba: {r!r} must be three or four numbers')
            self._rgba = _checked(*values)
        else:
            self._rgba = _checked(r, g, b, a)

    def update(
        self,
        r: float | None = None,
        g: float | None = None,
        b: float | None = None,
        a: float | None = None,
    ) -> None:
        """Change the channels that are given."""
        given = zip((r, g, b, a), self._rgba, strict=True)
        self._rgba = _checked(*(old if new is None else new for new, old in given))

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
            f'Rgba: values must be in [0, 1], given (r={red}, g={green}, b={blue}, a={alpha})'
        )
    return red, green, blue, alpha
