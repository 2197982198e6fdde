"""Many messages of one sender at once: where their numbers stand in bytes, learnt from rosbags.

A sender's messages differ in stamps and numbers only, so all have the same length, and the same
bytes elsewhere. Where numbers stand is seen by what rosbags writes for other values of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.recordings.message_types import CLOCK, JOINTS, POSES, TF, store_of
from drake_geom_ros.recordings.raw_messages import Topic

Bytes = NDArray[np.uint8]
Indices = NDArray[np.int64]

# What may differ, by its path in the message, and its type: `*` stands for each of a sequence.
_STAMP = {'header.stamp.sec': '<i4', 'header.stamp.nanosec': '<u4'}
TRANSFORMS = 'transforms.*'
# Of each transform x y z qx qy qz qw.
TRANSFORM_NUMBERS = tuple(
    f'{TRANSFORMS}.transform.{part}.{axis}'
    for part, axes in (('translation', 'xyz'), ('rotation', 'xyzw'))
    for axis in axes
)
_FIELDS: dict[str, dict[str, str]] = {
    JOINTS: {**_STAMP, 'position': '<f8', 'velocity': '<f8', 'effort': '<f8'},
    POSES: {**_STAMP, 'poses': '<f8'},
    CLOCK: {'clock.sec': '<i4', 'clock.nanosec': '<u4'},
    TF: {
        **{f'{TRANSFORMS}.{path}': kind for path, kind in _STAMP.items()},
        **dict.fromkeys(TRANSFORM_NUMBERS, '<f8'),
    },
}
_HEAD = 4  # bytes that say how what follows is written: they count, but for the last two
_MOST_LAYOUTS = 64  # of a topic: its messages come one by one where they never repeat
_MOST_BYTES = 1 << 16
_MOST_TRIED = 1 << 25  # bytes of messages of a topic that are read again to find padding


class Field(NamedTuple):
    """Where the numbers of a field stand."""

    places: Indices  # of their bytes, in order
    type: str


class Layout:
    """Messages of one topic that differ in some numbers alone."""

    def __init__(self, topic: Topic, data: bytes, most_tried: int = _MOST_TRIED) -> None:
        """Learn it from the bytes of one message; raises ValueError where they are no model.

        At most ``most_tried`` bytes are read again to find padding; what is left counts. What
        bytes that are no message raise is raised here.
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
            path: _field(lambda: read(data), path, kind, own, written)
            for path, kind in _FIELDS[topic.type].items()
        }
        self._model = np.frombuffer(own, dtype=np.uint8)
        self._counts = np.ones(len(own), dtype=np.bool_)
        self._counts[2:_HEAD] = False
        for field in self.fields.values():
            self._counts[field.places] = False
        places = self._may_be_padding()[: max(most_tried, 0) // len(own)]
        self.tried = len(places) * len(own)
        for place in places:
            if _is_padding(own, place, read, written):
                self._counts[place] = False

    def _may_be_padding(self) -> Indices:
        """Return the bytes that may say nothing: rosbags writes 0 there, behind another 0.

        For padding comes behind the end of a text, or behind a length, which is no such large one.
        """
        zero = self._model == 0
        may_be = self._counts & zero & np.append(False, zero[:-1])
        may_be[:_HEAD] = False
        return np.flatnonzero(may_be)

    def of(self, rows: Bytes) -> NDArray[np.bool_]:
        """Return which messages (n, bytes) are of this layout."""
        same: NDArray[np.bool_] = ((rows == self._model) | ~self._counts).all(axis=1)
        return same

    def numbers(self, rows: Bytes, path: str) -> NDArray[Any]:
        """Return the numbers (n, k) of a field of messages that are of this layout."""
        field = self.fields[path]
        return np.ascontiguousarray(rows[:, field.places]).view(field.type)


class Layouts:
    """The layouts that were seen so far."""

    def __init__(self) -> None:
        # By the whole topic: with another definition the same bytes are other numbers.
        self._known: dict[tuple[Topic, int], list[Layout]] = {}
        self._counts: dict[Topic, int] = {}
        self._tried: dict[Topic, int] = {}

    def may_know(self, topic: Topic, size: int, count: int) -> bool:
        """Return whether messages of a size [bytes] are such as may share a layout."""
        known = (topic, size) in self._known
        return topic.type in _FIELDS and size <= _MOST_BYTES and (known or count > 1)

    def of(self, topic: Topic, rows: Bytes) -> list[tuple[Layout, Indices]]:
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
                tried = self._tried.get(topic, 0)
                layout = Layout(topic, rows[left[0]].tobytes(), _MOST_TRIED - tried)
                self._tried[topic] = tried + layout.tried
                same = layout.of(rows[left])
            except Exception:  # they are no messages: who takes them one by one says so
                left = left[1:]
                continue
            known.append(layout)
            found.append((layout, left[same]))
            left = left[~same]
        return found


def _field(read: Any, path: str, kind: str, own: bytes, written: Any) -> Field:
    """Return where a field stands: there all bytes differ when all of its bits do.

    ``read()`` is a message of the bytes ``own``.
    """
    values = _values(read(), path, kind)
    if not values.size:
        return Field(np.zeros(0, dtype=np.int64), kind)
    other = (~values.view(f'<u{values.itemsize}')).view(kind)
    there = np.frombuffer(_changed(read(), path, other, written), np.uint8)
    places = np.flatnonzero(there != np.frombuffer(own, np.uint8))
    # All distinct, so their order is seen.
    some = np.arange(1, len(values) + 1).astype(kind)
    seen = np.frombuffer(_changed(read(), path, some, written), np.uint8)[places]
    if len(places) != values.nbytes or seen.tobytes() != some.tobytes():
        raise ValueError(f'{path} does not stand in its order')
    return Field(places, kind)


def _owners(message: Any, path: str) -> Iterator[tuple[Any, str]]:
    """Yield what has the fields of a path, and the name of the field there."""
    name, _, rest = path.partition('.')
    if not rest:
        yield message, name
    elif name == '*':
        for each in message:
            yield from _owners(each, rest)
    else:
        yield from _owners(getattr(message, name), rest)


def _values(message: Any, path: str, kind: str) -> NDArray[Any]:
    found = (np.atleast_1d(getattr(*each)) for each in _owners(message, path))
    return np.concatenate([np.zeros(0), *found]).astype(kind)


def _changed(message: Any, path: str, values: NDArray[Any], written: Any) -> bytes:
    """Return the bytes of a message with other values of a field."""
    for k, (owner, name) in enumerate(_owners(message, path)):
        is_array = isinstance(getattr(owner, name), np.ndarray)
        setattr(owner, name, values if is_array else values[k].item())
    return bytes(written(message))


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
