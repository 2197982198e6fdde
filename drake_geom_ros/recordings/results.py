"""What ``clearance`` returns: least distances over time, and all that was not told."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.recordings.errors import IncompleteRecordingError
from drake_geom_ros.recordings.playback import Refused, Trouble
from drake_geom_ros.recordings.storages import NANOSECONDS, Damage

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]
_MOST_NAMES = 8


class Span(NamedTuple):
    """A time [s] from one state to another."""

    begin: float
    end: float


class Certified(NamedTuple):
    """What is proved of the motion between states: all of it is clear if all motions are."""

    lower_bound: float  # [m] of the clear ones, the least; nan where there is none
    span: Span | None  # where that is
    clear: int  # motions from one state to the next
    contact: int  # that come into contact
    unknown: int  # of which nothing is proved


class Moment(NamedTuple):
    """The pair of the least lower bound at a time."""

    time: float  # [s] since the recording began
    distance: float  # [m]; inf: farther than was asked for
    error_bound: float  # [m]
    name_A: str
    name_B: str
    p_WCa: Floats  # (3,) [m]
    p_WCb: Floats  # (3,) [m]


@dataclass(frozen=True, eq=False)
class SetClearance:
    """The least distance of a set of pairs in each of N states.

    ``distance`` and ``error_bound`` are those of ``batch.evaluate`` with ``want='least'``, and nan
    where the state ``is_waiting`` or ``is_stale``: there ``known_distance`` is what the pairs and
    poses that are known tell, nan where no pair is known. inf: all pairs are certified to be
    farther apart than ``max_distance``.
    """

    name: str
    times: Floats  # (N,) [s] since the recording began
    known_distance: Floats  # (N,) [m]
    known_error_bound: Floats  # (N,) [m]
    geometry_A: NDArray[np.int32]  # (N,) places in ``names``; -1 where no pair is told
    geometry_B: NDArray[np.int32]  # (N,)
    names: tuple[str, ...]
    p_WCa: Floats  # (N, 3) [m] witness points
    p_WCb: Floats  # (N, 3) [m]
    age: Floats  # (N,) [s] of the oldest pose that matters; inf: unknown
    left_out: Indices  # (N,) how many pairs wait for a pose
    waiting_frames: tuple[str, ...]  # for which they wait, at any time
    is_stale: Flags  # (N,) a pose that matters is older than ``stale_after``, or of unknown age
    # Of the motion to each state from the one before, where it was asked to be certified:
    motion: NDArray[np.int8] | None = None  # (N,) 0: unknown, 1: clear, 2: contact
    motion_bound: Floats | None = None  # (N,) [m] certified all the way; nan but of a clear one

    @property
    def is_waiting(self) -> Flags:
        """Whether pairs are left out (N,), for frames that never had a pose."""
        return self.left_out > 0

    @property
    def is_whole(self) -> Flags:
        """Whether a state tells of all pairs, by fresh poses (N,)."""
        return ~(self.is_waiting | self.is_stale)

    @property
    def distance(self) -> Floats:
        """The least distance (N,) [m], nan where not all is known."""
        return np.where(self.is_whole, self.known_distance, np.nan)

    @property
    def error_bound(self) -> Floats:
        """How far the distance may be off (N,) [m], nan where that is."""
        return np.where(self.is_whole, self.known_error_bound, np.nan)

    @property
    def lower_bound(self) -> Floats:
        """Distance minus error bound (N,) [m]: no pair is certified to be nearer."""
        return self.distance - self.error_bound

    @property
    def name_A(self) -> NDArray[np.str_]:
        """The name of the first geometry (N,), empty where no pair is told."""
        return np.array([*self.names, ''])[self.geometry_A]

    @property
    def name_B(self) -> NDArray[np.str_]:
        """The name of the second geometry (N,)."""
        return np.array([*self.names, ''])[self.geometry_B]

    def certified(self) -> Certified:
        """Return what is proved of the whole motion; raises ArgumentError: it was not asked."""
        if self.motion is None or self.motion_bound is None:
            raise ArgumentError('motions were not certified: clearance(..., certify=0.001)')
        codes, bounds = self.motion[1:], self.motion_bound[1:]
        counts = (int(np.count_nonzero(codes == code)) for code in (1, 2, 0))
        clear, contact, unknown = counts
        if not clear:
            return Certified(math.nan, None, clear, contact, unknown)
        k = int(np.nanargmin(bounds))
        span = Span(float(self.times[k]), float(self.times[k + 1]))
        return Certified(float(bounds[k]), span, clear, contact, unknown)

    def at(self, state: int) -> Moment:
        """Return what is known of a state."""
        a, b = int(self.geometry_A[state]), int(self.geometry_B[state])
        return Moment(
            float(self.times[state]),
            float(self.known_distance[state]),
            float(self.known_error_bound[state]),
            '' if a < 0 else self.names[a],
            '' if b < 0 else self.names[b],
            self.p_WCa[state],
            self.p_WCb[state],
        )


@dataclass(frozen=True, eq=False)
class Clearances:
    """Least distances of sets of pairs over the N states of a recording: ``found['all']``.

    ``gaps`` are the times without a state for longer than ``stale_after``, from the first to the
    last message of the recording, of whatever topic: a sender that died before the end leaves one.
    """

    times: Floats  # (N,) [s] since the recording began
    stamps: Indices  # (N,) [ns] when the messages were recorded
    # (N,) how far all frames went until then: [m] of their origins, and [rad] of their turns
    travelled: Floats
    sets: Mapping[str, SetClearance]
    begin: int  # [ns] the first message of the recording, used or not
    end: int  # [ns] the last one
    gaps: tuple[Span, ...]
    damage: tuple[Damage, ...]
    refused: tuple[Refused, ...]  # messages that say nothing of use, by topic
    troubles: tuple[Trouble, ...]
    stale_after: float  # [s]
    max_distance: float  # [m]
    seconds_reading: float
    seconds_computing: float

    def __getitem__(self, name: str) -> SetClearance:
        """Return a set of pairs by its name, ``'all'`` where none were named."""
        return self.sets[name]

    @property
    def duration(self) -> float:
        """How long the recording is [s]."""
        return (self.end - self.begin) / NANOSECONDS

    def reservations(self) -> list[str]:
        """Return in words what is not known; empty where everything is."""
        told = [f'{each.file}: {each.reason}; {self._until(each)}' for each in self.damage]
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
        for each in self.sets.values():
            if each.motion is not None and (unknown := each.certified().unknown):
                told.append(f'{each.name}: nothing is proved of {counted(unknown, "motion")}')
            if stale := int(each.is_stale.sum()):
                told.append(f'{each.name}: {stale} of {len(self.times)} states are stale')
            if waiting := int(each.is_waiting.sum()):
                names = ', '.join(each.waiting_frames[:_MOST_NAMES])
                told.append(
                    f'{each.name}: in {waiting} of {len(self.times)} states up to '
                    f'{int(each.left_out.max())} pairs are left out, for these never had a pose '
                    f'until then: {names}'
                )
        return told

    def _until(self, damage: Damage) -> str:
        if damage.until < self.begin:
            return 'it told nothing'
        return f'it told something until {(damage.until - self.begin) / NANOSECONDS:.3f} s'

    def least(self, name: str = '', *, allow_incomplete: bool = False) -> Moment:
        """Return the state and pair of the least lower bound, of one set or of all.

        Raises IncompleteRecordingError where anything is not known, unless ``allow_incomplete``:
        then what is known counts, stale poses too; and where nothing is known.
        """
        sets = [self.sets[name]] if name else list(self.sets.values())
        if not allow_incomplete and (told := self.reservations()):
            raise IncompleteRecordingError(
                f'the recording does not tell all: {"; ".join(told)}. allow_incomplete=True takes '
                'what is known'
            )
        found = []
        for each in sets:
            lower = each.known_distance - each.known_error_bound
            if not np.isnan(lower).all():
                found.append((float(np.nanmin(lower)), each.at(int(np.nanargmin(lower)))))
        if not found:
            raise IncompleteRecordingError('no pair is known at any time of the recording')
        return min(found, key=lambda pair: pair[0])[1]
