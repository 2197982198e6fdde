"""Results of a recording: minimum distances over time, and reservations about them."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from drake_geom_ros.common.counting import counted
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.recordings.close_moments import CloseMoment
from drake_geom_ros.recordings.errors import IncompleteRecordingError
from drake_geom_ros.recordings.playback import RefusedMessages, Trouble
from drake_geom_ros.recordings.raw_messages import NANOSECONDS, Damage
from drake_geom_ros.recordings.recorded_maps import maps_remark
from drake_geom_ros.recordings.set_clearance import (
    Certified,
    Moment,
    Proofs,
    SetClearance,
    Span,
    joined,
)

_MOST_NAMES = 8


@dataclass(frozen=True, eq=False)
class StateMinima:
    """Minimum distances of sets of pairs over N consecutive states."""

    times: Floats  # (N,) [s] since the recording began
    stamps: Indices  # (N,) [ns] when the messages were recorded
    # (N,) way of all frames until then: [m] of their origins plus [rad] of their turns
    travelled: Floats
    sets: Mapping[str, SetClearance]


@dataclass(frozen=True, eq=False)
class Facts:
    """Facts about a recording as a whole.

    ``gaps`` are the times without a state for longer than ``stale_after``. They are sought from
    the first to the last message of any topic, so that a sender that died early leaves a gap.
    """

    begin: int  # [ns] of the first message of the recording, used or not
    end: int  # [ns] of the last one
    gaps: tuple[Span, ...]
    silence: Span  # the longest time without a state, a gap or not
    damage: tuple[Damage, ...]
    refused: tuple[RefusedMessages, ...]  # refused messages, by topic
    maps: tuple[str, ...]  # topics of sensor data, which are in no distance
    differences: tuple[str, ...]  # between the recorded ``~/scene`` and the scene played here
    troubles: tuple[Trouble, ...]
    stale_after: float  # [s]
    max_distance: float  # [m]
    travelled_in_all: float  # ``StateMinima.travelled`` of the last state
    seconds_reading: float
    seconds_computing: float
    # Moments of locally minimum distance by set, the closest one first.
    moments: Mapping[str, tuple[CloseMoment, ...]]

    @property
    def duration(self) -> float:
        """Duration of the recording [s]."""
        return (self.end - self.begin) / NANOSECONDS


@dataclass(frozen=True, eq=False)
class RunAnalysis(Facts):
    """Facts about a recording, with its states, which may be too many to hold in memory."""

    @abstractmethod
    def parts(self) -> Iterator[StateMinima]:
        """Yield all states in consecutive parts."""

    @cached_property
    def _sums(self) -> dict[str, _Sum]:
        sums = {name: _Sum() for name in self.moments}
        for part in self.parts():
            for name, pairs in part.sets.items():
                sums[name].take(pairs)
        return sums

    @property
    def count(self) -> int:
        """Number of states."""
        return next(iter(self._sums.values())).states

    def certified(self, name: str) -> Certified:
        """Return the certificate of a set's motion; ArgumentError if none was requested."""
        return self._sums[name].proofs.result()

    @property
    def is_certified(self) -> bool:
        """True if certificates of motions were requested."""
        return any(each.is_certified for each in self._sums.values())

    def reservations(self) -> list[str]:
        """Return texts on everything that is not known; empty if the result is complete."""
        reservations = [each.in_words(self.begin) for each in self.damage]
        if self.gaps:
            lost = sum(gap.end - gap.begin for gap in self.gaps)
            ends = 'at the beginning' if self.gaps[0].begin <= 0.0 else ''
            if self.gaps[-1].end >= self.duration:
                ends += f'{" and " if ends else ""}at the end'
            reservations.append(
                f'{counted(len(self.gaps), "gap")} without data, {lost:.3f} s in all'
                f'{f", also {ends} of the recording" if ends else ""}'
            )
        reservations += [each.in_words() for each in self.refused]
        reservations += [trouble.words for trouble in self.troubles if trouble.is_doubt]
        if maps := maps_remark(self.maps):
            reservations.append(maps)
        reservations += self.differences
        for name, each in self._sums.items():
            reservations += [f'{name}: {words}' for words in each.reservations()]
        return reservations

    def least(self, name: str = '', *, allow_incomplete: bool = False) -> Moment:
        """Return the moment and pair of the minimum lower bound, of one set or of all.

        Raises IncompleteRecordingError if there are reservations, unless ``allow_incomplete``:
        then known pairs count, with stale poses too. Also raises it if no pair is known.
        """
        sums = [self._sums[name]] if name else list(self._sums.values())
        if not allow_incomplete and (reservations := self.reservations()):
            raise IncompleteRecordingError(
                f'the recording does not tell all: {"; ".join(reservations)}. '
                'allow_incomplete=True takes what is known'
            )
        minima = [(each.lower, each.least) for each in sums if each.least is not None]
        if not minima:
            raise IncompleteRecordingError('no pair is known at any time of the recording')
        return min(minima, key=lambda pair: pair[0])[1]


