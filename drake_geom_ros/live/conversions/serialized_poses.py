"""JointState, FramePoses and FrameTwists by their bytes: names, which repeat, and arrays.

A sender names the same joints or frames in each message, so the bytes of the names are compared
with those of the message before. What does not fit, such as a name that is no UTF-8, is left to
the middleware.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, NamedTuple

from drake_geom_ros.live.conversions.serialized_cloud import Header
from drake_geom_ros.live.conversions.serialized_fields import (
    BEGIN,
    LITTLE_ENDIAN,
    CommonBytes,
    NoFitError,
    PartsOfSenders,
    aligned,
    arrays_in,
    count_at,
    text_at,
)
from drake_geom_ros.math.array_types import Floats

_NAMES_AT = 8  # behind the stamp


class ReadJointState(NamedTuple):
    """As sensor_msgs/JointState."""

    header: Header
    name: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats


class ReadFramePoses(NamedTuple):
    """As drake_geom_msgs/FramePoses."""

    header: Header
    source: str
    frame_names: tuple[str, ...]
    frame_ids: list[int]
    poses: Floats

    @staticmethod
    def get_fields_and_field_types() -> dict[str, str]:
        """Return the types of fields that hold numbers: see ``misread_numbers``."""
        return {'poses': 'sequence<double>'}


class ReadFrameTwists(NamedTuple):
    """As drake_geom_msgs/FrameTwists."""

    header: Header
    source: str
    frame_names: tuple[str, ...]
    frame_ids: list[int]
    twists: Floats


class _Layout(NamedTuple):
    """The members of a message behind its header: texts, lists of texts, then arrays."""

    kind: Callable[..., Any]
    texts: int
    arrays: str  # d of float64, Q of uint64


_LAYOUTS = {
    'JointState': _Layout(ReadJointState, 0, 'ddd'),
    'FramePoses': _Layout(ReadFramePoses, 1, 'Qd'),
    'FrameTwists': _Layout(ReadFrameTwists, 1, 'Qd'),
}


class _Names(NamedTuple):
    """The names that some messages have in common, with the bytes of these."""

    common: CommonBytes
    frame_id: str
    members: tuple[str | tuple[str, ...], ...]


class PoseReader:
    """Reads messages of one type; keeps the names of the senders' last messages."""

    def __init__(self, kind: str, stamp: Callable[[int, int], Any]) -> None:
        """``kind`` is the name of the type, ``stamp`` makes a builtin_interfaces/Time."""
        self._layout, self._stamp = _LAYOUTS[kind], stamp
        self._names: PartsOfSenders[_Names] = PartsOfSenders()

    def read(self, raw: bytes, sender: str = '') -> Any:
        """Return a message; None for one that is laid out otherwise.

        It has the fields that the message of ROS has; texts are in tuples, numbers in arrays.
        """
        last = self._names.part_in(raw, sender)
        try:
            names = last or _names_in(raw, self._layout.texts)
            arrays = arrays_in(raw, BEGIN + names.common.size, self._layout.arrays)
            seconds, nanoseconds = struct.unpack_from('<iI', raw, BEGIN)
        except NoFitError:
            return None
        if last is None:
            self._names.keep(sender, names)
        header = Header(self._stamp(seconds, nanoseconds), names.frame_id)
        return self._layout.kind(header, *names.members, *arrays)


def _names_in(raw: bytes, texts: int) -> _Names:
    """Return the texts of a message, and its list of texts."""
    if raw[:BEGIN] != LITTLE_ENDIAN:
        raise NoFitError
    body, spans = raw[BEGIN:], list[tuple[int, int]]()

    def text(at: int) -> str:
        value, end = text_at(body, at)
        spans.append((at, end))
        return value

    def next_at() -> int:
        return aligned(spans[-1][1], 4)

    frame_id = text(_NAMES_AT)
    members: list[str | tuple[str, ...]] = [text(next_at()) for _ in range(texts)]
    count, end = count_at(body, next_at())
    spans.append((end - 4, end))
    members.append(tuple([text(next_at()) for _ in range(count)]))
    return _Names(CommonBytes(body, spans), frame_id, tuple(members))
