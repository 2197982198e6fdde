"""``RenderLabel``: the labels in a label image."""

from __future__ import annotations

from typing import ClassVar

from drake_geom_ros.geometry.errors import ArgumentError, ArgumentTypeError

# As in Drake, the largest numbers of 16 bits are reserved.
_EMPTY, _DO_NOT_RENDER, _DONT_CARE, _UNSPECIFIED = 32766, 32765, 32764, 32767
_RESERVED = {
    _EMPTY: 'kEmpty',
    _DO_NOT_RENDER: 'kDoNotRender',
    _DONT_CARE: 'kDontCare',
    _UNSPECIFIED: 'kUnspecified',
}


class RenderLabel:
    """Label of a pixel: a number from 0 to ``kMaxUnreserved``, or one of four reserved ones.

    - ``kEmpty``: the background;
    - ``kDontCare``: geometry without its own label;
    - ``kDoNotRender``: geometry that label images leave out, so that they show what is behind it;
    - ``kUnspecified``: as the default of an engine, refuses geometry without a label.

    Raises RuntimeError for a number that is reserved or out of range.
    """

    __slots__ = ('_value',)
    kEmpty: ClassVar[RenderLabel]
    kDoNotRender: ClassVar[RenderLabel]
    kDontCare: ClassVar[RenderLabel]
    kUnspecified: ClassVar[RenderLabel]
    kMaxUnreserved: ClassVar[int] = _DONT_CARE - 1

    def __init__(self, value: int = _UNSPECIFIED) -> None:
        try:
            number = int(value.__index__())
        except AttributeError:
            raise ArgumentTypeError(f'RenderLabel: value = {value!r} must be an int') from None
        if not 0 <= number <= self.kMaxUnreserved and number != _UNSPECIFIED:
            reserved = f', and is {_RESERVED[number]}' if number in _RESERVED else ''
            raise ArgumentError(
                f'RenderLabel: value = {number} must be from 0 to {self.kMaxUnreserved}{reserved}'
            )
        self._value = number

    @classmethod
    def _reserved(cls, value: int) -> RenderLabel:
        label = cls.__new__(cls)
        label._value = value
        return label

    def is_reserved(self) -> bool:
        """Return whether the label is one of the four reserved ones."""
        return self._value > self.kMaxUnreserved

    def __int__(self) -> int:
        return self._value

    def __index__(self) -> int:
        return self._value

    def __eq__(self, other: object) -> bool:
        return self._value == other._value if isinstance(other, RenderLabel) else NotImplemented

    def __lt__(self, other: RenderLabel) -> bool:
        return self._value < other._value

    def __hash__(self) -> int:
        return hash(self._value)

    def __repr__(self) -> str:
        return f'RenderLabel({_RESERVED.get(self._value, self._value)})'


RenderLabel.kEmpty = RenderLabel._reserved(_EMPTY)
RenderLabel.kDoNotRender = RenderLabel._reserved(_DO_NOT_RENDER)
RenderLabel.kDontCare = RenderLabel._reserved(_DONT_CARE)
RenderLabel.kUnspecified = RenderLabel._reserved(_UNSPECIFIED)
