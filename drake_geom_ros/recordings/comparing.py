"""Two runs beside each other: by time, or by the phase of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.recordings.errors import IncompleteRecordingError
from drake_geom_ros.recordings.results import Clearances, SetClearance

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
WAYS = ('time', 'phase')
_PARTS = 1000  # into which a run is cut


class PairDifference(NamedTuple):
    """The least distance of a pair where it was the nearest of its set, in two runs."""

    name_A: str
    name_B: str
    run: float  # [m] inf: it never was the nearest
    other: float  # [m]


@dataclass(frozen=True, eq=False)
class SetComparison:
    """A set of pairs in two runs, part by part; of each part the state of least distance."""

    name: str
    ends: Floats  # (m + 1,) of the parts, [s] or phases from 0 to 1
    run: Floats  # (m,) [m] least distance; nan: no state
    other: Floats  # (m,) [m]
    is_whole: Flags  # (m,) both have states there, and all of these tell of all pairs
    pairs: tuple[PairDifference, ...]  # by how much nearer they came in the run
    not_known_of_run: tuple[str, ...] = ()  # ``Clearances.reservations()``
    not_known_of_other: tuple[str, ...] = ()

    @property
    def is_known(self) -> bool:
        """Whether both runs are known in all parts, and have no reservations."""
        return bool(self.is_whole.all()) and not self.not_known_of_run + self.not_known_of_other

    @property
    def difference(self) -> Floats:
        """By how much [m] the run's distance is larger (m,); nan where not both are known."""
        with np.errstate(invalid='ignore'):
            found: Floats = self.run - self.other
        both_far = np.isinf(self.run) & np.isinf(self.other)
        return np.where(both_far, 0.0, found)

    def nearer(self, *, allow_incomplete: bool = False) -> tuple[float, float]:
        """Return by how much [m] the run comes nearer at most, and where; 0 where it does not.

        Raises IncompleteRecordingError where not all is known of both, unless
        ``allow_incomplete``: then only parts count of which both tell something.
        """
        if not (allow_incomplete or self.is_known):
            unknown = int(np.count_nonzero(~self.is_whole))
            told = [f'{unknown} of {len(self.run)} parts are not known of both runs']
            told += [f'this run: {each}' for each in self.not_known_of_run]
            told += [f'the other run: {each}' for each in self.not_known_of_other]
            raise IncompleteRecordingError(
                f'{self.name}: {"; ".join(told)}. allow_incomplete=True takes what is known'
            )
        found = np.nan_to_num(-self.difference, nan=-np.inf)
        k = int(np.argmax(found))
        return max(0.0, float(found[k])), float(self.ends[k])


def compare_runs(run: Clearances, other: Clearances, by: str = 'time') -> list[SetComparison]:
    """Return the sets of pairs of a run beside those of another one, by their names.

    Both are cut into 1000 parts: of the time of the longer one, or by ``'phase'`` of the motion of
    each, which is what its frames went so far of all that they went (``Clearances.travelled``).
    Raises ArgumentError for another way, and for runs with other sets of pairs.

        for each in compare_runs(clearance(new, cell), clearance(old, cell), by='phase'):
            assert each.nearer()[0] < 0.01
    """
    if by not in WAYS:
        raise ArgumentError(f'by={by!r} must be one of {", ".join(WAYS)}')
    if list(run.sets) != list(other.sets):
        raise ArgumentError(
            f'the runs have other sets of pairs: {list(run.sets)} and {list(other.sets)}'
        )
    if by == 'time':
        end = max(run.duration, other.duration)
        places = [each.times / (end or 1.0) for each in (run, other)]
        holds = [each.stale_after / (end or 1.0) for each in (run, other)]
    else:
        end = 1.0
        places = [each.travelled / (each.travelled[-1] or 1.0) for each in (run, other)]
        holds = [1.0, 1.0]  # between two states nothing else was passed
    ends = np.linspace(0.0, end, _PARTS + 1)
    not_known = tuple(run.reservations()), tuple(other.reservations())
    return [
        _compared(ends, (run.sets[name], other.sets[name]), places, holds, not_known)
        for name in run.sets
    ]


def _compared(
    ends: Floats,
    both: tuple[SetClearance, SetClearance],
    places: Sequence[Floats],
    holds: Sequence[float],
    not_known: tuple[tuple[str, ...], tuple[str, ...]],
) -> SetComparison:
    run, other = (_by_part(*each) for each in zip(both, places, holds, strict=True))
    return SetComparison(
        name=both[0].name,
        ends=ends,
        run=run[0],
        other=other[0],
        is_whole=run[1] & other[1],
        pairs=_by_pair(*both),
        not_known_of_run=not_known[0],
        not_known_of_other=not_known[1],
    )


def _by_part(pairs: SetClearance, places: Floats, holds: float) -> tuple[Floats, Flags]:
    """Return of each part the least distance that is known, and whether all of it is known.

    A part without a state has the one before it, as long as that ``holds``.
    """
    parts = np.minimum((places * _PARTS).astype(np.int64), _PARTS - 1)
    least, last = np.full(_PARTS, np.nan), np.full(_PARTS, -1)
    np.fmin.at(least, parts, pairs.known_distance)
    np.maximum.at(last, parts, np.arange(len(parts)))
    lost = np.zeros(_PARTS, dtype=np.bool_)
    lost[parts[~pairs.is_whole]] = True
    own, last = last >= 0, np.maximum.accumulate(last)
    age = np.arange(1, _PARTS + 1) / _PARTS - places[np.maximum(last, 0)]
    held = ~own & (last >= 0) & (age <= holds)
    least[held] = pairs.known_distance[last[held]]
    lost[held] = ~pairs.is_whole[last[held]]
    return least, (own | held) & ~lost


def _by_pair(run: SetClearance, other: SetClearance) -> tuple[PairDifference, ...]:
    found: dict[frozenset[str], list[float]] = {}
    for k, pairs in enumerate((run, other)):
        for names, distance in _least_of_pairs(pairs).items():
            found.setdefault(names, [np.inf, np.inf])[k] = distance
    rows = [
        PairDifference(min(names), max(names), mine, theirs)
        for names, (mine, theirs) in found.items()
    ]
    return tuple(sorted(rows, key=lambda row: (row.run - row.other, row.run)))


def _least_of_pairs(pairs: SetClearance) -> dict[frozenset[str], float]:
    known = np.flatnonzero((pairs.geometry_A >= 0) & np.isfinite(pairs.known_distance))
    both = np.column_stack((pairs.geometry_A, pairs.geometry_B))[known]
    each, inverse = np.unique(both, axis=0, return_inverse=True)
    least = np.full(len(each), np.inf)
    np.minimum.at(least, inverse.ravel(), pairs.known_distance[known])
    return {
        frozenset((pairs.names[a], pairs.names[b])): float(distance)
        for (a, b), distance in zip(each.tolist(), least, strict=True)
    }
