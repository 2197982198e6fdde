"""What a report tells of a set of pairs, gathered part by part: memory does not grow with time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.recordings.results import States, Told
from drake_geom_ros.recordings.set_clearance import Moment, SetClearance, Span, joined

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
MOST_CONTACTS = 100  # that are told
AGES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # [s] up to which states are counted
_BINS = 3000  # of time: of those with several states the nearest one is drawn


class Contact(NamedTuple):
    """States in a row in which the least distance is not certified to be above 0."""

    begin: float  # [s]
    end: float  # [s]
    states: int
    deepest: Moment


class Below(NamedTuple):
    """For how long a distance was not certified to be above a threshold."""

    threshold: float  # [m]
    seconds: float  # of states that tell of all pairs
    at_known: float  # [s] of others, by the pairs and poses that are known


class Held(NamedTuple):
    """How long the states of a set of pairs hold: until the next, at most for so long [s]."""

    whole: float
    stale: float
    waiting: float
    silent: float  # without a state that is new enough


class Ages(NamedTuple):
    """How old the oldest pose that mattered was, over states."""

    oldest: float  # [s] of those that are known; nan: none is
    counts: tuple[int, ...]  # of states up to each of ``AGES`` and above the one before; and above
    unknown: int  # states


@dataclass(frozen=True, eq=False)
class Highlights:
    """What a report tells of a set of pairs."""

    held: Held
    below: tuple[Below, ...]  # by threshold
    contacts: tuple[Contact, ...]  # the first of ``contact_count``, by what is known
    contact_count: int
    ages: Ages
    lost: tuple[Span, ...]  # times whose states do not tell all, or between two such
    shown: SetClearance  # of each of many short spans of time the nearest state


def highlights(found: Told, thresholds: Sequence[float]) -> dict[str, Highlights]:
    """Return what is told of each set of pairs, with the time below thresholds [m]."""
    gathered = {name: _Gathered(found, thresholds) for name in found.moments}
    for part, ends in _with_ends(found):
        for name, pairs in part.sets.items():
            gathered[name].take(pairs, ends)
    return {name: each.result() for name, each in gathered.items()}


def _with_ends(found: Told) -> Iterator[tuple[States, Floats]]:
    """Yield the states of a recording, and when [s] the one behind each is, or the end."""
    before = None
    for part in found.parts():
        if before is not None:
            yield before, np.append(before.times[1:], part.times[0])
        before = part
    if before is not None:
        yield before, np.append(before.times[1:], found.duration)


class _Gathered:
    """The highlights of a set of pairs, of the states that were taken."""

    def __init__(self, found: Told, thresholds: Sequence[float]) -> None:
        self._longest, self._duration = found.stale_after, found.duration
        self._held = np.zeros(3)
        self._thresholds = np.array(thresholds, dtype=np.float64)
        self._below = np.zeros((2, len(thresholds)))
        self._contacts = _Contacts()
        self._ages = np.zeros(len(AGES) + 1, dtype=np.int64)
        self._oldest, self._unknown = -np.inf, 0
        self._lost: list[Span] = []
        self._is_all_shown = found.count <= _BINS
        self._shown: list[SetClearance] = []

    def take(self, pairs: SetClearance, ends: Floats) -> None:
        """Take the next states, and when [s] the ones behind them are."""
        seconds, whole = np.clip(ends - pairs.times, 0.0, self._longest), pairs.is_whole
        for k, of in enumerate((whole, pairs.is_stale & ~pairs.is_waiting, pairs.is_waiting)):
            self._held[k] += seconds[of].sum()
        for k, threshold in enumerate(self._thresholds):
            near = pairs.known_lower_bound <= threshold
            self._below[:, k] += seconds[near & whole].sum(), seconds[near & ~whole].sum()
        self._contacts.take(pairs)
        known = pairs.age[np.isfinite(pairs.age)]
        self._unknown += len(pairs.age) - len(known)
        self._oldest = max(self._oldest, known.max(initial=-np.inf))
        self._ages += np.bincount(np.searchsorted(AGES, known), minlength=len(self._ages))
        self._lose(pairs.times, ends, ~whole)
        self._shown.append(pairs if self._is_all_shown else self._nearest(pairs))

    def _lose(self, times: Floats, ends: Floats, lost: Flags) -> None:
        """Note when not all is told; what lies closer together than is seen is one span."""
        for begin, end in _rows(lost):
            span = Span(float(times[begin]), float(ends[end - 1]))
            if self._lost and span.begin <= self._lost[-1].end + self._duration / _BINS:
                self._lost[-1] = Span(self._lost[-1].begin, max(span.end, self._lost[-1].end))
            else:
                self._lost.append(span)

    def _nearest(self, pairs: SetClearance) -> SetClearance:
        """Return of each bin of time the nearest state."""
        bins = np.minimum((pairs.times / self._duration * _BINS).astype(np.int64), _BINS - 1)
        lower = pairs.known_lower_bound
        order = np.lexsort((np.where(np.isnan(lower), np.inf, lower), bins))
        return pairs.some(np.sort(order[np.flatnonzero(np.diff(bins[order], prepend=-1))]))

    def result(self) -> Highlights:
        """Return all of it."""
        shown = joined(self._shown)
        silent = max(0.0, self._duration - float(self._held.sum()))
        whole, stale, waiting = self._held.tolist()
        rows = zip(self._thresholds.tolist(), *self._below.tolist(), strict=True)
        oldest = float(self._oldest) if np.isfinite(self._oldest) else np.nan
        contacts, count = self._contacts.result()
        return Highlights(
            held=Held(whole, stale, waiting, silent),
            below=tuple(Below(*row) for row in rows),
            contacts=contacts,
            contact_count=count,
            ages=Ages(oldest, tuple(self._ages.tolist()), self._unknown),
            lost=tuple(self._lost),
            shown=shown if self._is_all_shown else self._nearest(shown),
        )


class _Contacts:
    """States in a row in which something is not certified to be apart, by what is known."""

    def __init__(self) -> None:
        self._found: list[Contact] = []
        self._count = 0
        self._open: Contact | None = None  # the last state that was taken is of it
        self._deepest = np.inf  # [m] its lower bound

    def take(self, pairs: SetClearance) -> None:
        """Take the next states."""
        lower = pairs.known_lower_bound
        touching = lower <= 0.0
        if self._open is not None and not touching[0]:
            self._close()
        for begin, end in _rows(touching):
            k = int(begin + np.argmin(lower[begin:end]))
            before, self._open = self._open, None
            first = float(pairs.times[begin]) if before is None else before.begin
            count = int(end - begin) + (0 if before is None else before.states)
            deepest = pairs.at(k)
            if before is not None and self._deepest <= lower[k]:
                deepest = before.deepest
            self._deepest = float(lower[k] if before is None else min(lower[k], self._deepest))
            self._open = Contact(first, float(pairs.times[end - 1]), count, deepest)
            if end < len(lower):
                self._close()

    def _close(self) -> None:
        if self._open is not None:
            self._count += 1
            if len(self._found) < MOST_CONTACTS:
                self._found.append(self._open)
            self._open = None

    def result(self) -> tuple[tuple[Contact, ...], int]:
        """Return the first ones, and how many there are."""
        self._close()
        return tuple(self._found), self._count


def _rows(flags: Flags) -> Iterator[tuple[int, int]]:
    """Yield where flags are set in a row: from one place to before another."""
    steps = np.diff(np.concatenate(([False], flags, [False])).astype(np.int8))
    yield from zip(
        np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True
    )
