"""Identifiers: a number with a type, so that a frame is never taken for a geometry."""

from __future__ import annotations

import threading
from typing import Any, ClassVar, TypeVar

from drake_geom_ros.geometry.errors import ArgumentTypeError, GeometryError

_Id = TypeVar('_Id', bound='Identifier')


class Identifier:
    """A number that names one thing of one kind in this process; 0 names nothing.

    Ids of a kind are hashable and ordered by their values; ids of different kinds are never
    equal. ``FrameId(7)`` wraps a value that came out of ``get_value``, for instance by way of a
    message; new ones come from ``get_new_id``.
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
        """Return the number; raises RuntimeError for an id that names nothing."""
        if not self._value:
            raise GeometryError(f'{type(self).__name__}: an invalid id has no value')
        return self._value

    def is_valid(self) -> bool:
        """Return whether the id names something at all (its scene may no longer hold it)."""
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
    """Return the one id that was given; ArgumentTypeError where it is none, or several."""
    given = [id for id in ids if id is not None]
    if len(given) != 1:
        raise ArgumentTypeError(f'{what}: give one id, not {len(given)}')
    return given[0]


def begin_ids_at(value: int) -> None:
    """Let new ids of each kind be ``value`` or more, and greater than all so far.

    For a process whose ids are kept by others, who may take them to the process that comes after
    it: where that begins at a number that none has reached before, an old id names nothing in it.
    """
    with Identifier._lock:
        for kind in (SourceId, FrameId, GeometryId, FilterId):
            kind._next = max(kind._next, value)


class SourceId(Identifier):
    """Names a geometry source: who registered, and therefore owns, frames and geometries."""

    __slots__ = ()


class FrameId(Identifier):
    """Names a frame."""

    __slots__ = ()


class GeometryId(Identifier):
    """Names a geometry."""

    __slots__ = ()


class FilterId(Identifier):
    """Names a transient collision filter declaration."""

    __slots__ = ()


def geometry_id_of(value: object) -> GeometryId:
    """Return an id itself, or that of a number as arrays of results hold; no bool, no text."""
    if isinstance(value, GeometryId):
        return value
    if isinstance(value, bool) or not hasattr(value, '__index__'):
        raise ArgumentTypeError(f'geometry_id = {value!r} must be of type GeometryId')
    return GeometryId(value)  # type: ignore[arg-type]
