"""A TFMessage as it comes, by its bytes: rclpy makes 20 us of Python objects of each transform.

A sender names the same frames in each message, so the bytes of the names are compared with those
of the message before, and the numbers stand where they stood. The layout is that of plain CDR in
the order of a little-endian machine, see ``serialized_cloud``. What does not fit to the last byte,
such as a name that is no UTF-8, is left to the middleware.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from drake_geom_ros.live.conversions.serialized_fields import (
    BEGIN,
    LITTLE_ENDIAN,
    CommonBytes,
    NoFitError,
    aligned,
    text_at,
)
from drake_geom_ros.live.conversions.transforms import (
    TransformNames,
    Transforms,
    names_of,
    plain_name,
    times_of,
)
from drake_geom_ros.math.array_types import Indices

_MOST_BYTES = 4_000_000  # of messages whose layouts are kept, each takes about three times as much
_MOST_LAYOUTS = 64
_NUMBERS = 7  # of a transform


@dataclass(frozen=True)
class _Layout:
    """The layout of messages that name the same frames.

    Behind the four bytes that a message begins with it is seen as words of 8 and of 4 bytes.
    """

    names: TransformNames
    common: CommonBytes
    stamps_at: Indices  # (n,) the words of 4 bytes that are seconds; nanoseconds come behind
    rows_at: Indices  # (n, 7) the words of 8 bytes that are numbers

    def transforms(self, raw: bytes, stamp: Callable[[int, int], Any]) -> Transforms:
        """Return the transforms of a message that fits."""
        seconds = np.frombuffer(raw, '<i4', offset=BEGIN)[self.stamps_at].astype(np.int64)
        nanoseconds = np.frombuffer(raw, '<u4', offset=BEGIN)[self.stamps_at + 1].astype(np.int64)
        return Transforms(
            self.names,
            np.frombuffer(raw, '<f8', offset=BEGIN)[self.rows_at],
            *times_of(seconds, nanoseconds),
            lambda k: stamp(int(seconds[k]), int(nanoseconds[k])),
        )


class TransformReader:
    """Reads TFMessages by their bytes; keeps the layouts of the senders' last messages."""

    def __init__(self, stamp: Callable[[int, int], Any]) -> None:
        """``stamp`` makes a builtin_interfaces/Time of seconds and nanoseconds."""
        self._stamp = stamp
        self._layouts: dict[tuple[str, int], _Layout] = {}

    def read(self, raw: bytes, sender: str = '') -> Transforms | None:
        """Return the transforms of a message; None for one that is laid out otherwise."""
        key = sender, len(raw)
        layout = self._layouts.get(key)
        if layout is None or not layout.common.are_in(raw):
            try:
                layout = _layout_of(raw)
            except NoFitError:
                return None
            size = sum(length for _, length in self._layouts)
            if len(self._layouts) >= _MOST_LAYOUTS or size + len(raw) > _MOST_BYTES:
                self._layouts.clear()
            self._layouts[key] = layout
        return layout.transforms(raw, self._stamp)


def _layout_of(raw: bytes) -> _Layout:
    """Return the layout of a message; raises NoFitError for one that is none of these."""
    if raw[:BEGIN] != LITTLE_ENDIAN or len(raw) < BEGIN + 4:
        raise NoFitError
    body = raw[BEGIN:]
    (count,), at = struct.unpack_from('<I', body), 4
    names, stamps_at, rows_at, spans = [], list[int](), list[int](), [(0, at)]
    while at < len(body):
        stamp_at = aligned(at, 4)
        begin = stamp_at + 8
        parent, at = text_at(body, begin)
        child_at = aligned(at, 4)
        child, end = text_at(body, child_at)
        spans += [(begin, at), (child_at, end)]
        row_at = aligned(end, 8)
        at = row_at + 8 * _NUMBERS
        names.append((plain_name(parent), plain_name(child)))
        stamps_at.append(stamp_at // 4)
        rows_at.append(row_at // 8)
    if not names or len(names) != count or at != len(body):
        raise NoFitError
    return _Layout(
        names=names_of(tuple(names)),
        common=CommonBytes(body, spans),
        stamps_at=np.array(stamps_at, dtype=np.int64),
        rows_at=np.array(rows_at, dtype=np.int64)[:, np.newaxis] + np.arange(_NUMBERS),
    )
