"""Many messages of one sender at once: where their numbers stand in bytes, learnt from rosbags.

A sender's messages differ in stamps and numbers only, so all have the same length, and the same
bytes elsewhere. Where a number stands is seen by what rosbags writes for another value of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.recordings.message_types import CLOCK, JOINTS, POSES, store_of
from drake_geom_ros.recordings.storages import Topic

Bytes = NDArray[np.uint8]

# What may differ, by its path in the message: of one number the type, of many None.
_STAMP: dict[str, str | None] = {'header.stamp.sec': '<i4', 'header.stamp.nanosec': '<u4'}
_FIELDS: dict[str, dict[str, str | None]] = {
    JOINTS: {**_STAMP, 'position': None, 'velocity': None, 'effort': None},
    POSES: {**_STAMP, 'poses': None},
    CLOCK: {'clock.sec': '<i4', 'clock.nanosec': '<u4'},
}
_HEAD = 4  # bytes that say how what follows is written: they count, but for the last two
_MOST_LAYOUTS = 64  # of a topic: its messages come one by one where they never repeat
_MOST_BYTES = 1 << 16


class Field(NamedTuple):
    """Where the numbers of a field stand."""

    start: int
    stop: int
    type: str


class Layout:
    """Messages of one topic that differ in some numbers alone."""

    def __init__(self, topic: Topic, data: bytes) -> None:
        """Learn it from the bytes of one message; raises ValueError where they are no model.

        What bytes that are no message raise is raised here.
        """
        store = store_of(topic)

        def read(given: bytes) -> Any:
            return store.deserialize_cdr(given, topic.type)

        def written(message: Any) -> bytes:
            return bytes(store.serialize_cdr(message, topic.type))

        self.sample = read(data)
        own = written(self.sample)
        if len(own) != len(data) or own[:2] != data[:2]:
            raise ValueError('it is written in another way than rosbags writes')
        self.fields = {
            path: _field(read(data), path, kind, own, written)
            for path, kind in _FIELDS[topic.type].items()
        }
        self._model = np.frombuffer(own, dtype=np.uint8)
        self._counts = np.ones(len(own), dtype=np.bool_)
        self._counts[2:_HEAD] = False
        for field in self.fields.values():
            self._counts[field.start : field.stop] = False
        for place in np.flatnonzero(self._counts).tolist():
            if place >= _HEAD and _is_padding(own, place, read, written):
                self._counts[place] = False

    def of(self, rows: Bytes) -> NDArray[np.bool_]:
        """Return which messages (n, bytes) are of this layout."""
        same: NDArray[np.bool_] = ((rows == self._model) | ~self._counts).all(axis=1)
        return same

    def numbers(self, rows: Bytes, path: str) -> NDArray[Any]:
        """Return the numbers (n, k) of a field of messages that are of this layout."""
        field = self.fields[path]
        return np.ascontiguousarray(rows[:, field.start : field.stop]).view(field.type)


class Layouts:
    """The layouts that were seen so far."""

    def __init__(self) -> None:
        # By the whole topic: with another definition the same bytes are other numbers.
        self._known: dict[tuple[Topic, int], list[Layout]] = {}
        self._counts: dict[Topic, int] = {}

    def may_know(self, topic: Topic, size: int, count: int) -> bool:
        """Return whether messages of a size [bytes] are such as may share a layout."""
        known = (topic, size) in self._known
        return topic.type in _FIELDS and size <= _MOST_BYTES and (known or count > 1)

    def of(self, topic: Topic, rows: Bytes) -> list[tuple[Layout, NDArray[np.int64]]]:
        """Return which messages (n, bytes) of one length share a layout; others are left out."""
        known = self._known.setdefault((topic, rows.shape[1]), [])
        left, found = np.arange(len(rows)), []
        for layout in known:
            same = layout.of(rows[left])
            if same.any():
                found.append((layout, left[same]))
                left = left[~same]
        # What comes once is not worth it, and of what never repeats nothing is learnt.
        while len(left) > 1 and self._counts.get(topic, 0) < _MOST_LAYOUTS:
            self._counts[topic] = self._counts.get(topic, 0) + 1
            try:
                layout = Layout(topic, rows[left[0]].tobytes())
                same = layout.of(rows[left])
            except Exception:  # they are no messages: who takes them one by one says so
                left = left[1:]
                continue
            known.append(layout)
            found.append((layout, left[same]))
            left = left[~same]
        return found


def _field(message: Any, path: str, kind: str | None, own: bytes, written: Any) -> Field:
    """Return where a field stands: there all bytes differ when all of its bits do."""
    *above, name = path.split('.')
    owner = reduce(getattr, above, message)
    value = getattr(owner, name)
    if kind is None:
        values = np.ascontiguousarray(value, dtype='<f8')
        if not values.size:
            return Field(0, 0, '<f8')
        other: Any = (~values.view(np.uint64)).view(np.float64)
    else:
        values = np.array([value], dtype=kind)
        other = int((~values)[0])
    setattr(owner, name, other)
    there = np.frombuffer(written(message), np.uint8) != np.frombuffer(own, np.uint8)
    start = int(np.argmax(there))
    stop = start + values.nbytes
    if not there[start:stop].all() or int(there.sum()) != values.nbytes:
        raise ValueError(f'{path} does not stand in one piece')
    return Field(start, stop, values.dtype.str)


def _is_padding(own: bytes, place: int, read: Any, written: Any) -> bool:
    """Return whether a byte says nothing, so that a sender may have left anything there."""
    changed = bytearray(own)
    changed[place] ^= 1
    try:
        return bool(written(read(bytes(changed))) == own)
    except Exception:  # a length, for instance
        return False


def rows_of(messages: Sequence[bytes]) -> Bytes:
    """Return messages of one length as rows."""
    return np.frombuffer(b''.join(messages), dtype=np.uint8).reshape(len(messages), -1)