@dataclass(frozen=True, eq=False)
class Clearances(StateMinima, RunAnalysis):
    """Minimum distances of sets of pairs over the N states of a recording, by set name."""

    @classmethod
    def of(cls, facts: Facts, parts: list[StateMinima]) -> Clearances:
        """Return the concatenation of consecutive parts."""
        return cls(
            times=np.concatenate([part.times for part in parts]),
            stamps=np.concatenate([part.stamps for part in parts]),
            travelled=np.concatenate([part.travelled for part in parts]),
            sets={n: joined([part.sets[n] for part in parts]) for n in facts.moments},
            **{field.name: getattr(facts, field.name) for field in fields(Facts)},
        )

    def __getitem__(self, name: str) -> SetClearance:
        """Return a set of pairs by its name, ``'all'`` if none was named."""
        return self.sets[name]

    def parts(self) -> Iterator[StateMinima]:
        """Yield all states as one part."""
        yield self


class _Sum:
    """Accumulator of the summary of a set of pairs."""

    def __init__(self) -> None:
        self.states = self._stale = self._waiting = self._left_out = self._empty = 0
        self._first, self._last = math.inf, 0.0  # [s] of stale states
        self._frames: dict[str, None] = {}
        self.lower = math.inf  # [m] minimum lower bound
        self.least: Moment | None = None
        self.proofs, self.is_certified = Proofs(), False

    def take(self, pairs: SetClearance) -> None:
        self.states += len(pairs.times)
        self._stale += int(pairs.is_stale.sum())
        if pairs.is_stale.any():
            ends = pairs.times[pairs.is_stale][[0, -1]].tolist()
            self._first, self._last = min(self._first, ends[0]), ends[1]
        self._waiting += int(pairs.is_waiting.sum())
        self._empty += int((np.isnan(pairs.known_distance) & ~pairs.is_waiting).sum())
        self._left_out = max(self._left_out, int(pairs.left_out.max(initial=0)))
        self._frames.update(dict.fromkeys(pairs.waiting_frames))
        self.is_certified |= pairs.motion is not None
        self.proofs.take(pairs)
        lower = pairs.known_lower_bound
        if np.isnan(lower).all():
            return
        k = int(np.nanargmin(lower))
        if self.least is None or lower[k] < self.lower:
            self.lower, self.least = float(lower[k]), pairs.at(k)

    def reservations(self) -> Iterator[str]:
        if self.is_certified and (unknown := self.proofs.result().unknown):
            yield f'nothing is proved of {counted(unknown, "motion")}'
        if self._stale:
            yield (
                f'{self._stale} of {self.states} states are stale, or of unknown age, between '
                f'{self._first:.3f} and {self._last:.3f} s'
            )
        if self._waiting:
            names = ', '.join([*self._frames][:_MOST_NAMES])
            yield (
                f'in {self._waiting} of {self.states} states up to {self._left_out} pairs are '
                f'left out, for these never had a pose until then: {names}'
            )
        if self._empty:
            yield (
                f'in {self._empty} of {self.states} states queries report no pair of the set: all '
                'are excluded, as an attachment does, or are not there'
            )
