"""Recovery of messages from damaged storage files: chunks of MCAP files, rows of databases."""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Iterable, Iterator
from contextlib import closing, suppress
from io import BytesIO
from pathlib import Path
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.recordings.raw_messages import Lost, Raw, RecordedTopic
from drake_geom_ros.recordings.schemas import DEFINED

_RECORD = struct.Struct('<BQ')  # head of each record of an MCAP: kind, length
_CHUNK = struct.Struct('<QQQII')  # times, size and checksum, length of the compression's name
_IS_CHUNK = 6


def rest_of(path: Path, lost: list[Lost]) -> Iterator[Raw]:
    """Yield the readable messages of a damaged file, and append the losses to ``lost``."""
    yield from (_of_mcap if path.suffix == '.mcap' else _of_sqlite)(path, lost)


def words_of(error: BaseException) -> str:
    """Return an error in one line, with its type if its text is only a name or empty."""
    words = ' '.join(str(error).split())
    kind = type(error).__name__
    return f'{kind} {words}'.strip() if isinstance(error, KeyError) else words or kind


def _of_mcap(path: Path, lost: list[Lost]) -> Iterator[Raw]:
    """Yield the messages of intact chunks in the order of the file, sorted in each chunk.

    Then yield those at the beginning of a truncated chunk.
    """
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader, breakup_chunk

    reader, at = _Records(), 0
    with path.open('rb') as file:
        try:
            limit = path.stat().st_size
            for record in StreamReader(file, emit_chunks=True, record_size_limit=limit).records:
                at = file.tell()
                if not isinstance(record, Chunk):
                    yield from reader.messages([record])
                    continue
                try:
                    messages = reader.messages(breakup_chunk(record, validate_crc=True))
                except Exception as error:
                    span = record.message_start_time, record.message_end_time
                    lost.append(Lost(f'a chunk is damaged and left out: {words_of(error)}', span))
                    continue
                yield from messages
        except GeneratorExit:
            raise
        except Exception as error:
            lost.append(Lost(f'it breaks off: {words_of(error)}'))
            yield from reader.messages_known(_begun_chunk(path, at))


class _Records:
    """Decoder of the records of an MCAP in their order."""

    def __init__(self) -> None:
        self._topics: dict[int, RecordedTopic] = {}
        self._schemas: dict[int, Any] = {}

    def messages(self, records: Iterable[Any]) -> list[Raw]:
        """Return the messages among records by time; damage raises any kind of exception."""
        from mcap.records import Channel, Message, Schema

        messages = []
        for record in records:
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._topics[record.id] = self._topic(record)
            elif isinstance(record, Message):
                messages.append(Raw(record.log_time, self._topics[record.channel_id], record.data))
        return sorted(messages, key=lambda raw: raw.time)

    def _topic(self, channel: Any) -> RecordedTopic:
        """Return the topic of a channel, whose schema 0 is none."""
        if not channel.schema_id:
            return RecordedTopic(channel.topic, '')
        schema = self._schemas[channel.schema_id]
        text = schema.data.decode() if schema.encoding in DEFINED else ''
        return RecordedTopic(channel.topic, schema.name, schema.encoding, text)

    def messages_known(self, records: Iterable[Any]) -> list[Raw]:
        """Return the messages whose topics are known, since records of topics may be damaged."""
        messages = []
        for record in records:
            with suppress(Exception):
                messages += self.messages([record])
        return sorted(messages, key=lambda raw: raw.time)


def _begun_chunk(path: Path, at: int) -> list[Any]:
    """Return the complete records at the beginning of a truncated chunk.

    They have no checksum that could be verified. The layout is that of https://mcap.dev/spec:
    kind and length of a record, then times, size, checksum, compression and data length of a
    chunk.
    """
    from mcap.stream_reader import StreamReader

    with path.open('rb') as file:
        file.seek(at)
        data = file.read()
    intact: list[Any] = []
    try:
        kind, length = _RECORD.unpack_from(data)
        if kind != _IS_CHUNK or length <= len(data) - _RECORD.size:
            return []
        *_, named = _CHUNK.unpack_from(data, _RECORD.size)
        begin = _RECORD.size + _CHUNK.size
        compression = data[begin : begin + named].decode()
        records = _decompressed(data[begin + named + 8 :], compression)
        for record in StreamReader(BytesIO(records), skip_magic=True, emit_chunks=True).records:
            intact.append(record)
    except Exception:  # at the cut; earlier records are complete
        return intact
    return intact


