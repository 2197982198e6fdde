"""The values of one thing in the last seconds, each with the time at which it held.

Between two that came the caller goes from one to the other; beyond the last one, and across a
long gap, nobody knows.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import deque
from dataclasses import dataclass
from typing import Generic, TypeVar

from drake_geom_ros.live.scene.clocks import ALWAYS, Since

KEPT = 3.0  # [s] by the node's time
LONGEST_GAP = 0.5  # [s] between two, across which one is told
_MOST = 30_000  # of a track: what comes faster is kept for less long

T = TypeVar('T')


class UnknownThenError(Exception):
    """The value of a time is unknown: not yet received (``is_later``), or never."""

    def __init__(self, *, is_later: bool) -> None:
        super().__init__()
        self.is_later = is_later


@dataclass(frozen=True)
class Timed(Generic[T]):
    """A value and the time [s] at which it held."""

    held: float
    value: T


@dataclass(frozen=True)
class Bracket(Generic[T]):
    """The nearest that came at or before a time [s], and after it."""

    time: float
    before: Timed[T] | None
    after: Timed[T] | None

    def joined(self, other: Bracket[T]) -> Bracket[T]:
        """Return the nearest of two tracks of the same thing."""
        before = [each for each in (self.before, other.before) if each is not None]
        after = [each for each in (self.after, other.after) if each is not None]
        return Bracket(
            self.time,
            max(before, key=lambda each: each.held, default=None),
            min(after, key=lambda each: each.held, default=None),
        )

    def between(self) -> tuple[T, T, float]:
        """Return two values, and how far from the first one to the second the time is, 0 to 1.

        Raises UnknownThenError where nothing is known of the time.
        """
        first, last = self.before, self.after
        if first is not None and first.held == self.time:
            return first.value, first.value, 0.0
        if first is None or last is None or last.held - first.held > LONGEST_GAP:
            raise UnknownThenError(is_later=first is not None and last is None)
        return first.value, last.value, (self.time - first.held) / (last.held - first.held)


class Track(Generic[T]):
    """Keeps what came for one thing, in the order of its times."""

    def __init__(self) -> None:
        self._entries: deque[Timed[T]] = deque()
        self._epoch = float('-inf')

    @property
    def newest(self) -> float:
        """The time [s] of what held last; -inf: nothing came."""
        return self._entries[-1].held if self._entries else float('-inf')

    def note(self, value: T, since: Since) -> None:
        """Keep what holds ``since`` then; what holds for good is not kept."""
        if since == ALWAYS or since.epoch < self._epoch:
            return
        entries = self._entries
        if since.epoch != self._epoch:
            entries.clear()  # the node's time jumped: what was is of another time
            self._epoch = since.epoch
        timed = Timed(since.held, value)
        if since.held > self.newest:
            entries.append(timed)
        else:
            k = bisect_left(entries, since.held, key=_time_of)
            if entries[k].held == since.held:
                entries[k] = timed  # it was said again, and who comes last counts
            else:
                entries.insert(k, timed)
        while len(entries) > _MOST or entries[0].held < entries[-1].held - KEPT:
            entries.popleft()

    def around(self, time: float) -> Bracket[T]:
        """Return what came nearest to a time [s]."""
        entries = self._entries
        k = bisect_right(entries, time, key=_time_of)
        before = entries[k - 1] if k else None
        return Bracket(time, before, entries[k] if k < len(entries) else None)


def _time_of(entry: Timed[T]) -> float:
    return entry.held
