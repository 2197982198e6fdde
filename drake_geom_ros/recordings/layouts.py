"""Layouts of repeating messages: byte positions of their numbers, learnt from rosbags.

Messages of one sender usually differ only in stamps and numbers, so they have the same length and
equal bytes elsewhere. The positions of numbers follow from what rosbags writes for other values.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.math.array_types import Indices
from drake_geom_ros.recordings.message_types import CLOCK, JOINTS, POSES, TF, store_of
from drake_geom_ros.recordings.raw_messages import RecordedTopic

Bytes = NDArray[np.uint8]

# Fields that may differ, by path in the message, and their types; `*` is each of a sequence.
_STAMP = {'header.stamp.sec': '<i4', 'header.stamp.nanosec': '<u4'}
TRANSFORMS = 'transforms.*'
# Each transform as x y z qx qy qz qw.
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
_HEAD = 4  # bytes of the encapsulation header, whose last two do not matter
_MOST_LAYOUTS = 64  # of a topic; messages that never repeat are read one by one
_MOST_BYTES = 1 << 16
_MOST_TRIED = 1 << 25  # bytes of a topic's messages that are decoded again to find padding


class FieldBytes(NamedTuple):
    """Byte positions of a field's numbers."""

    places: Indices  # of their bytes, in order
    type: str


class MessageLayout:
    """Layout of messages of one topic that differ only in some numbers."""

    def __init__(self, topic: RecordedTopic, data: bytes, most_tried: int = _MOST_TRIED) -> None:
        """Learn the layout from the bytes of one message; ValueError if that is impossible.

        At most ``most_tried`` bytes are decoded again to find padding; other bytes must match.
        Errors of decoding are raised unchanged.
        """
        store = store_of(topic)

        def read(content: bytes) -> Any:
            return store.deserialize_cdr(content, topic.type)

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
        """Return the bytes that may be padding: zeros after another zero.

        Padding follows the end of a text, or a length whose highest byte is 0.
        """
        zero = self._model == 0
        may_be = self._counts & zero & np.append(False, zero[:-1])
        may_be[:_HEAD] = False
        return np.flatnonzero(may_be)

    def of(self, rows: Bytes) -> NDArray[np.bool_]:
        """Return a mask (n,) of the messages (n, bytes) that have this layout."""
        same: NDArray[np.bool_] = ((rows == self._model) | ~self._counts).all(axis=1)
        return same

    def numbers(self, rows: Bytes, path: str) -> NDArray[Any]:
        """Return the numbers (n, k) of a field of messages that have this layout."""
        field = self.fields[path]
        return np.ascontiguousarray(rows[:, field.places]).view(field.type)


class Layouts:
    """Cache of the layouts that were learnt so far."""

    def __init__(self) -> None:
        # The key includes the definition, since it decides the meaning of bytes.
        self._layouts: dict[tuple[RecordedTopic, int], list[MessageLayout]] = {}
        self._counts: dict[RecordedTopic, int] = {}
        self._tried: dict[RecordedTopic, int] = {}

    def may_know(self, topic: RecordedTopic, size: int, count: int) -> bool:
        """Return whether ``count`` messages of a size [bytes] may share a layout."""
        has_layouts = (topic, size) in self._layouts
        return topic.type in _FIELDS and size <= _MOST_BYTES and (has_layouts or count > 1)

    def of(self, topic: RecordedTopic, rows: Bytes) -> list[tuple[MessageLayout, Indices]]:
        """Return layouts with the rows of ``rows`` (n, bytes) that share them.

        All messages have one length; those without a layout are omitted.
        """
        layouts = self._layouts.setdefault((topic, rows.shape[1]), [])
        left, groups = np.arange(len(rows)), []
        for layout in layouts:
            same = layout.of(rows[left])
            if same.any():
                groups.append((layout, left[same]))
                left = left[~same]
        # A single message is not worth a layout, and topics that never repeat learn no more.
        while len(left) > 1 and self._counts.get(topic, 0) < _MOST_LAYOUTS:
            self._counts[topic] = self._counts.get(topic, 0) + 1
            try:
                tried = self._tried.get(topic, 0)
                layout = MessageLayout(topic, rows[left[0]].tobytes(), _MOST_TRIED - tried)
                self._tried[topic] = tried + layout.tried
                same = layout.of(rows[left])
            except Exception:  # not decodable, which reading one by one reports
                left = left[1:]
                continue
            layouts.append(layout)
            groups.append((layout, left[same]))
            left = left[~same]
        return groups


def _field(read: Any, path: str, kind: str, own: bytes, written: Any) -> FieldBytes:
    """Return the positions of a field: the bytes that change if all of its bits are inverted.

    ``read()`` returns a message of the bytes ``own``.
    """
    values = _values(read(), path, kind)
    if not values.size:
        return FieldBytes(np.zeros(0, dtype=np.int64), kind)
    other = (~values.view(f'<u{values.itemsize}')).view(kind)
    inverted = np.frombuffer(_changed(read(), path, other, written), np.uint8)
    places = np.flatnonzero(inverted != np.frombuffer(own, np.uint8))
    # Distinct values show the order of the numbers.
    some = np.arange(1, len(values) + 1).astype(kind)
    seen = np.frombuffer(_changed(read(), path, some, written), np.uint8)[places]
    if len(places) != values.nbytes or seen.tobytes() != some.tobytes():
        raise ValueError(f'{path} does not stand in its order')
    return FieldBytes(places, kind)


def _owners(message: Any, path: str) -> Iterator[tuple[Any, str]]:
    """Yield the objects that own the fields of a path, and the field's name."""
    name, _, rest = path.partition('.')
    if not rest:
        yield message, name
    elif name == '*':
        for each in message:
            yield from _owners(each, rest)
    else:
        yield from _owners(getattr(message, name), rest)


def _values(message: Any, path: str, kind: str) -> NDArray[Any]:
    parts = (np.atleast_1d(getattr(*each)) for each in _owners(message, path))
    return np.concatenate([np.zeros(0), *parts]).astype(kind)


def _changed(message: Any, path: str, values: NDArray[Any], written: Any) -> bytes:
    """Return the bytes of a message with other values of a field."""
    for k, (owner, name) in enumerate(_owners(message, path)):
        is_array = isinstance(getattr(owner, name), np.ndarray)
        setattr(owner, name, values if is_array else values[k].item())
    return bytes(written(message))


def _is_padding(own: bytes, place: int, read: Any, written: Any) -> bool:
    """Return whether a byte has no effect, so that a sender may have left any value there."""
    changed = bytearray(own)
    changed[place] ^= 1
    try:
        return bool(written(read(bytes(changed))) == own)
    except Exception:  # for example, the byte of a length
        return False


def rows_of(messages: Sequence[bytes]) -> Bytes:
    """Return messages of one length as rows (n, bytes)."""
    return np.frombuffer(b''.join(messages), dtype=np.uint8).reshape(len(messages), -1)
