"""A PointCloud2 as it comes, by its bytes: what rclpy makes of these takes longer than all else.

rclpy copies the points of a message three times, and holds the interpreter's lock meanwhile: 17
ms for 300 000 points, in which no pose was answered. Here they stay where they are. The layout is
that of plain CDR (OMG, *DDS-RTPS* 2.5, 10.2 and *Extensible Types* 1.3, 7.4.1).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, NamedTuple

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.point_cloud import refuse_too_many_fields

_ORDERS = {b'\x00\x00': '>', b'\x00\x01': '<'}  # CDR_BE and CDR_LE
_SIZES = {'B': 1, 'i': 4, 'I': 4}
_BEGIN = 4  # [bytes] of the representation's identifier and options


class Stamp(NamedTuple):
    """As builtin_interfaces/Time."""

    sec: int
    nanosec: int


class Header(NamedTuple):
    """As std_msgs/Header."""

    stamp: Stamp
    frame_id: str


@dataclass(frozen=True)
class CloudField:
    """As sensor_msgs/PointField."""

    name: str
    offset: int
    datatype: int
    count: int


class Cloud(NamedTuple):
    """As sensor_msgs/PointCloud2; the data are where they came."""

    header: Header
    height: int
    width: int
    fields: list[CloudField]
    is_bigendian: bool
    point_step: int
    row_step: int
    data: memoryview
    is_dense: bool


def is_plain(raw: bytes) -> bool:
    """Return whether a message is laid out as ``cloud_of_bytes`` reads it."""
    return raw[:2] in _ORDERS


def cloud_of_bytes(raw: bytes) -> Cloud:
    """Return the PointCloud2 that a message is; raises ArgumentError for one that is cut off."""
    reader = _Reader(raw)
    try:
        header = Header(Stamp(reader.number('i'), reader.number('I')), reader.text())
        height, width, count = (reader.number('I') for _ in range(3))
        refuse_too_many_fields(count)
        fields = [_field(reader) for _ in range(count)]
        is_bigendian = bool(reader.number('B'))
        point_step, row_step = reader.number('I'), reader.number('I')
        data = reader.bytes()
        is_dense = bool(reader.number('B'))
    except (struct.error, UnicodeDecodeError) as error:
        raise ArgumentError(f'the message of {len(raw)} bytes is cut off: {error}') from None
    return Cloud(
        header=header,
        height=height,
        width=width,
        fields=fields,
        is_bigendian=is_bigendian,
        point_step=point_step,
        row_step=row_step,
        data=data,
        is_dense=is_dense,
    )


def _field(reader: _Reader) -> CloudField:
    return CloudField(reader.text(), reader.number('I'), reader.number('B'), reader.number('I'))


class _Reader:
    """Reads one member after the other, each at a multiple of its size."""

    def __init__(self, raw: bytes) -> None:
        self._raw, self._at = memoryview(raw)[_BEGIN:], 0
        self._order = _ORDERS[raw[:2]]

    def number(self, code: str) -> Any:
        size = _SIZES[code]
        at = -(-self._at // size) * size
        (value,) = struct.unpack_from(self._order + code, self._raw, at)
        self._at = at + size
        return value

    def bytes(self) -> memoryview:
        count = self.number('I')
        part = self._raw[self._at : self._at + count]
        if len(part) < count:
            raise struct.error(f'{count} bytes are told of, and {len(part)} are left')
        self._at += count
        return part

    def text(self) -> str:
        return bytes(self.bytes()).rstrip(b'\0').decode()
