"""Typed identifiers, so that the id of a frame cannot be used for a geometry."""

from __future__ import annotations

import threading
from typing import Any, ClassVar, TypeVar

from drake_geom_ros.geometry.errors import ArgumentTypeError, GeometryError

_Id = TypeVar('_Id', bound='Identifier')


class Identifier:
    """A number that identifies one object of one kind in this process; 0 is invalid.

    Ids of a kind are hashable and ordered by their values; ids of different kinds are never
    equal. ``get_new_id`` returns new ones. ``FrameId(7)`` wraps a value from ``get_value``, for
    instance after it was sent in a message.
    """

    __slots__ = ('_value',)
    _next: ClassVar[int]
    _lock: ClassVar[threading.Lock] = threading.Lock()

    def __init_subclass__(cls) -> None:
        """Give each kind a counter of its own."""
        super().__init_subclass__()
        cls._next = 1

    def __init__(self, value: int) -> None:
        """Wrap the value of an id; a negative one raises RuntimeError."""
        try:
            self._value = value.__index__()
        except AttributeError:
            raise ArgumentTypeError(
                f'{type(self).__name__}: value must be an int, given {value!r}'
            ) from None
        if self._value < 0:
            raise GeometryError(f'{type(self).__name__}: value must be >= 0, given {value}')

    @classmethod
    def get_new_id(cls: type[_Id]) -> _Id:
        """Return an id that differs from all ids of its kind so far; safe in any thread."""
        with cls._lock:
            value = cls._next
            cls._next = value + 1
        return cls(value)

    def get_value(self) -> int:
        """Return the number; raises RuntimeError for an invalid id."""
        if not self._value:
            raise GeometryError(f'{type(self).__name__}: an invalid id has no value')
        return self._value

    def is_valid(self) -> bool:
        """Return whether the id is valid (its scene may no longer have the object)."""
        return self._value != 0

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self._value == other._value

    def __lt__(self: _Id, other: _Id) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self._value < other._value

    def __le__(self: _Id, other: _Id) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self._value <= other._value

    def __hash__(self) -> int:
        return hash(self._value)

    def __repr__(self) -> str:
        return f'<{type(self).__name__} value={self._value}>'


def only_id(what: str, *ids: Any) -> Any:
    """Return the only id that is not None; raises ArgumentTypeError for none or several."""
    present = [id for id in ids if id is not None]
    if len(present) != 1:
        raise ArgumentTypeError(f'{what}: give one id, not {len(present)}')
    return present[0]


def begin_ids_at(value: int) -> None:
    """Make new ids of each kind at least ``value``, and greater than all so far.

    Clients may store ids of a process and use them with its successor. If the successor begins at
    a number that no earlier id has reached, such ids are unknown to it.
    """
    with Identifier._lock:
        for kind in (SourceId, FrameId, GeometryId, FilterId):
            kind._next = max(kind._next, value)


class SourceId(Identifier):
    """Id of a geometry source, which registers and owns frames and geometries."""

    __slots__ = ()


class FrameId(Identifier):
    """Id of a frame."""

    __slots__ = ()


class GeometryId(Identifier):
    """Id of a geometry."""

    __slots__ = ()


class FilterId(Identifier):
    """Id of a transient collision filter declaration."""

    __slots__ = ()


def geometry_id_of(value: object) -> GeometryId:
    """Return an id, or the id of a value from an array of results; no bool, no text."""
    if isinstance(value, GeometryId):
        return value
    if isinstance(value, bool) or not hasattr(value, '__index__'):
        raise ArgumentTypeError(f'geometry_id = {value!r} must be of type GeometryId')
    return GeometryId(value)  # type: ignore[arg-type]
