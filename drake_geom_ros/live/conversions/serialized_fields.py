"""Fields of messages that are read by their bytes: plain CDR of a little-endian machine.

The layout is that of OMG, *DDS-RTPS* 2.5, 10.2 and *Extensible Types* 1.3, 7.4.1: a member stands
at a multiple of its size, counted from behind the four bytes that a message begins with.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

# A message begins so: the representation CDR_LE, and no options, which may shorten it.
LITTLE_ENDIAN = b'\x00\x01\x00\x00'
BEGIN = len(LITTLE_ENDIAN)
_WORD = 4  # [bytes]
_MOST_BYTES = 4_000_000  # in common that are kept of all senders
_MOST_SENDERS = 64
_KINDS = {'d': np.dtype('<f8'), 'Q': np.dtype('<u8')}
_SLACK = 4  # [bytes] that Fast DDS leaves behind a message for each empty array, at most


class NoFitError(Exception):
    """The bytes are laid out in another way: the middleware may read them, or refuse them."""


def aligned(at: int, size: int) -> int:
    """Return the first place from ``at`` on where a member of ``size`` [bytes] may stand."""
    return -(-at // size) * size


def text_at(body: bytes, at: int) -> tuple[str, int]:
    """Return the string that begins at a place in a message, and where it ends.

    Raises NoFitError where it is cut off, without its final NUL, with one inside, or no UTF-8:
    middlewares make different things of these.
    """
    try:
        (length,) = struct.unpack_from('<I', body, at)
        begin, end = at + 4, at + 4 + length
        if not length or body.find(b'\0', begin, end) != end - 1:
            raise NoFitError
        return body[begin : end - 1].decode(), end
    except (struct.error, UnicodeDecodeError):
        raise NoFitError from None


def arrays_in(raw: bytes, at: int, codes: str, empty: int = 0) -> list[Any]:
    """Return the arrays that begin at a place of a message, which ends with them.

    Before them there may be so many ``empty`` arrays.
    """
    arrays: list[Any] = []
    for code in codes:
        count, at = count_at(raw, BEGIN + aligned(at - BEGIN, 4))
        if count:
            at = BEGIN + aligned(at - BEGIN, 8)
        if at + 8 * count > len(raw):
            raise NoFitError
        # Copied, for in the message they may stand where a processor reads them slowly.
        values = np.frombuffer(raw, _KINDS[code], count, at)
        arrays.append(values.astype(np.float64) if code == 'd' else values.tolist())
        at += 8 * count
    if len(raw) - at > _SLACK * (len(codes) + 1 + empty):
        raise NoFitError
    return arrays


def count_at(body: bytes, at: int) -> tuple[int, int]:
    """Return the length of a sequence that begins at a place, and where its elements do."""
    try:
        (count,) = struct.unpack_from('<I', body, at)
    except struct.error:
        raise NoFitError from None
    return count, at + 4


class CommonBytes:
    """Bytes that messages of a sender have in common: the lengths and letters of names.

    What stands between them to fill up is different each time, for it is what was in memory.
    """

    def __init__(self, body: bytes, spans: Sequence[tuple[int, int]]) -> None:
        """``spans`` of ``body`` are in common; raises NoFitError for a body that ends there."""
        masks = np.zeros(aligned(spans[-1][1], _WORD), dtype=np.uint8)
        if len(body) < len(masks):
            raise NoFitError
        for begin, end in spans:
            masks[begin:end] = 0xFF
        self._masks = masks.view(np.uint32)
        self._words = np.frombuffer(body, np.uint32, len(self._masks)) & self._masks

    @property
    def size(self) -> int:
        """The length [bytes] of the part of a message that is looked at."""
        return _WORD * len(self._masks)

    def are_in(self, raw: bytes) -> bool:
        """Return whether a message begins as these do."""
        if raw[:BEGIN] != LITTLE_ENDIAN or len(raw) < BEGIN + self.size:
            return False
        words = np.frombuffer(raw, np.uint32, len(self._masks), BEGIN)
        return not ((words ^ self._words) & self._masks).any()


class HasCommonBytes(Protocol):
    """The part of a message that was read, with its bytes."""

    @property
    def common(self) -> CommonBytes:
        """The bytes of the part."""


_Part = TypeVar('_Part', bound=HasCommonBytes)


class PartsOfSenders(Generic[_Part]):
    """The parts that messages of each sender have in common, while they are small altogether."""

    def __init__(self) -> None:
        self._parts: dict[str, _Part] = {}

    def part_in(self, raw: bytes, sender: str) -> _Part | None:
        """Return the part of the last message, if this message begins with it, too."""
        part = self._parts.get(sender)
        return part if part is not None and part.common.are_in(raw) else None

    def keep(self, sender: str, part: _Part) -> None:
        """Keep the part of a message."""
        size = sum(each.common.size for each in self._parts.values())
        if len(self._parts) >= _MOST_SENDERS or size + part.common.size > _MOST_BYTES:
            self._parts.clear()
        self._parts[sender] = part
