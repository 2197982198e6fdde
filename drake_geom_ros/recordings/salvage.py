"""What is left in damaged storage files: of an MCAP each chunk, of a database row by row."""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Iterable, Iterator
from contextlib import closing, suppress
from io import BytesIO
from pathlib import Path
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.recordings.raw_messages import Lost, Raw, Topic
from drake_geom_ros.recordings.schemas import DEFINED

_RECORD = struct.Struct('<BQ')  # how each record of an MCAP begins: kind, length
_CHUNK = struct.Struct('<QQQII')  # times, size and checksum, length of the compression's name
_IS_CHUNK = 6


def rest_of(path: Path, lost: list[Lost]) -> Iterator[Raw]:
    """Yield the messages that can be read of a damaged file, and append what cannot."""
    yield from (_of_mcap if path.suffix == '.mcap' else _of_sqlite)(path, lost)


def words_of(error: BaseException) -> str:
    """Return an error in one line; its kind where it is a mere name or nothing."""
    words = ' '.join(str(error).split())
    kind = type(error).__name__
    return f'{kind} {words}'.strip() if isinstance(error, KeyError) else words or kind


def _of_mcap(path: Path, lost: list[Lost]) -> Iterator[Raw]:
    """Yield the messages of the whole chunks in the order of the file, sorted in each chunk.

    And those at the beginning of a chunk in which the file breaks off.
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
                    found = reader.messages(breakup_chunk(record, validate_crc=True))
                except Exception as error:
                    span = record.message_start_time, record.message_end_time
                    lost.append(Lost(f'a chunk is damaged and left out: {words_of(error)}', span))
                    continue
                yield from found
        except GeneratorExit:
            raise
        except Exception as error:
            lost.append(Lost(f'it breaks off: {words_of(error)}'))
            yield from reader.messages_known(_begun_chunk(path, at))


class _Records:
    """Takes the records of an MCAP in their order, and returns its messages."""

    def __init__(self) -> None:
        self._topics: dict[int, Topic] = {}
        self._schemas: dict[int, Any] = {}

    def messages(self, records: Iterable[Any]) -> list[Raw]:
        """Return those among some records by their times; raises whatever damage makes of it."""
        from mcap.records import Channel, Message, Schema

        found = []
        for record in records:
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._topics[record.id] = self._topic(record)
            elif isinstance(record, Message):
                found.append(Raw(record.log_time, self._topics[record.channel_id], record.data))
        return sorted(found, key=lambda raw: raw.time)

    def _topic(self, channel: Any) -> Topic:
        """Return the topic of a channel; 0 is the number of no schema."""
        if not channel.schema_id:
            return Topic(channel.topic, '')
        schema = self._schemas[channel.schema_id]
        text = schema.data.decode() if schema.encoding in DEFINED else ''
        return Topic(channel.topic, schema.name, schema.encoding, text)

    def messages_known(self, records: Iterable[Any]) -> list[Raw]:
        """Return those whose topics are known: what tells of these may be damaged."""
        found = []
        for record in records:
            with suppress(Exception):
                found += self.messages([record])
        return sorted(found, key=lambda raw: raw.time)


def _begun_chunk(path: Path, at: int) -> list[Any]:
    """Return the whole records at the beginning of a chunk whose end the file has not.

    Nothing of it bears a checksum that could be checked: what is not cut is as it was written.
    The layout is that of https://mcap.dev/spec: kind and length of a record, then of a chunk its
    times, size, checksum, compression and the length of its data.
    """
    from mcap.stream_reader import StreamReader

    with path.open('rb') as file:
        file.seek(at)
        data = file.read()
    found: list[Any] = []
    try:
        kind, length = _RECORD.unpack_from(data)
        if kind != _IS_CHUNK or length <= len(data) - _RECORD.size:
            return []
        *_, named = _CHUNK.unpack_from(data, _RECORD.size)
        begin = _RECORD.size + _CHUNK.size
        compression = data[begin : begin + named].decode()
        records = _decompressed(data[begin + named + 8 :], compression)
        for record in StreamReader(BytesIO(records), skip_magic=True, emit_chunks=True).records:
            found.append(record)
    except Exception:  # at the cut: what came before is whole
        return found
    return found


def _decompressed(data: bytes, compression: str) -> bytes:
    """Return what the beginning of compressed data tells."""
    if compression == 'lz4':
        from lz4.frame import LZ4FrameDecompressor

        return bytes(LZ4FrameDecompressor().decompress(data))
    if compression == 'zstd':
        from zstandard import ZstdDecompressor

        return bytes(ZstdDecompressor().decompressobj().decompress(data))
    return data


def rows_by_time(path: Path, lost: list[Lost]) -> Iterator[Raw]:
    """Yield the messages of a whole database in the order of their times."""
    return _of_sqlite(path, lost, order='timestamp, id')


def _of_sqlite(path: Path, lost: list[Lost], order: str = 'id') -> Iterator[Raw]:
    """Yield the messages in the order in which they were written, up to the damage."""
    unnamed = 0
    try:
        with closing(sqlite3.connect(_place(path), uri=True)) as database:
            # Else a file that is shorter than its header says is refused as a whole.
            database.execute('PRAGMA writable_schema=ON')
            if strange := strange_part_of(database):
                raise sqlite3.DatabaseError(strange)
            topics = _topics(database)
            asked = f'SELECT topic_id, timestamp, data FROM messages ORDER BY {order}'
            for number, time, data in database.execute(asked):
                if number in topics and isinstance(time, int) and isinstance(data, bytes):
                    yield Raw(time, topics[number], data)
                else:
                    unnamed += 1
    except (sqlite3.Error, UnicodeDecodeError) as error:
        lost.append(Lost(f'it breaks off: {words_of(error)}'))
    if unnamed:
        lost.append(Lost(f'{unnamed} of its messages have no topic, time or data'))


def strange_part_of(database: sqlite3.Connection) -> str:
    """Return what a database holds that no recorder writes; empty for nothing.

    A view may go on for ever, and a virtual table or a computed column do anything.
    """
    asked = (
        "SELECT type, name, sql FROM sqlite_master WHERE name NOT LIKE 'sqlite\\_%' ESCAPE '\\'"
    )
    for kind, name, text in database.execute(asked):
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
    """Raise sqlite3.Error for a database that is none, or is not as recorders write it."""
    with closing(sqlite3.connect(_place(path), uri=True)) as database:
        if strange := strange_part_of(database):
            raise sqlite3.DatabaseError(strange)


def hidden_fault_of(path: Path) -> str:
    """Return what is wrong with a database that can be read to its end; empty for nothing.

    A harmed page may hide rows without an error: SQLite's own check holds rows and indices against
    each other. It bears no checksums: numbers that are others than were written are not seen.
    """
    strays = 'SELECT count(*) FROM messages LEFT JOIN topics ON topics.id = topic_id'
    try:
        with closing(sqlite3.connect(_place(path), uri=True)) as database:
            ((told,),) = database.execute('PRAGMA integrity_check(1)')
            ((count,),) = database.execute(f'{strays} WHERE topics.id IS NULL')
    except sqlite3.Error as error:
        return words_of(error)
    if told != 'ok':
        return f'it is damaged: {words_of(ValueError(told))}'
    return f'{counted(count, "message")} of it have no topic' if count else ''


def _place(path: Path) -> str:
    return f'{path.absolute().as_uri()}?mode=ro&immutable=1'


def _topics(database: sqlite3.Connection) -> dict[Any, Topic]:
    """Return the topics of a database by their numbers."""
    defined = _definitions(database)
    return {
        number: Topic(name, kind, *defined.get(kind, ()))
        for number, name, kind in database.execute('SELECT id, name, type FROM topics')
        if isinstance(name, str) and isinstance(kind, str)
    }


def _definitions(database: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Return encoding and text of message types, which recordings have since ROS 2 Iron."""
    asked = 'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions'
    try:
        return {kind: (encoding, text) for kind, encoding, text in database.execute(asked)}
    except sqlite3.Error:
        return {}
