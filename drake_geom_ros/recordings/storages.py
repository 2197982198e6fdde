"""Storage files, message by message as bytes: whole ones by rosbags, of damaged ones what is left.

A whole file is read in the order of its times. What is wrong with a damaged one is kept as
``Damage``, with the time until which it told something.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.raw_messages import Damage, Lost, Raw, Topic
from drake_geom_ros.recordings.salvage import hidden_fault_of, rest_of, words_of

_LIBRARIES = (
    'recordings are read by rosbags and mcap: pip install rosbags mcap, or this package with its '
    "extra 'recordings'"
)


class Storage:
    """One file of a recording, or a folder whose files are compressed as a whole."""

    def __init__(self, path: Path) -> None:
        """Look which topics there are; raises RecordingError where nothing can be read."""
        self.path = path
        self.damage: list[Damage] = []
        self.topics: list[Topic] = []
        self.span: tuple[int, int] | None = None  # [ns] of the messages of all topics
        self._is_whole, self._reason = True, ''
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
                self._reason = words_of(error)
            if self.path.is_dir():
                self._damaged(self._reason, until)
                return
        for raw in self._rest(names):
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
                raise RecordingError(f'{self.path}: {words_of(error)}') from None
            self._is_whole = False
            self._reason = words_of(error)
            self._look_at_the_rest()
            if not self.topics:
                raise RecordingError(
                    f'{self.path}: nothing can be read of it: {self._reason}'
                ) from None

    def _look_at_the_rest(self) -> None:
        found: dict[Topic, None] = {}
        for raw in rest_of(self.path, []):
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
            left = sum(each.msgcount for each in asked)
            for connection, time, data in reader.messages(asked):
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
        """Yield what can be read of a damaged file of some topics, and note what cannot."""
        lost: list[Lost] = []
        until = 0
        for raw in rest_of(self.path, lost):
            until = max(until, raw.time)
            if raw.topic.name in names:
                yield raw
        for each in lost or [Lost(self._reason)]:
            self._note(each, until)

    def _damaged(self, reason: str, until: int) -> None:
        self._note(Lost(reason), until)

    def _note(self, lost: Lost, until: int) -> None:
        self.damage.append(Damage(str(self.path), lost, max(until, 0)))


def _topic(connection: Any) -> Topic:
    """Return a topic of rosbags."""
    from rosbags.interfaces import MessageDefinitionFormat

    kind = {MessageDefinitionFormat.MSG: 'ros2msg', MessageDefinitionFormat.IDL: 'ros2idl'}
    encoding = kind.get(connection.msgdef.format, '')
    return Topic(connection.topic, connection.msgtype, encoding, connection.msgdef.data)
