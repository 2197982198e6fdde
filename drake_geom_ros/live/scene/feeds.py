"""Publishers that feed one input, each with the time of its last message.

A driver that is started anew has another publisher for the same frame. It takes the place of the
one before, once that has said nothing for some messages.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Generic, NamedTuple, TypeVar

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.scene.clocks import Clocks, Since

MOST_FEEDS = 16  # of an input
_REPLACED_AFTER = 3  # messages of a new publisher of a frame, and none of the one before
_Shown = TypeVar('_Shown')
_Feeds = TypeVar('_Feeds', bound='Feeds[Any]')


class Feed(NamedTuple):
    """A sensor that feeds an input: its publisher and frame."""

    frame: str
    publisher: str  # by what the middleware calls it; empty: it tells nothing

    def in_words(self) -> str:
        """Return it in words."""
        return f'frame {self.frame!r}, publisher {self.publisher or "unknown"}'


@dataclass
class Fed(Generic[_Shown]):
    """The last message of a sensor, and its messages since others of its frame fell silent.

    Those were there before it, and said nothing since it came.
    """

    shown: _Shown
    since: Since
    silent: dict[Feed, int] = field(default_factory=dict)


class Feeds(Generic[_Shown]):
    """The last messages of the sensors that feed one input."""

    what, cleared_by = 'the input', 'it is cleared'

    def __init__(self, clocks: Clocks) -> None:
        self._clocks = clocks
        self._fed: dict[Feed, Fed[_Shown]] = {}

    def __len__(self) -> int:
        return len(self._fed)

    def since(self, feed: Feed) -> Since | None:
        """Return since when a sensor's last message holds; None: there was none."""
        record = self._fed.get(feed)
        return None if record is None else record.since

    def with_message(self: _Feeds, feed: Feed, shown: Any, since: Since) -> _Feeds:
        """Return these with what a sensor shows now; these stay as they are.

        Raises ArgumentError where there would be too many.
        """
        before = self._fed.get(feed)
        silent = {old: count + 1 for old, count in before.silent.items()} if before else {}
        if before is None:
            silent = dict.fromkeys((old for old in self._fed if old.frame == feed.frame), 1)
        gone = {old for old, count in silent.items() if count >= _REPLACED_AFTER}
        fed = {
            each: replace(record, silent=_without(record.silent, {feed, *gone}))
            if record.silent
            else record
            for each, record in self._fed.items()
            if each not in gone
        }
        fed[feed] = Fed(shown, since, _without(silent, silent.keys() - fed.keys()))
        if len(fed) > MOST_FEEDS:
            raise ArgumentError(
                f'it is of {feed.in_words()}, and {MOST_FEEDS} others feed {self.what}; no more '
                f'are taken until {self.cleared_by}'
            )
        other = type(self)(self._clocks)
        other._fed = fed
        return other

    def sinces(self) -> Iterator[tuple[Feed, Since]]:
        """Yield each sensor, and since when what it showed last holds."""
        for feed, record in self._fed.items():
            yield feed, record.since

    def ages(self) -> Iterator[tuple[Feed, float]]:
        """Yield each sensor and the age [s] of what it showed last."""
        age = self._clocks.ages()
        for feed, since in self.sinces():
            yield feed, age(since)


def _without(silent: dict[Feed, int], gone: Collection[Feed]) -> dict[Feed, int]:
    return {feed: count for feed, count in silent.items() if feed not in gone}
