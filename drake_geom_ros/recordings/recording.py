"""Recording as a stream of messages, in the order of recording."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from heapq import merge
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

from drake_geom_ros.recordings.message_types import message_of
from drake_geom_ros.recordings.raw_messages import Damage, Lost, Raw, RecordedTopic
from drake_geom_ros.recordings.recording_files import missing_files, places_of
from drake_geom_ros.recordings.storages import Storage

_MISSING = 'metadata.yaml names it, and it is not there'
_MOST_MESSAGES, _MOST_BYTES = 4096, 1 << 23  # of a batch


class Recorded(NamedTuple):
    """A recorded message."""

    time: int  # [ns] of recording
    topic: RecordedTopic
    message: Any  # None: its bytes cannot be decoded as its type
    reason: str = ''  # why they cannot


class Recording:
    """The files of one recording, MCAP or sqlite3, whole or damaged.

    ``topics`` are those of all files, ``damage`` are the unreadable parts so far. ``begin`` and
    ``end`` [ns] are the first and last time of all messages, used or not. Raises RecordingError if
    nothing can be read.
    """

    def __init__(self, paths: str | Path | Sequence[str | Path]) -> None:
        """Open ``paths``: a file, a folder that rosbag2 wrote, or several of these."""
        self._storages = [Storage(place) for place in places_of(paths)]
        self._missing = [Damage(str(path), Lost(_MISSING), 0) for path in missing_files(paths)]
        spans = [storage.span for storage in self._storages if storage.span is not None]
        self.begin = min((first for first, _ in spans), default=0)
        self.end = max((last for _, last in spans), default=0)
        topics = (topic for storage in self._storages for topic in storage.topics)
        self.topics: list[RecordedTopic] = list(dict.fromkeys(topics))

    @property
    def is_empty(self) -> bool:
        """True if there is no message of any topic; a message may have the time 0."""
        return all(storage.span is None for storage in self._storages)

    @property
    def files(self) -> list[Path]:
        """The storage files and folders."""
        return [storage.path for storage in self._storages]

    @property
    def damage(self) -> list[Damage]:
        """Unreadable parts, as far as messages were read."""
        damages = (each for storage in self._storages for each in storage.damage)
        return list(dict.fromkeys([*self._missing, *damages]))

    def messages(self, names: Collection[str]) -> Iterator[Recorded]:
        """Yield the messages of some topics in the order of their times, merged over files."""
        return map(recorded, self._raw(names))

    def batches(self, names: Collection[str]) -> Iterator[list[Raw]]:
        """Yield the messages of some topics as bytes, in batches."""
        batch, size = [], 0
        for raw in self._raw(names):
            batch.append(raw)
            size += len(raw.data)
            if len(batch) >= _MOST_MESSAGES or size >= _MOST_BYTES:
                yield batch
                batch, size = [], 0
        if batch:
            yield batch

    def _raw(self, names: Collection[str]) -> Iterator[Raw]:
        streams = [storage.messages(names) for storage in self._storages]
        return merge(*streams, key=attrgetter('time'))


def recorded(raw: Raw) -> Recorded:
    """Return the message of some bytes, or the reason why they cannot be decoded."""
    try:
        message, reason = message_of(raw.topic, raw.data), ''
    except Exception as error:  # generated decoders raise any kind for invalid bytes
        message, reason = None, f'{raw.topic.type} cannot be read of its bytes: {error}'
    return Recorded(raw.time, raw.topic, message, reason)
