"""Comparison of two runs, by time or by phase of the motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.recordings.errors import IncompleteRecordingError
from drake_geom_ros.recordings.results import RunAnalysis
from drake_geom_ros.recordings.set_clearance import SetClearance

WAYS = ('time', 'phase')
_PARTS = 1000  # into which a run is cut


class PairDifference(NamedTuple):
    """Minimum distance of a pair in two runs, over the states where it was nearest of its set."""

    name_A: str
    name_B: str
    run: float  # [m] inf: it never was nearest
    other: float  # [m]


@dataclass(frozen=True, eq=False)
class SetComparison:
    """Minimum distances of a set of pairs in two runs, in m parts of the run."""

    name: str
    ends: Floats  # (m + 1,) of the parts, [s] or phases from 0 to 1
    run: Floats  # (m,) [m] minimum distance; nan: no state
    other: Floats  # (m,) [m]
    is_whole: Flags  # (m,) both runs have states there, all of which are complete
    pairs: tuple[PairDifference, ...]  # those that came nearer by most in the run first
    by: str  # 'time' or 'phase'
    not_known_of_run: tuple[str, ...] = ()  # ``Clearances.reservations()``
    not_known_of_other: tuple[str, ...] = ()

    @property
    def is_known(self) -> bool:
        """True if both runs are known in all parts, and have no reservations."""
        return bool(self.is_whole.all()) and not self.not_known_of_run + self.not_known_of_other

    @property
    def difference(self) -> Floats:
        """Distance of the run minus that of the other (m,) [m]; nan where one is unknown."""
        with np.errstate(invalid='ignore'):
            difference: Floats = self.run - self.other
        is_equal = self.run == self.other  # also where both are inf or both -inf
        return np.where(is_equal, 0.0, difference)

    def nearer(self, *, allow_incomplete: bool = False) -> tuple[float, float]:
        """Return by how much [m] at most the run comes nearer, and where; 0 if it does not.

        Raises IncompleteRecordingError if either run is not fully known, unless
        ``allow_incomplete``: then only parts with states of both count.
        """
        if not (allow_incomplete or self.is_known):
            unknown = int(np.count_nonzero(~self.is_whole))
            reasons = [f'{unknown} of {len(self.run)} parts are not known of both runs']
            reasons += [f'this run: {each}' for each in self.not_known_of_run]
            reasons += [f'the other run: {each}' for each in self.not_known_of_other]
            raise IncompleteRecordingError(
                f'{self.name}: {"; ".join(reasons)}. allow_incomplete=True takes what is known'
            )
        nearer_by = np.nan_to_num(-self.difference, nan=-np.inf, posinf=np.inf)
        k = int(np.argmax(nearer_by))
        return max(0.0, float(nearer_by[k])), float(self.ends[k])


def compare_runs(run: RunAnalysis, other: RunAnalysis, by: str = 'time') -> list[SetComparison]:
    """Return a comparison for each set of pairs of two runs.

    Both runs are cut into 1000 parts, by ``'time'`` of the longer one or by ``'phase'`` of each
    one's motion: the fraction of the way that its frames travelled (``Clearances.travelled``).
    Raises ArgumentError for another ``by``, and for runs with different sets of pairs.

        for each in compare_runs(clearance(new, cell), clearance(old, cell), by='phase'):
            assert each.nearer()[0] < 0.01
    """
    if by not in WAYS:
        raise ArgumentError(f'by={by!r} must be one of {", ".join(WAYS)}')
    if list(run.moments) != list(other.moments):
        raise ArgumentError(
            f'the runs have other sets of pairs: {list(run.moments)} and {list(other.moments)}'
        )
    both = run, other
    if by == 'time':
        end = max(run.duration, other.duration)
        wholes = [end or 1.0] * 2
        holds = [each.stale_after / (end or 1.0) for each in both]
    else:
        end = 1.0
        wholes = [each.travelled_in_all or 1.0 for each in both]
        holds = [1.0, 1.0]  # the phase does not pass other poses between two states
    of_run, of_other = (
        _cut(each, by, whole, hold) for each, whole, hold in zip(both, wholes, holds, strict=True)
    )
    not_known = [tuple(each.reservations()) for each in both]
    return [
        SetComparison(
            name=name,
            ends=np.linspace(0.0, end, _PARTS + 1),
            run=of_run[name].least,
            other=of_other[name].least,
            is_whole=of_run[name].is_whole & of_other[name].is_whole,
            pairs=_by_pair(of_run[name].of_pairs, of_other[name].of_pairs),
            by=by,
            not_known_of_run=not_known[0],
            not_known_of_other=not_known[1],
        )
        for name in run.moments
    ]


class _RunParts(NamedTuple):
    """Minimum distances of a set of pairs in the parts of a run."""

    least: Floats  # [m] over the known pairs
    is_whole: Flags
    of_pairs: dict[frozenset[str], float]  # [m] minimum of each over states where it is nearest


def _cut(run: RunAnalysis, by: str, whole: float, holds: float) -> dict[str, _RunParts]:
    """Return the sets of a run, cut into parts of the ``whole`` way or time."""
    cuts = {name: _Cut(holds) for name in run.moments}
    for states in run.parts():
        places = (states.times if by == 'time' else states.travelled) / whole
        for name, pairs in states.sets.items():
            cuts[name].take(pairs, places)
    return {name: cut.result() for name, cut in cuts.items()}


class _Cut:
    """Collects for each part of a run the minimum known distance, and whether it is complete.

    A part without a state takes the last one before it, if not older than ``holds``, a fraction
    of the whole.
    """

    def __init__(self, holds: float) -> None:
        self._holds = holds
        self._least = np.full(_PARTS, np.nan)
        self._lost, self._own = np.zeros((2, _PARTS), dtype=np.bool_)
        # Distance, place and completeness of the last state in each part.
        self._last, self._place = np.full((2, _PARTS), np.nan)
        self._was_whole = np.zeros(_PARTS, dtype=np.bool_)
        self._of_pairs: dict[frozenset[str], float] = {}

    def take(self, pairs: SetClearance, places: Floats) -> None:
        """Process the next states, at ``places`` from 0 to 1."""
        parts = np.minimum((places * _PARTS).astype(np.int64), _PARTS - 1)
        np.fmin.at(self._least, parts, pairs.known_distance)
        self._lost[parts[~pairs.is_whole]] = True
        self._own[parts] = True
        last = np.flatnonzero(np.append(parts[1:] != parts[:-1], True))
        self._last[parts[last]] = pairs.known_distance[last]
        self._place[parts[last]] = places[last]
        self._was_whole[parts[last]] = pairs.is_whole[last]
        for names, distance in _least_of_pairs(pairs).items():
            self._of_pairs[names] = min(distance, self._of_pairs.get(names, np.inf))

    def result(self) -> _RunParts:
        """Return the parts after all states were processed."""
        before = np.maximum.accumulate(np.where(self._own, np.arange(_PARTS), -1))
        held = ~self._own & (before >= 0)
        held &= np.arange(1, _PARTS + 1) / _PARTS - self._place[before] <= self._holds
        self._least[held] = self._last[before[held]]
        self._lost[held] = ~self._was_whole[before[held]]
        return _RunParts(self._least, (self._own | held) & ~self._lost, self._of_pairs)


def _by_pair(
    run: dict[frozenset[str], float], other: dict[frozenset[str], float]
) -> tuple[PairDifference, ...]:
    rows = [
        PairDifference(min(n), max(n), run.get(n, np.inf), other.get(n, np.inf))
        for n in {**run, **other}
    ]
    return tuple(sorted(rows, key=lambda row: (row.run - row.other, row.run)))


def _least_of_pairs(pairs: SetClearance) -> dict[frozenset[str], float]:
    states = np.flatnonzero((pairs.geometry_A >= 0) & (pairs.known_distance < np.inf))
    both = np.column_stack((pairs.geometry_A, pairs.geometry_B))[states]
    each, inverse = np.unique(both, axis=0, return_inverse=True)
    least = np.full(len(each), np.inf)
    np.minimum.at(least, inverse.ravel(), pairs.known_distance[states])
    return {
        frozenset((pairs.names[a], pairs.names[b])): float(distance)
        for (a, b), distance in zip(each.tolist(), least, strict=True)
    }
