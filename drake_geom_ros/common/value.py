"""Type-erased values, with the names of ``pydrake.common.value``."""

from __future__ import annotations

import copy
import functools
from typing import Any

__all__ = ['AbstractValue', 'Value']


class AbstractValue:
    """A value in a box.

    >>> AbstractValue.Make(3).get_value()
    3
    """

    __slots__ = ('_value',)
    _value: Any

    def __init__(self) -> None:
        raise RuntimeError('AbstractValue: make one with AbstractValue.Make(value)')

    @staticmethod
    def Make(value: Any) -> AbstractValue:
        """Return a copy of a value, in a box."""
        box = AbstractValue.__new__(AbstractValue)
        box._value = copy.deepcopy(value)
        return box

    def get_value(self) -> Any:
        """Return the value."""
        return self._value

    def get_mutable_value(self) -> Any:
        """Return the value, which may be changed in place."""
        return self._value

    def set_value(self, value: Any) -> None:
        """Set another value; raises RuntimeError for one of another type."""
        if type(value) is not type(self._value):
            raise RuntimeError(
                f'set_value: the value is of type {type(self._value).__name__}, given '
                f'{type(value).__name__}'
            )
        self._value = value

    def SetFrom(self, other: AbstractValue) -> None:
        """Set a copy of the value in another box; raises RuntimeError for another type."""
        self.set_value(copy.deepcopy(other._value))

    def Clone(self) -> AbstractValue:
        """Return a box with a copy of the value."""
        return AbstractValue.Make(self._value)

    def __repr__(self) -> str:
        return f'AbstractValue.Make({self._value!r})'


class Value(AbstractValue):
    """A value of one type in a box: ``Value[float](2.0)``, or ``Value[float]()`` for the default.

    >>> Value[str]('left').get_value()
    'left'
    """

    __slots__ = ()
    _kind: type = object

    @classmethod
    @functools.cache
    def _of(cls, kind: type) -> type[Value]:
        return type(f'Value[{kind.__name__}]', (cls,), {'__slots__': (), '_kind': kind})

    def __class_getitem__(cls, kind: type) -> type[Value]:
        """Return the boxes for values of a type."""
        return cls._of(kind)

    def __init__(self, *value: Any) -> None:
        """Put a copy of a value into a box; raises TypeError for one of another type."""
        kind = type(self)._kind
        self._value = copy.deepcopy(*value) if value else kind()
        if not isinstance(self._value, kind):
            raise TypeError(
                f'Value: {self._value!r} is of type {type(self._value).__name__}; it must be '
                f'{kind.__name__}'
            )
