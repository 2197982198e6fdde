"""Part of LCM's type system that Drake's visualiser needs: fingerprints and encoding.

Types are tables and not generated code: encoding takes a dozen lines and no library. A listener
compares the fingerprint to detect other definitions. As in LCM's "type specification" it depends
on the names and types of the members, not on the name of the type or its package. Numbers are
big-endian.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

_START = 0x12345678  # initial value of every fingerprint
_BITS = 64
_MASK = (1 << _BITS) - 1
_CONSTANT, _VARIABLE = 0, 1  # kinds of array sizes
_NUMBERS = {'int8_t': '>i1', 'int32_t': '>i4', 'int64_t': '>i8', 'float': '>f4'}


@dataclass(frozen=True)
class TypeMember:
    """A member of a type, of a primitive type or another; sizes are numbers or earlier members."""

    name: str
    kind: str | LcmType
    sizes: tuple[int | str, ...] = ()


@dataclass(frozen=True, eq=False)
class LcmType:
    """A message type: its members in order."""

    name: str
    members: tuple[TypeMember, ...]

    @cached_property
    def fingerprint(self) -> int:
        """The number (64 bits, unsigned) at the beginning of all messages of the type."""
        value = _START
        for member in self.members:
            value = _with_text(value, member.name)
            if isinstance(member.kind, str):
                value = _with_text(value, member.kind)
            value = _with(value, len(member.sizes))
            for size in member.sizes:
                value = _with(value, _CONSTANT if isinstance(size, int) else _VARIABLE)
                value = _with_text(value, str(size))
        for member in self.members:
            if isinstance(member.kind, LcmType):
                value = (value + member.kind.fingerprint) & _MASK
        return ((value << 1) | (value >> (_BITS - 1))) & _MASK

    def encoded(self, values: Mapping[str, Any]) -> bytes:
        """Return a message: the fingerprint, then the members."""
        return struct.pack('>Q', self.fingerprint) + self._body(values)

    def _body(self, values: Mapping[str, Any]) -> bytes:
        return b''.join(_encoded(member, values[member.name]) for member in self.members)


def _encoded(member: TypeMember, value: Any) -> bytes:
    """Return a member as bytes, without the size of an array, which is another member."""
    if isinstance(member.kind, LcmType):
        return b''.join(member.kind._body(each) for each in value)
    if member.kind == 'string':
        texts = value if member.sizes else [value]
        return b''.join(map(_text, texts))
    return np.asarray(value).astype(_NUMBERS[member.kind]).tobytes()


def _text(text: str) -> bytes:
    """Return the bytes of a text: its size, its characters, and a zero, included in the size."""
    data = text.encode() + b'\0'
    return struct.pack('>i', len(data)) + data


def _with(value: int, byte: int) -> int:
    """Return a fingerprint with one more byte; the shift to the right is arithmetic."""
    signed = value - (1 << _BITS if value >> (_BITS - 1) else 0)
    return (((value << 8) ^ (signed >> 55)) + byte) & _MASK


def _with_text(value: int, text: str) -> int:
    for byte in (len(text), *text.encode()):
        value = _with(value, byte)
    return value
