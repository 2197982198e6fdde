"""Storage files, message by message as bytes: whole ones by rosbags, of damaged ones what is left.

A whole file is read in the order of its times. What is wrong with a damaged one is kept as
``Damage``, with the time until which it told something.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Collection, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

from drake_geom_ros.recordings.errors import RecordingError

_LIBRARIES = (
    'recordings are read by rosbags and mcap: pip install rosbags mcap, or this package with its '
    "extra 'recordings'"
)
NANOSECONDS = 10**9  # in a second


class Topic(NamedTuple):
    """A topic as a recording knows it."""

    name: str
    type: str
    encoding: str = ''  # of the definition: 'ros2msg', 'ros2idl', or empty where there is none
    definition: str = ''


class Raw(NamedTuple):
    """A message as bytes."""

    time: int  # [ns] when it was recorded
    topic: Topic
    data: bytes


class Damage(NamedTuple):
    """What could not be read of a file, and until when [ns] it told something; 0: never."""

    file: str
    reason: str
    until: int


class Storage:
    """One file of a recording, or a folder whose files are compressed as a whole."""

    def __init__(self, path: Path) -> None:
        """Look which topics there are; raises RecordingError where nothing can be read."""
        self.path = path
        self.damage: list[Damage] = []
        self.topics: list[Topic] = []
        self.span: tuple[int, int] | None = None  # [ns] of the messages of all topics
        self._is_whole = True
        self._look()
        log = path.with_name(f'{path.name}-wal')
        if log.is_file() and log.stat().st_size:
            self._damaged(
                f'{log.name} beside it holds messages that are not read; move them into it by: '
                f"sqlite3 {path.name} 'PRAGMA wal_checkpoint'",
                0,
            )

    def messages(self, names: Collection[str]) -> Iterator[Raw]:
        """Yield the messages of some topics."""
        until = -1
        if self._is_whole:
            try:
                for raw in self._whole(names):
                    until = raw.time
                    yield raw
                return
            except GeneratorExit:
                raise
            except Exception as error:  # of rosbags, sqlite or any codec: nobody lists them
                self._damaged(_words(error), until)
            if self.path.is_dir():
                return
        for raw in self._rest(names, tells=True):
            # What was read before the damage is not read twice.
            if raw.time > until:
                yield raw

    def _look(self) -> None:
        try:
            from rosbags.rosbag2 import Reader
        except ImportError as error:
            raise RecordingError(f'{_LIBRARIES} ({error})') from None
        try:
            with Reader(self.path) as reader:
                self.topics = [_topic(each) for each in reader.connections]
                if reader.message_count:
                    self.span = reader.start_time, reader.end_time - 1
        except Exception as error:
            if self.path.is_dir():
                raise RecordingError(f'{self.path}: {_words(error)}') from None
            self._is_whole = False
            self._reason = _words(error)
            self._look_at_the_rest()
            if not self.topics:
                raise RecordingError(
                    f'{self.path}: nothing can be read of it: {self._reason}'
                ) from None

    def _look_at_the_rest(self) -> None:
        found: dict[Topic, None] = {}
        for raw in self._rest((), tells=False):
            found[raw.topic] = None
            first, last = self.span or (raw.time, raw.time)
            self.span = min(first, raw.time), max(last, raw.time)
        self.topics = list(found)

    def _whole(self, names: Collection[str]) -> Iterator[Raw]:
        from rosbags.rosbag2 import Reader

        with Reader(self.path) as reader:
            asked = [each for each in reader.connections if each.topic in names]
            topics = {(each.topic, each.id): _topic(each) for each in asked}
            if not asked:
                return
            for connection, time, data in reader.messages(asked):
                yield Raw(time, topics[connection.topic, connection.id], data)

    def _rest(self, names: Collection[str], *, tells: bool) -> Iterator[Raw]:
        """Yield what can be read of a damaged file, of all topics where none is named."""
        read = _rest_of_mcap if self.path.suffix == '.mcap' else _rest_of_sqlite
        until, reasons = 0, [] if self._is_whole else [self._reason]
        for raw in read(self.path, reasons):
            until = max(until, raw.time)
            if not names or raw.topic.name in names:
                yield raw
        if tells:
            for reason in reasons:
                self._damaged(reason, until)

    def _damaged(self, reason: str, until: int) -> None:
        self.damage.append(Damage(str(self.path), reason, max(until, 0)))


def _topic(connection: Any) -> Topic:
    """Return a topic of rosbags."""
    from rosbags.interfaces import MessageDefinitionFormat

    kind = {MessageDefinitionFormat.MSG: 'ros2msg', MessageDefinitionFormat.IDL: 'ros2idl'}
    encoding = kind.get(connection.msgdef.format, '')
    return Topic(connection.topic, connection.msgtype, encoding, connection.msgdef.data)


def _rest_of_mcap(path: Path, reasons: list[str]) -> Iterator[Raw]:
    """Yield the messages of the whole chunks, in the order of the file, sorted in each chunk."""
    from mcap.records import Channel, Chunk, Message, Schema
    from mcap.stream_reader import StreamReader, breakup_chunk

    topics: dict[int, Topic] = {}
    schemas: dict[int, Any] = {}

    def messages(records: list[Any]) -> Iterator[Raw]:
        found = []
        for record in records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                schema = schemas[record.schema_id]
                text = schema.data.decode()
                topics[record.id] = Topic(record.topic, schema.name, schema.encoding, text)
            elif isinstance(record, Message):
                found.append(Raw(record.log_time, topics[record.channel_id], record.data))
        yield from sorted(found, key=lambda raw: raw.time)

    with path.open('rb') as file:
        limit = path.stat().st_size
        try:
            reader = StreamReader(file, emit_chunks=True, record_size_limit=limit)
            for record in reader.records:
                if not isinstance(record, Chunk):
                    yield from messages([record])
                    continue
                try:
                    records = breakup_chunk(record, validate_crc=True)
                except Exception as error:
                    first, last = record.message_start_time, record.message_end_time
                    reasons.append(
                        f'a chunk is damaged and left out, from {first} to {last} ns: '
                        f'{_words(error)}'
                    )
                    continue
                yield from messages(records)
        except GeneratorExit:
            raise
        except Exception as error:
            reasons.append(f'it breaks off: {_words(error)}')


def _rest_of_sqlite(path: Path, reasons: list[str]) -> Iterator[Raw]:
    """Yield the messages in the order in which they were written, up to the damage."""
    place = f'{path.absolute().as_uri()}?mode=ro&immutable=1'
    try:
        with closing(sqlite3.connect(place, uri=True)) as database:
            # Else a file that is shorter than its header says is refused as a whole.
            database.execute('PRAGMA writable_schema=ON')
            topics = {
                number: Topic(name, kind)
                for number, name, kind in database.execute('SELECT id, name, type FROM topics')
            }
            defined = _definitions(database)
            topics = {
                number: topic._replace(
                    **dict(zip(('encoding', 'definition'), defined[topic.type], strict=True))
                )
                if topic.type in defined
                else topic
                for number, topic in topics.items()
            }
            asked = 'SELECT topic_id, timestamp, data FROM messages ORDER BY id'
            for number, time, data in database.execute(asked):
                yield Raw(time, topics[number], data)
    except sqlite3.Error as error:
        reasons.append(f'it breaks off: {_words(error)}')


def _definitions(database: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Return encoding and text of message types, which recordings have since ROS 2 Iron."""
    asked = 'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions'
    try:
        return {kind: (encoding, text) for kind, encoding, text in database.execute(asked)}
    except sqlite3.Error:
        return {}


def _words(error: BaseException) -> str:
    return ' '.join(str(error).split()) or type(error).__name__
