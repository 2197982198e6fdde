"""LCM's type system, as far as Drake's visualiser needs it: fingerprints and encoding.

Types are written down as tables and not generated, for encoding is a dozen lines and then needs no
library. The fingerprint, by which a listener knows that it has the same definition, is that of
LCM's "type specification": it is made of the names and the types of the members, and not of the
name of the type or its package. Numbers are big-endian.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

_START = 0x12345678  # of every fingerprint
_BITS = 64
_MASK = (1 << _BITS) - 1
_CONSTANT, _VARIABLE = 0, 1  # what the size of an array is
_NUMBERS = {'int8_t': '>i1', 'int32_t': '>i4', 'int64_t': '>i8', 'float': '>f4'}


@dataclass(frozen=True)
class TypeMember:
    """A member of a type, of a primitive type or another; sizes are numbers or earlier members."""

    name: str
    kind: str | LcmType
    sizes: tuple[int | str, ...] = ()


@dataclass(frozen=True, eq=False)
class LcmType:
    """A type, by its members in their order."""

    name: str
    members: tuple[TypeMember, ...]

    @cached_property
    def fingerprint(self) -> int:
        """The number (64 bits, unsigned) that all messages of the type begin with."""
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
    """Return a member in bytes; an array's size is told by another member."""
    if isinstance(member.kind, LcmType):
        return b''.join(member.kind._body(each) for each in value)
    if member.kind == 'string':
        texts = value if member.sizes else [value]
        return b''.join(map(_text, texts))
    return np.asarray(value).astype(_NUMBERS[member.kind]).tobytes()


def _text(text: str) -> bytes:
    """Return a text: its size, itself, and a zero, which the size counts."""
    data = text.encode() + b'\0'
    return struct.pack('>i', len(data)) + data


def _with(value: int, byte: int) -> int:
    """Return a fingerprint with a byte more; the shift to the right keeps the sign."""
    signed = value - (1 << _BITS if value >> (_BITS - 1) else 0)
    return (((value << 8) ^ (signed >> 55)) + byte) & _MASK


def _with_text(value: int, text: str) -> int:
    for byte in (len(text), *text.encode()):
        value = _with(value, byte)
    return value
