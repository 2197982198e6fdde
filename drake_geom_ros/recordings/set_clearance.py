"""Minimum distances of a set of pairs over consecutive states."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.array_types import Flags, Floats, Indices

# Columns by state; those of motions exist only if motions are certified.
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
    """Certificate of the motions between states; the whole motion is clear if all are."""

    lower_bound: float  # [m] minimum over the clear motions; nan if there is none
    span: Span | None  # of the motion with this bound
    clear: int  # number of clear motions from one state to the next
    contact: int  # number of motions with a contact
    unknown: int  # number of motions without a proof


class Moment(NamedTuple):
    """The pair with the minimum lower bound at a time."""

    time: float  # [s] since the recording began
    distance: float  # [m]; inf: all pairs are beyond ``max_distance``
    error_bound: float  # [m]
    name_A: str
    name_B: str
    p_WCa: Floats  # (3,) [m]
    p_WCb: Floats  # (3,) [m]


@dataclass(frozen=True, eq=False)
class SetClearance:
    """Minimum distance of a set of pairs in each of N states.

    ``distance`` and ``error_bound`` are those of ``batch.evaluate`` with ``want='least'``, and nan
    if the state ``is_waiting`` or ``is_stale``. ``known_distance`` is the minimum over the known
    pairs and poses, nan if no pair is known. inf: all pairs are certified to be farther apart
    than ``max_distance``.
    """

    name: str
    times: Floats  # (N,) [s] since the recording began
    known_distance: Floats  # (N,) [m]
    known_error_bound: Floats  # (N,) [m]
    geometry_A: NDArray[np.int32]  # (N,) indices into ``names``; -1 if there is no pair
    geometry_B: NDArray[np.int32]  # (N,)
    names: tuple[str, ...]
    p_WCa: Floats  # (N, 3) [m] witness points
    p_WCb: Floats  # (N, 3) [m]
    age: Floats  # (N,) [s] of the oldest pose used; inf: unknown
    left_out: Indices  # (N,) number of pairs omitted for lack of a pose
    waiting_frames: tuple[str, ...]  # frames without a pose at any state
    is_stale: Flags  # (N,) a pose used is older than ``stale_after``, or of unknown age
    # The motion to each state from the previous one, if certificates were requested:
    motion: NDArray[np.int8] | None = None  # (N,) 0: unknown, 1: clear, 2: contact
    motion_bound: Floats | None = None  # (N,) [m] certified lower bound; nan unless clear

    @property
    def is_waiting(self) -> Flags:
        """True (N,) if pairs are omitted because frames have never received a pose."""
        return self.left_out > 0

    @property
    def is_whole(self) -> Flags:
        """True (N,) if a state is complete: all pairs, with fresh poses."""
        return ~(self.is_waiting | self.is_stale)

    @property
    def distance(self) -> Floats:
        """Minimum distance (N,) [m], nan in incomplete states."""
        return np.where(self.is_whole, self.known_distance, np.nan)

    @property
    def error_bound(self) -> Floats:
        """Error bound of the distance (N,) [m], nan in incomplete states."""
        return np.where(self.is_whole, self.known_error_bound, np.nan)

    @property
    def lower_bound(self) -> Floats:
        """Distance minus error bound (N,) [m]: every pair is certified to be this far apart."""
        return self.distance - self.error_bound

    @property
    def name_A(self) -> NDArray[np.str_]:
        """Name of the first geometry (N,), empty if there is no pair."""
        return np.array([*self.names, ''])[self.geometry_A]

    @property
    def name_B(self) -> NDArray[np.str_]:
        """Name of the second geometry (N,), empty if there is no pair."""
        return np.array([*self.names, ''])[self.geometry_B]

    @property
    def known_lower_bound(self) -> Floats:
        """Lower bound (N,) [m] over the known pairs and poses."""
        return self.known_distance - self.known_error_bound

    def certified(self) -> Certified:
        """Return the certificate of the whole motion; ArgumentError if none was requested."""
        proofs = Proofs()
        proofs.take(self)
        return proofs.result()

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return the columns by state, without the times."""
        names = COLUMNS if self.motion is None else (*COLUMNS, *MOTION_COLUMNS)
        return {name: getattr(self, name) for name in names}

    def some(self, states: Indices | slice) -> SetClearance:
        """Return the rows of some states."""
        columns: dict[str, Any] = {n: values[states] for n, values in self.columns().items()}
        return replace(self, times=self.times[states], **columns)

    def at(self, state: int) -> Moment:
        """Return the moment of a state, by its known pairs."""
        a, b = int(self.geometry_A[state]), int(self.geometry_B[state])
        return Moment(
            float(self.times[state]),
            float(self.known_distance[state]),
            float(self.known_error_bound[state]),
            '' if a < 0 else self.names[a],
            '' if b < 0 else self.names[b],
            self.p_WCa[state].copy(),  # a view would keep all states alive
            self.p_WCb[state].copy(),
        )


class Proofs:
    """Accumulator of the certificate of motions, over the states of a recording."""

    def __init__(self) -> None:
        self._counts = np.zeros(3, dtype=np.int64)
        self._least, self._span = math.nan, Span(math.nan, math.nan)
        self._time: float | None = None  # [s] of the last state
        self._is_requested = False

    def take(self, pairs: SetClearance) -> None:
        """Process the next states; there is no motion to the very first state."""
        self._is_requested = pairs.motion is not None and pairs.motion_bound is not None
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
        """Return the certificate; raises ArgumentError if none was requested."""
        if not self._is_requested:
            raise ArgumentError('motions were not certified: clearance(..., certify=0.001)')
        unknown, clear, contact = self._counts.tolist()
        span = self._span if clear else None
        return Certified(self._least, span, clear, contact, unknown)


def joined(parts: Sequence[SetClearance]) -> SetClearance:
    """Return the concatenation of consecutive parts."""
    names: dict[str, int] = {}
    columns: dict[str, list[NDArray[Any]]] = {}
    for part in parts:
        # The last entry, at index -1, stands for no geometry.
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
