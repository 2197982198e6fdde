"""Storage files as streams of raw messages: intact ones by rosbags, damaged ones by salvage.

An intact file is read in the order of its times. Damage of a file is recorded as ``Damage``, with
the time of the last readable message.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.raw_messages import Damage, Lost, Raw, RecordedTopic
from drake_geom_ros.recordings.salvage import (
    check_database,
    hidden_fault_of,
    rest_of,
    rows_by_time,
    words_of,
)
from drake_geom_ros.recordings.schemas import DEFINED, open_reader

_LIBRARIES = (
    'recordings are read by rosbags and mcap: pip install rosbags mcap, or this package with its '
    "extra 'recordings'"
)


_LAST = 2**63 - 1  # [ns] the last time that ROS can represent, in the year 2262


class Storage:
    """One file of a recording, or a folder whose files are compressed as a whole."""

    def __init__(self, path: Path) -> None:
        """Read the topics and the time span; raises RecordingError if nothing can be read."""
        self.path = path
        self.damage: list[Damage] = []
        self.topics: list[RecordedTopic] = []
        self.span: tuple[int, int] | None = None  # [ns] of the messages of all topics
        self._is_whole, self._is_foreign, self._reason = True, False, ''
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
            except Exception as error:  # of rosbags, sqlite or any codec, without a common type
                self._reason = words_of(error)
            if self.path.is_dir():
                self._damaged(self._reason, until)
                return
        for raw in self._rest(names):
            # Messages before the damage were yielded already.
            if raw.time > until:
                yield raw

    def _look(self) -> None:
        try:
            import rosbags.rosbag2  # noqa: F401
        except ImportError as error:
            raise RecordingError(f'{_LIBRARIES} ({error})') from None
        try:
            if self.path.suffix == '.db3':
                check_database(self.path)
            with open_reader(self.path) as reader:
                self.topics = [_topic(each) for each in reader.connections]
                if reader.message_count:
                    self.span = reader.start_time, reader.end_time - 1
                    _check_time(self.span[1])
        except Exception as error:
            if self.path.is_dir():
                raise RecordingError(f'{self.path}: {words_of(error)}') from None
            # rosbags refuses definitions of other encodings, possibly of unused topics.
            self._is_foreign = _is_foreign(self.path, error)
            self._is_whole, self.span = False, None
            self._reason = words_of(error)
            self._look_at_the_rest()
            if not self.topics:
                raise RecordingError(
                    f'{self.path}: nothing can be read of it: {self._reason}'
                ) from None

    def _look_at_the_rest(self) -> None:
        topics: dict[RecordedTopic, None] = {}
        for raw in rest_of(self.path, []):
            if raw.time > _LAST:
                continue
            topics[raw.topic] = None
            first, last = self.span or (raw.time, raw.time)
            self.span = min(first, raw.time), max(last, raw.time)
        self.topics = list(topics)

    def _whole(self, names: Collection[str]) -> Iterator[Raw]:
        with open_reader(self.path) as reader:
            connections = [each for each in reader.connections if each.topic in names]
            topics = {(each.topic, each.id): _topic(each) for each in connections}
            if not connections:
                return
            left = sum(each.msgcount for each in connections)
            for connection, time, data in reader.messages(connections):
                left -= 1
                yield Raw(time, topics[connection.topic, connection.id], data)
        if left > 0:
            fault = f'{counted(left, "message")} that its index tells of cannot be found'
            raise RecordingError(fault)
        if self.path.suffix == '.db3' and self._hidden_fault:
            raise RecordingError(self._hidden_fault)

    @cached_property
    def _hidden_fault(self) -> str:
        return hidden_fault_of(self.path)

    def _rest(self, names: Collection[str]) -> Iterator[Raw]:
        """Yield the readable messages of some topics in a damaged file, and note its damage."""
        lost: list[Lost] = []
        until = beyond = 0
        rows = rows_by_time if self._is_foreign else rest_of
        for raw in rows(self.path, lost):
            if raw.time > _LAST:
                beyond += 1
                continue
            until = max(until, raw.time)
            if raw.topic.name in names:
                yield raw
        if beyond:
            lost.append(Lost(f'{counted(beyond, "message")} of times behind the year 2262'))
        if self._is_foreign and self._hidden_fault:
            lost.append(Lost(self._hidden_fault))
        for each in lost or ([] if self._is_foreign else [Lost(self._reason)]):
            self._note(each, until)

    def _damaged(self, reason: str, until: int) -> None:
        self._note(Lost(reason), until)

    def _note(self, lost: Lost, until: int) -> None:
        self.damage.append(Damage(str(self.path), lost, max(until, 0)))


def _is_foreign(path: Path, error: Exception) -> bool:
    """Return whether a database is refused only for the encoding of a definition."""
    key = error.args[0] if isinstance(error, KeyError) and error.args else None
    return path.suffix == '.db3' and isinstance(key, str) and key not in DEFINED


def _check_time(last: int) -> None:
    """Raise RecordingError if the time [ns] of the last message is beyond that of ROS."""
    if last > _LAST:
        raise RecordingError(f'a message was recorded at {last} ns, behind the year 2262')


def _topic(connection: Any) -> RecordedTopic:
    """Return the topic of a rosbags connection."""
    from rosbags.interfaces import MessageDefinitionFormat

    kind = {MessageDefinitionFormat.MSG: 'ros2msg', MessageDefinitionFormat.IDL: 'ros2idl'}
    encoding, text = kind.get(connection.msgdef.format, ''), connection.msgdef.data
    if not encoding:  # the text is the name of another encoding
        encoding, text = text, ''
    return RecordedTopic(connection.topic, connection.msgtype, encoding, text)
