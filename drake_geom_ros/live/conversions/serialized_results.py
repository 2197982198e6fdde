"""Messages of results as the bytes that are sent: plain CDR, see ``serialized_fields``.

rclpy turns a message into C, and the middleware that into bytes. After 10 ms of other work most of
this time goes to code and objects that come back from memory, so results are written as bytes:
a cycle of two arms at 100 Hz takes 37 of 447 us less, and one of 1000 bodies 66 of 1978 us.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.live.conversions.serialized_fields import LITTLE_ENDIAN

_FILLED_UP = tuple(bytes(size) for size in range(8))
_SEQUENCE = 'sequence<'
_SCALARS = {'uint32': '<I', 'uint64': '<Q', 'double': '<d'}
_ELEMENTS = {
    'boolean': np.dtype(np.bool_),
    'uint8': np.dtype(np.uint8),
    'uint32': np.dtype('<u4'),
    'uint64': np.dtype('<u8'),
    'double': np.dtype('<f8'),
}
_Write = Callable[[bytearray, Any], None]


class ResultRecord(SimpleNamespace):
    """The fields of a message of results; arrays of numbers are NumPy's and stay as they are."""

    def fill(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Take arrays by the names of fields."""
        self.__dict__.update(arrays)


class ResultWriter:
    """Writes records of one message type."""

    def __init__(self, kind: Any) -> None:
        """Prepare the fields of ``kind``; raises KeyError where one is not written here."""
        types: Mapping[str, str] = kind.get_fields_and_field_types()
        self._kind = kind
        self._members = [(name, _writer_of(text)) for name, text in types.items()]

    def record(self) -> ResultRecord:
        """Return a record that holds what a new message does."""
        message = self._kind()
        fields = {name: getattr(message, name) for name, _ in self._members}
        header = fields['header']
        fields['header'] = SimpleNamespace(stamp=header.stamp, frame_id=header.frame_id)
        return ResultRecord(**fields)

    def bytes_of(self, record: Any) -> bytes:
        """Return the bytes of a record, or of a message of this type."""
        body = bytearray()
        for name, write in self._members:
            write(body, getattr(record, name))
        return LITTLE_ENDIAN + body


def _element_of(text: str) -> str:
    return text.removeprefix(_SEQUENCE).removesuffix('>')


def _writer_of(text: str) -> _Write:
    """Return what writes a field of a type; raises KeyError where nothing does."""
    if text == 'std_msgs/Header':
        return _write_header
    if text == 'sequence<string>':
        return _write_texts
    if text.startswith(_SEQUENCE):
        return _sequence_writer(_ELEMENTS[_element_of(text)])
    return _scalar_writer(struct.Struct(_SCALARS[text]))


def _align(body: bytearray, size: int) -> None:
    """Fill up to where a member of ``size`` [bytes] may stand."""
    if over := len(body) % size:
        body += _FILLED_UP[size - over]


def _scalar_writer(packed: struct.Struct) -> _Write:
    def write(body: bytearray, value: Any) -> None:
        _align(body, packed.size)
        body += packed.pack(value)

    return write


def _sequence_writer(dtype: np.dtype[Any]) -> _Write:
    def write(body: bytearray, values: Any) -> None:
        _align(body, 4)
        values = np.asarray(values, dtype)
        body += values.size.to_bytes(4, 'little')
        if values.size:
            _align(body, dtype.itemsize)
            body += values.tobytes()

    return write


def _write_header(body: bytearray, header: Any) -> None:
    stamp = header.stamp
    body += struct.pack('<iI', stamp.sec, stamp.nanosec)
    _write_text(body, header.frame_id)


def _write_texts(body: bytearray, texts: Any) -> None:
    _align(body, 4)
    body += len(texts).to_bytes(4, 'little')
    for text in texts:
        _write_text(body, text)


def _write_text(body: bytearray, text: str) -> None:
    _align(body, 4)
    raw = text.encode() + b'\0'
    body += len(raw).to_bytes(4, 'little') + raw
