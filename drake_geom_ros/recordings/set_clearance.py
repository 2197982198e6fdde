"""The least distances of a set of pairs over states in a row."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]
# By state, and present in each set; of motions only where they are certified.
COLUMNS = (
    *('known_distance', 'known_error_bound', 'geometry_A', 'geometry_B'),
    *('p_WCa', 'p_WCb', 'age', 'left_out', 'is_stale'),
)
MOTION_COLUMNS = 'motion', 'motion_bound'


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

    @property
    def known_lower_bound(self) -> Floats:
        """The lower bound (N,) [m] by the pairs and poses that are known."""
        return self.known_distance - self.known_error_bound

    def certified(self) -> Certified:
        """Return what is proved of the whole motion; raises ArgumentError: it was not asked."""
        proofs = Proofs()
        proofs.take(self)
        return proofs.result()

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return what is held by state, but for the times."""
        names = COLUMNS if self.motion is None else (*COLUMNS, *MOTION_COLUMNS)
        return {name: getattr(self, name) for name in names}

    def some(self, states: Indices | slice) -> SetClearance:
        """Return some of the states."""
        columns: dict[str, Any] = {n: values[states] for n, values in self.columns().items()}
        return replace(self, times=self.times[states], **columns)

    def at(self, state: int) -> Moment:
        """Return what is known of a state."""
        a, b = int(self.geometry_A[state]), int(self.geometry_B[state])
        return Moment(
            float(self.times[state]),
            float(self.known_distance[state]),
            float(self.known_error_bound[state]),
            '' if a < 0 else self.names[a],
            '' if b < 0 else self.names[b],
            self.p_WCa[state].copy(),  # and no view of all others
            self.p_WCb[state].copy(),
        )


class Proofs:
    """Counts what is proved of motions, over the states of a recording part by part."""

    def __init__(self) -> None:
        self._counts = np.zeros(3, dtype=np.int64)
        self._least, self._span = math.nan, Span(math.nan, math.nan)
        self._time: float | None = None  # [s] of the last state
        self._was_asked = False

    def take(self, pairs: SetClearance) -> None:
        """Take the next states; the motion to the first state of all is none."""
        self._was_asked = pairs.motion is not None and pairs.motion_bound is not None
        if pairs.motion is None or pairs.motion_bound is None or not len(pairs.times):
            return
        first = int(self._time is None)
        before = np.append(self._time or math.nan, pairs.times[:-1])
        self._time = float(pairs.times[-1])
        self._counts += np.bincount(pairs.motion[first:], minlength=3)
        bounds = pairs.motion_bound[first:]
        if np.isnan(bounds).all():
            return
        k = int(np.nanargmin(bounds)) + first
        if not bounds[k - first] >= self._least:
            self._least = float(bounds[k - first])
            self._span = Span(float(before[k]), float(pairs.times[k]))

    def result(self) -> Certified:
        """Return what is proved; raises ArgumentError: it was not asked."""
        if not self._was_asked:
            raise ArgumentError('motions were not certified: clearance(..., certify=0.001)')
        unknown, clear, contact = self._counts.tolist()
        span = self._span if clear else None
        return Certified(self._least, span, clear, contact, unknown)


def joined(parts: Sequence[SetClearance]) -> SetClearance:
    """Return the states of parts that follow each other as one."""
    names: dict[str, int] = {}
    columns: dict[str, list[NDArray[Any]]] = {}
    for part in parts:
        # The last one stands for none: -1.
        places = [*(names.setdefault(name, len(names)) for name in part.names), -1]
        for name, values in {'times': part.times, **part.columns()}.items():
            if name in ('geometry_A', 'geometry_B'):
                values = np.array(places, dtype=np.int32)[values]
            columns.setdefault(name, []).append(values)
    waiting = dict.fromkeys(frame for part in parts for frame in part.waiting_frames)
    return SetClearance(
        name=parts[0].name,
        names=tuple(names),
        waiting_frames=tuple(waiting),
        **{name: np.concatenate(each) for name, each in columns.items()},
    )
