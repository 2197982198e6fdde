"""What storages hold: topics, messages as bytes, and what of them could not be read."""

from __future__ import annotations

from typing import NamedTuple

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


class Lost(NamedTuple):
    """Why something is lost, and from when to when [ns]; None: that is not known."""

    reason: str
    span: tuple[int, int] | None = None


class Damage(NamedTuple):
    """What could not be read of a file, and until when [ns] it told something; 0: never."""

    file: str
    lost: Lost
    until: int

    def in_words(self, begin: int) -> str:
        """Return it in words, times by the beginning [ns] of the recording."""
        reason, span = self.lost
        where = ''
        if span is not None:
            first, last = ((time - begin) / NANOSECONDS for time in span)
            where = f', from {first:.3f} to {last:.3f} s'
        told = 'it told nothing'
        if self.until >= max(begin, 1):
            told = f'it told something until {(self.until - begin) / NANOSECONDS:.3f} s'
        return f'{self.file}: {reason}{where}; {told}'
