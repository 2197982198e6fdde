"""Topics, messages as bytes, and damage of storages."""

from __future__ import annotations

from typing import NamedTuple

NANOSECONDS = 10**9  # in a second


class RecordedTopic(NamedTuple):
    """A topic of a recording, with the definition of its type."""

    name: str
    type: str
    encoding: str = ''  # of the definition: 'ros2msg', 'ros2idl', or empty without one
    definition: str = ''


class Raw(NamedTuple):
    """A message as bytes."""

    time: int  # [ns] when it was recorded
    topic: RecordedTopic
    data: bytes


class Lost(NamedTuple):
    """The reason of a loss, and its time span [ns], None if unknown."""

    reason: str
    span: tuple[int, int] | None = None


class Damage(NamedTuple):
    """A loss in a file, and the time ``until`` [ns] of its last readable message, 0: none."""

    file: str
    lost: Lost
    until: int

    def in_words(self, begin: int) -> str:
        """Return a text about the damage, with times since the beginning [ns] of the recording."""
        reason, span = self.lost
        where = ''
        if span is not None:
            first, last = ((time - begin) / NANOSECONDS for time in span)
            where = f', from {first:.3f} to {last:.3f} s'
        rest = 'it told nothing'
        if self.until >= max(begin, 1):
            rest = f'it told something until {(self.until - begin) / NANOSECONDS:.3f} s'
        return f'{self.file}: {reason}{where}; {rest}'
