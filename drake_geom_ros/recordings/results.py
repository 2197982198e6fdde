"""What is found of a recording: least distances over time, and all that was not told."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import counted
from drake_geom_ros.recordings.close_moments import CloseMoment
from drake_geom_ros.recordings.errors import IncompleteRecordingError
from drake_geom_ros.recordings.maps import told_maps
from drake_geom_ros.recordings.playback import Refused, Trouble
from drake_geom_ros.recordings.raw_messages import NANOSECONDS, Damage
from drake_geom_ros.recordings.set_clearance import (
    Certified,
    Moment,
    Proofs,
    SetClearance,
    Span,
    joined,
)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
_MOST_NAMES = 8


@dataclass(frozen=True, eq=False)
class States:
    """Least distances of sets of pairs over N states in a row."""

    times: Floats  # (N,) [s] since the recording began
    stamps: Indices  # (N,) [ns] when the messages were recorded
    # (N,) how far all frames went until then: [m] of their origins, and [rad] of their turns
    travelled: Floats
    sets: Mapping[str, SetClearance]


@dataclass(frozen=True, eq=False)
class Facts:
    """What is known of a recording as a whole.

    ``gaps`` are the times without a state for longer than ``stale_after``, from the first to the
    last message of the recording, of whatever topic: a sender that died before the end leaves one.
    """

    begin: int  # [ns] the first message of the recording, used or not
    end: int  # [ns] the last one
    gaps: tuple[Span, ...]
    silence: Span  # the longest time without a state, be it a gap or not
    damage: tuple[Damage, ...]
    refused: tuple[Refused, ...]  # messages that say nothing of use, by topic
    maps: tuple[str, ...]  # topics of what sensors see, which is in no distance
    differences: tuple[str, ...]  # between the recorded ``~/scene`` and the scene played here
    troubles: tuple[Trouble, ...]
    stale_after: float  # [s]
    max_distance: float  # [m]
    travelled_in_all: float  # as ``States.travelled`` of the last state
    seconds_reading: float
    seconds_computing: float
    # By set the moments in which things were closest for a while, the closest one first.
    moments: Mapping[str, tuple[CloseMoment, ...]]

    @property
    def duration(self) -> float:
        """How long the recording is [s]."""
        return (self.end - self.begin) / NANOSECONDS


@dataclass(frozen=True, eq=False)
class Told(Facts):
    """What is known of a recording as a whole, and its states, which may be too many to hold."""

    @abstractmethod
    def parts(self) -> Iterator[States]:
        """Yield all states, some in a row at a time."""

    @cached_property
    def _sums(self) -> dict[str, _Sum]:
        found = {name: _Sum() for name in self.moments}
        for part in self.parts():
            for name, pairs in part.sets.items():
                found[name].take(pairs)
        return found

    @property
    def count(self) -> int:
        """How many states there are."""
        return next(iter(self._sums.values())).states

    def certified(self, name: str) -> Certified:
        """Return what is proved of the motion; raises ArgumentError: it was not asked."""
        return self._sums[name].proofs.result()

    @property
    def is_certified(self) -> bool:
        """Whether motions were asked to be certified."""
        return any(each.is_certified for each in self._sums.values())

    def reservations(self) -> list[str]:
        """Return in words what is not known; empty where everything is."""
        told = [each.in_words(self.begin) for each in self.damage]
        if self.gaps:
            lost = sum(gap.end - gap.begin for gap in self.gaps)
            ends = 'at the beginning' if self.gaps[0].begin <= 0.0 else ''
            if self.gaps[-1].end >= self.duration:
                ends += f'{" and " if ends else ""}at the end'
            told.append(
                f'{counted(len(self.gaps), "gap")} without data, {lost:.3f} s in all'
                f'{f", also {ends} of the recording" if ends else ""}'
            )
        told += [each.in_words() for each in self.refused]
        told += [trouble.words for trouble in self.troubles if trouble.is_doubt]
        if maps := told_maps(self.maps):
            told.append(maps)
        told += self.differences
        for name, each in self._sums.items():
            told += [f'{name}: {words}' for words in each.reservations()]
        return told

    def least(self, name: str = '', *, allow_incomplete: bool = False) -> Moment:
        """Return the state and pair of the least lower bound, of one set or of all.

        Raises IncompleteRecordingError where anything is not known, unless ``allow_incomplete``:
        then what is known counts, stale poses too; and where nothing is known.
        """
        sums = [self._sums[name]] if name else list(self._sums.values())
        if not allow_incomplete and (told := self.reservations()):
            raise IncompleteRecordingError(
                f'the recording does not tell all: {"; ".join(told)}. allow_incomplete=True takes '
                'what is known'
            )
        found = [(each.lower, each.least) for each in sums if each.least is not None]
        if not found:
            raise IncompleteRecordingError('no pair is known at any time of the recording')
        return min(found, key=lambda pair: pair[0])[1]


@dataclass(frozen=True, eq=False)
class Clearances(States, Told):
    """Least distances of sets of pairs over the N states of a recording: ``found['all']``."""

    @classmethod
    def of(cls, facts: Facts, parts: list[States]) -> Clearances:
        """Put parts that follow each other together."""
        return cls(
            times=np.concatenate([part.times for part in parts]),
            stamps=np.concatenate([part.stamps for part in parts]),
            travelled=np.concatenate([part.travelled for part in parts]),
            sets={n: joined([part.sets[n] for part in parts]) for n in facts.moments},
            **{field.name: getattr(facts, field.name) for field in fields(Facts)},
        )

    def __getitem__(self, name: str) -> SetClearance:
        """Return a set of pairs by its name, ``'all'`` where none were named."""
        return self.sets[name]

    def parts(self) -> Iterator[States]:
        """Yield all states at once."""
        yield self


class _Sum:
    """What is told of all states of a set of pairs, taken part by part."""

    def __init__(self) -> None:
        self.states = self._stale = self._waiting = self._left_out = 0
        self._first, self._last = math.inf, 0.0  # [s] stale ones
        self._frames: dict[str, None] = {}
        self.lower = math.inf  # [m] the least
        self.least: Moment | None = None
        self.proofs, self.is_certified = Proofs(), False

    def take(self, pairs: SetClearance) -> None:
        self.states += len(pairs.times)
        self._stale += int(pairs.is_stale.sum())
        if pairs.is_stale.any():
            ends = pairs.times[pairs.is_stale][[0, -1]].tolist()
            self._first, self._last = min(self._first, ends[0]), ends[1]
        self._waiting += int(pairs.is_waiting.sum())
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