def _decompressed(data: bytes, compression: str) -> bytes:
    """Return the decompressed beginning of truncated data."""
    if compression == 'lz4':
        from lz4.frame import LZ4FrameDecompressor

        return bytes(LZ4FrameDecompressor().decompress(data))
    if compression == 'zstd':
        from zstandard import ZstdDecompressor

        return bytes(ZstdDecompressor().decompressobj().decompress(data))
    return data


def rows_by_time(path: Path, lost: list[Lost]) -> Iterator[Raw]:
    """Yield the messages of an intact database in the order of their times."""
    return _of_sqlite(path, lost, order='timestamp, id')


def _of_sqlite(path: Path, lost: list[Lost], order: str = 'id') -> Iterator[Raw]:
    """Yield the messages in the order in which they were written, up to the damage."""
    unnamed = 0
    try:
        with closing(sqlite3.connect(_place(path), uri=True)) as database:
            # Without this SQLite refuses a file that is shorter than its header says.
            database.execute('PRAGMA writable_schema=ON')
            if strange := strange_part_of(database):
                raise sqlite3.DatabaseError(strange)
            topics = _topics(database)
            select = f'SELECT topic_id, timestamp, data FROM messages ORDER BY {order}'
            for number, time, data in database.execute(select):
                if number in topics and isinstance(time, int) and isinstance(data, bytes):
                    yield Raw(time, topics[number], data)
                else:
                    unnamed += 1
    except (sqlite3.Error, UnicodeDecodeError) as error:
        lost.append(Lost(f'it breaks off: {words_of(error)}'))
    if unnamed:
        lost.append(Lost(f'{unnamed} of its messages have no topic, time or data'))


def strange_part_of(database: sqlite3.Connection) -> str:
    """Return a remark about a part of a database that no recorder writes; empty for none.

    A view may be endless, and a virtual table or a computed column may run anything.
    """
    select = (
        "SELECT type, name, sql FROM sqlite_master WHERE name NOT LIKE 'sqlite\\_%' ESCAPE '\\'"
    )
    for kind, name, text in database.execute(select):
        words = str(text).upper().split()[:2]
        if kind not in ('table', 'index') or words == ['CREATE', 'VIRTUAL']:
            return f'it holds the {kind} {name!r}, which no recorder writes'
        if kind == 'table':
            quoted = str(name).replace('"', '""')
            for _, column, *_, hidden in database.execute(f'PRAGMA table_xinfo("{quoted}")'):
                if hidden:
                    return f'its column {column!r} of {name!r} is computed, as no recorder has it'
    return ''


def check_database(path: Path) -> None:
    """Raise sqlite3.Error for an invalid database, or one with parts that no recorder writes."""
    with closing(sqlite3.connect(_place(path), uri=True)) as database:
        if strange := strange_part_of(database):
            raise sqlite3.DatabaseError(strange)


def hidden_fault_of(path: Path) -> str:
    """Return the fault of a database that reads without an error; empty for none.

    A damaged page may hide rows without an error, so SQLite's own check compares rows and
    indices. There are no checksums, so changed numbers remain undetected.
    """
    strays = 'SELECT count(*) FROM messages LEFT JOIN topics ON topics.id = topic_id'
    try:
        with closing(sqlite3.connect(_place(path), uri=True)) as database:
            ((verdict,),) = database.execute('PRAGMA integrity_check(1)')
            ((count,),) = database.execute(f'{strays} WHERE topics.id IS NULL')
    except sqlite3.Error as error:
        return words_of(error)
    if verdict != 'ok':
        return f'it is damaged: {words_of(ValueError(verdict))}'
    return f'{counted(count, "message")} of it have no topic' if count else ''


def _place(path: Path) -> str:
    return f'{path.absolute().as_uri()}?mode=ro&immutable=1'


def _topics(database: sqlite3.Connection) -> dict[Any, RecordedTopic]:
    """Return the topics of a database by their numbers."""
    defined = _definitions(database)
    return {
        number: RecordedTopic(name, kind, *defined.get(kind, ()))
        for number, name, kind in database.execute('SELECT id, name, type FROM topics')
        if isinstance(name, str) and isinstance(kind, str)
    }


def _definitions(database: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Return encoding and text of message types, which recordings have since ROS 2 Iron."""
    select = 'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions'
    try:
        return {kind: (encoding, text) for kind, encoding, text in database.execute(select)}
    except sqlite3.Error:
        return {}
