"""Highlights of a set of pairs for a report, gathered part by part in constant memory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.recordings.results import RunAnalysis, StateMinima
from drake_geom_ros.recordings.set_clearance import Moment, SetClearance, Span, joined

MOST_CONTACTS = 100  # in a report
AGES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # [s] upper limits of bins of states
_BINS = 3000  # of time; only the nearest state of each is drawn


class Contact(NamedTuple):
    """Consecutive states whose minimum distance is not certified to be above 0."""

    begin: float  # [s]
    end: float  # [s]
    states: int
    deepest: Moment


class Below(NamedTuple):
    """Durations for which a distance was not certified to be above a threshold."""

    threshold: float  # [m]
    seconds: float  # of complete states
    at_known: float  # [s] of incomplete states, by the known pairs and poses


class KnownDurations(NamedTuple):
    """Durations [s] of states by completeness; each lasts until the next, or ``stale_after``."""

    whole: float
    stale: float
    waiting: float
    silent: float  # without a recent state


class Ages(NamedTuple):
    """Distribution over states of the age of the oldest pose used."""

    oldest: float  # [s] maximum of the known ages; nan: none is known
    counts: tuple[int, ...]  # states in the bins that ``AGES`` divide, the last one above all
    unknown: int  # states of unknown age


@dataclass(frozen=True, eq=False)
class Highlights:
    """Highlights of a set of pairs for a report."""

    held: KnownDurations
    below: tuple[Below, ...]  # by threshold
    contacts: tuple[Contact, ...]  # the first of ``contact_count``, by the known pairs
    contact_count: int
    ages: Ages
    lost: tuple[Span, ...]  # times of incomplete states
    shown: SetClearance  # the nearest state of each bin of time


def highlights(run: RunAnalysis, thresholds: Sequence[float]) -> dict[str, Highlights]:
    """Return the highlights of each set of pairs, with the times below thresholds [m]."""
    gathered = {name: _HighlightGatherer(run, thresholds) for name in run.moments}
    for part, ends in _with_ends(run):
        for name, pairs in part.sets.items():
            gathered[name].take(pairs, ends)
    return {name: each.result() for name, each in gathered.items()}


def _with_ends(run: RunAnalysis) -> Iterator[tuple[StateMinima, Floats]]:
    """Yield the states of a recording, with the times [s] of the next state, or of the end."""
    before = None
    for part in run.parts():
        if before is not None:
            yield before, np.append(before.times[1:], part.times[0])
        before = part
    if before is not None:
        yield before, np.append(before.times[1:], run.duration)


class _HighlightGatherer:
    """Accumulator of the highlights of a set of pairs."""

    def __init__(self, run: RunAnalysis, thresholds: Sequence[float]) -> None:
        self._longest, self._duration = run.stale_after, run.duration
        self._held = np.zeros(3)
        self._thresholds = np.array(thresholds, dtype=np.float64)
        self._below = np.zeros((2, len(thresholds)))
        self._contacts = _ContactGatherer()
        self._ages = np.zeros(len(AGES) + 1, dtype=np.int64)
        self._oldest, self._unknown = -np.inf, 0
        self._lost: list[Span] = []
        self._is_all_shown = run.count <= _BINS
        self._shown: list[SetClearance] = []

    def take(self, pairs: SetClearance, ends: Floats) -> None:
        """Process the next states; ``ends`` are the times [s] of the states after each."""
        seconds, whole = np.clip(ends - pairs.times, 0.0, self._longest), pairs.is_whole
        for k, of in enumerate((whole, pairs.is_stale & ~pairs.is_waiting, pairs.is_waiting)):
            self._held[k] += seconds[of].sum()
        for k, threshold in enumerate(self._thresholds):
            near = pairs.known_lower_bound <= threshold
            self._below[:, k] += seconds[near & whole].sum(), seconds[near & ~whole].sum()
        self._contacts.take(pairs)
        ages = pairs.age[np.isfinite(pairs.age)]
        self._unknown += len(pairs.age) - len(ages)
        self._oldest = max(self._oldest, ages.max(initial=-np.inf))
        self._ages += np.bincount(np.searchsorted(AGES, ages), minlength=len(self._ages))
        self._lose(pairs.times, ends, ~whole)
        self._shown.append(pairs if self._is_all_shown else self._nearest(pairs))

    def _lose(self, times: Floats, ends: Floats, lost: Flags) -> None:
        """Add the spans of incomplete states, merged if they are closer than a bin of time."""
        for begin, end in _rows(lost):
            span = Span(float(times[begin]), float(ends[end - 1]))
            if self._lost and span.begin <= self._lost[-1].end + self._duration / _BINS:
                self._lost[-1] = Span(self._lost[-1].begin, max(span.end, self._lost[-1].end))
            else:
                self._lost.append(span)

    def _nearest(self, pairs: SetClearance) -> SetClearance:
        """Return the nearest state of each bin of time."""
        bins = np.minimum((pairs.times / self._duration * _BINS).astype(np.int64), _BINS - 1)
        lower = pairs.known_lower_bound
        order = np.lexsort((np.where(np.isnan(lower), np.inf, lower), bins))
        return pairs.some(np.sort(order[np.flatnonzero(np.diff(bins[order], prepend=-1))]))

    def result(self) -> Highlights:
        """Return the highlights."""
        shown = joined(self._shown)
        silent = max(0.0, self._duration - float(self._held.sum()))
        whole, stale, waiting = self._held.tolist()
        rows = zip(self._thresholds.tolist(), *self._below.tolist(), strict=True)
        oldest = float(self._oldest) if np.isfinite(self._oldest) else np.nan
        contacts, count = self._contacts.result()
        return Highlights(
            held=KnownDurations(whole, stale, waiting, silent),
            below=tuple(Below(*row) for row in rows),
            contacts=contacts,
            contact_count=count,
            ages=Ages(oldest, tuple(self._ages.tolist()), self._unknown),
            lost=tuple(self._lost),
            shown=shown if self._is_all_shown else self._nearest(shown),
        )


class _ContactGatherer:
    """Accumulator of contacts, which consecutive states form."""

    def __init__(self) -> None:
        self._contacts: list[Contact] = []
        self._count = 0
        self._open: Contact | None = None  # the contact that includes the last state
        self._deepest = np.inf  # [m] its lower bound

    def take(self, pairs: SetClearance) -> None:
        """Process the next states."""
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
            if len(self._contacts) < MOST_CONTACTS:
                self._contacts.append(self._open)
            self._open = None

    def result(self) -> tuple[tuple[Contact, ...], int]:
        """Return the first contacts, and the number of all."""
        self._close()
        return tuple(self._contacts), self._count


def _rows(flags: Flags) -> Iterator[tuple[int, int]]:
    """Yield begin and end (exclusive) of each run of set flags."""
    steps = np.diff(np.concatenate(([False], flags, [False])).astype(np.int8))
    yield from zip(
        np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True
    )
