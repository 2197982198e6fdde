"""Refusal of messages with numbers that only an integer read as a double makes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.tolerances import SMALLEST_SENT

# Values of joints and speeds: filters that decay pass through every magnitude, and every client
# converts the elements of such arrays.
_MAY_DECAY = frozenset(
    ('position', 'positions', 'velocity', 'velocities', 'accelerations', 'effort', 'twists')
)
_FLOATS = ('double', 'float')


class _Fields(NamedTuple):
    """The fields of a message type that hold floating-point numbers, or messages."""

    scalars: tuple[str, ...]
    arrays: tuple[str, ...]
    messages: tuple[str, ...]
    sequences: tuple[str, ...]  # of messages


_known: dict[type, _Fields] = {}


def refuse_misread_numbers(message: Any) -> None:
    """Raise ArgumentError that names a number which is not 0 and nearer to 0 than 1e-300.

    Anything that is not a ROS message passes.
    """
    for name, value in _misread(message, ''):
        raise ArgumentError(f'{name}: {why_misread(value)}')


def why_misread(value: float) -> str:
    """Return in words why such a number is refused."""
    return (
        f'{value} is refused; a number is 0, or at least {SMALLEST_SENT:g} in magnitude. An '
        'integer in a floating-point field arrives as such a number, because rclpy does not '
        'convert it: write 1.0 instead of 1'
    )


def is_misread(values: Any) -> Any:
    """Return which of some numbers only an integer read as a double makes."""
    magnitudes = np.abs(values)
    return (magnitudes > 0.0) & (magnitudes < SMALLEST_SENT)


def _misread(message: Any, path: str) -> Iterator[tuple[str, float]]:
    """Yield the names and values of such numbers in a message."""
    fields = _fields_of(type(message))
    for name in fields.scalars:
        value = getattr(message, name)
        if 0.0 < abs(value) < SMALLEST_SENT:
            yield f'{path}{name}', value
    for name in fields.arrays:
        values = np.asarray(getattr(message, name), dtype=np.float64)
        if len(values) and (is_bad := is_misread(values)).any():
            first = int(np.argmax(is_bad))
            yield f'{path}{name}[{first}]', float(values[first])
    for name in fields.messages:
        yield from _misread(getattr(message, name), f'{path}{name}.')
    for name in fields.sequences:
        elements = getattr(message, name)
        if len(elements) and _has_numbers(elements[0]):
            for k, element in enumerate(elements):
                yield from _misread(element, f'{path}{name}[{k}].')


def _has_numbers(message: Any) -> bool:
    """Return whether messages of this type may hold a number that is looked at."""
    fields = _fields_of(type(message))
    if fields.scalars or fields.arrays or fields.sequences:
        return True
    return any(_has_numbers(getattr(message, name)) for name in fields.messages)


def _fields_of(kind: type) -> _Fields:
    fields = _known.get(kind)
    if fields is None:
        fields = _known[kind] = _read_fields(kind)
    return fields


def _read_fields(kind: type) -> _Fields:
    types: dict[str, str] = getattr(kind, 'get_fields_and_field_types', dict)()
    names_by_kind: tuple[list[str], ...] = ([], [], [], [])
    scalars, arrays, messages, sequences = names_by_kind
    for name, text in types.items():
        element = text.removeprefix('sequence<').partition('[')[0].partition(',')[0].rstrip('>')
        is_many = element != text
        if element in _FLOATS:
            if not is_many:
                scalars.append(name)
            elif name not in _MAY_DECAY:
                arrays.append(name)
        elif '/' in element:
            (sequences if is_many else messages).append(name)
    return _Fields(*map(tuple, names_by_kind))
