"""TrackedObjects messages by their bytes: names and shapes, which repeat, then arrays of numbers.

A tracker names the same bodies in most messages, so the bytes of names and shapes are compared
with those of the message before. rclpy takes 0.3 ms for 50 bodies, and to look for misread numbers
in their shapes as long again.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.live.conversions.misread_numbers import is_misread
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
_NONE = np.zeros(0)


class ReadShape(NamedTuple):
    """As drake_geom_msgs/Shape."""

    type: int
    dimensions: Floats
    mesh_uri: str
    vertices: Floats
    triangles: Any


class ReadTrackedObjects(NamedTuple):
    """As drake_geom_msgs/TrackedObjects.

    ``sizes`` are all numbers of the shapes; none where they were looked at in another message.
    """

    header: Header
    names: tuple[str, ...]
    shapes: tuple[ReadShape, ...]
    poses: Floats
    velocities: Floats
    lifetimes: Floats
    sizes: Floats

    @staticmethod
    def get_fields_and_field_types() -> dict[str, str]:
        """Return the types of fields that hold numbers: see ``misread_numbers``."""
        return dict.fromkeys(('poses', 'velocities', 'lifetimes', 'sizes'), 'sequence<double>')


class _Bodies(NamedTuple):
    """The names and shapes that some messages have in common, with the bytes of these."""

    common: CommonBytes
    frame_id: str
    names: tuple[str, ...]
    shapes: tuple[ReadShape, ...]
    sizes: Floats
    empty: int  # arrays of shapes that are


class TrackedObjectsBytes:
    """Reads TrackedObjects; keeps the names and shapes of the senders' last messages."""

    def __init__(self, stamp: Callable[[int, int], Any]) -> None:
        """``stamp`` makes a builtin_interfaces/Time."""
        self._stamp = stamp
        self._bodies: PartsOfSenders[_Bodies] = PartsOfSenders()

    def repeats(self, raw: bytes, sender: str = '') -> bool:
        """Return whether a message has the bodies of its sender's last one that was read."""
        return self._bodies.part_in(raw, sender) is not None

    def read(self, raw: bytes, sender: str = '') -> ReadTrackedObjects | None:
        """Return a message; None for one that is laid out otherwise.

        Of messages with the same bodies ``shapes`` is the same tuple.
        """
        last = self._bodies.part_in(raw, sender)
        try:
            bodies = last or _Walk(raw).bodies()
            at = BEGIN + bodies.common.size
            poses, velocities, lifetimes = arrays_in(raw, at, 'ddd', bodies.empty)
            seconds, nanoseconds = struct.unpack_from('<iI', raw, BEGIN)
        except NoFitError:
            return None
        sizes = _NONE
        if last is None:
            sizes = bodies.sizes
            if not is_misread(sizes).any():  # else the next message with them is refused, too
                self._bodies.keep(sender, bodies)
        header = Header(self._stamp(seconds, nanoseconds), bodies.frame_id)
        return ReadTrackedObjects(
            header, bodies.names, bodies.shapes, poses, velocities, lifetimes, sizes
        )


class _Walk:
    """One walk through the names and shapes of a message, which notes where they stand."""

    def __init__(self, raw: bytes) -> None:
        if raw[:BEGIN] != LITTLE_ENDIAN:
            raise NoFitError
        self._body, self._at = raw[BEGIN:], _NAMES_AT
        self._spans: list[tuple[int, int]] = []

    def bodies(self) -> _Bodies:
        """Return the names and shapes."""
        frame_id = self._text()
        names = tuple([self._text() for _ in range(self._count())])
        count = self._count()
        if count != len(names):  # it is refused, by what knows how to say that
            raise NoFitError
        shapes = tuple([self._shape() for _ in range(count)])
        numbers = [part for shape in shapes for part in (shape.dimensions, shape.vertices)]
        sizes = np.concatenate([np.zeros(0), *numbers])
        empty = sum(not len(part) for part in [*numbers, *(s.triangles for s in shapes)])
        common = CommonBytes(self._body, self._spans)
        return _Bodies(common, frame_id, names, shapes, sizes, empty)

    def _shape(self) -> ReadShape:
        kind = self._part(1, 1)[0]
        dimensions = self._array('<f8')
        return ReadShape(kind, dimensions, self._text(), self._array('<f8'), self._array('<u4'))

    def _part(self, size: int, count: int) -> bytes:
        """Return some bytes at the next place where a member of ``size`` may stand."""
        begin = aligned(self._at, size)
        self._at = begin + size * count
        if self._at > len(self._body):
            raise NoFitError
        self._spans.append((begin, self._at))
        return self._body[begin : self._at]

    def _count(self) -> int:
        begin = aligned(self._at, 4)
        count, self._at = count_at(self._body, begin)
        self._spans.append((begin, self._at))
        return count

    def _text(self) -> str:
        begin = aligned(self._at, 4)
        text, self._at = text_at(self._body, begin)
        self._spans.append((begin, self._at))
        return text

    def _array(self, code: str) -> Any:
        kind = np.dtype(code)
        count = self._count()
        if not count:
            return np.zeros(0, kind)
        return np.frombuffer(self._part(kind.itemsize, count), kind)
