"""Compiled search for the nearest pair of each group of rules, in one pass over a cycle's pairs.

NumPy took a tenth of the whole cycle for it, for one rule as for twenty (``bench/costs``).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.compiling import Entry, given, like
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.proximity_rules.measured import NOTHING, Measured

Ids = NDArray[np.int64]
Words = NDArray[np.uint64]
WORD = 64  # bits
_NO_SPEEDS, _NO_IDS = np.empty(0), np.empty(0, dtype=np.int64)
_NO_WORDS = np.empty((1, 0), dtype=np.uint64)


class SetBits(NamedTuple):
    """Membership of geometries in the sets of rule groups, as bits in words of 64 groups.

    ``words_a`` is sparse, since most geometries are in few first sets: it stores only words with
    a bit set, one geometry after another. ``words_b`` is dense.
    """

    ids: Ids  # (n,) of the geometries, ascending
    begins_a: Ids  # (n + 1,) index into ``words_a`` where each geometry's words begin
    places_a: Ids  # column of each word in its dense row
    words_a: Words
    words_b: Words  # (n, w)


_NO_BITS = SetBits(_NO_IDS, np.zeros(1, dtype=np.int64), _NO_IDS, _NO_WORDS[0], _NO_WORDS)


class NearestPairs(NamedTuple):
    """Smallest lower bound and time to contact of each group (g,), and the pairs that have them.

    inf and -1 if the group has no pair.
    """

    lowest: Floats  # [m]
    lowest_pair: Ids  # the first if several are equal
    soonest: Floats  # [s]
    soonest_pair: Ids

    def of(self, groups: Ids) -> NearestPairs:
        """Return the rows of these groups (r,)."""
        return NearestPairs(
            self.lowest[groups],
            self.lowest_pair[groups],
            self.soonest[groups],
            self.soonest_pair[groups],
        )


def _find(
    id_As: Ids,
    id_Bs: Ids,
    distances: Floats,
    error_bounds: Floats,
    closing_speeds: Floats,
    farthest: float,
    bits: SetBits,
    nearest: NearestPairs,
) -> int:
    """Fill ``nearest`` from the pairs (k,) whose lower bound is at most ``farthest`` [m].

    ``closing_speeds`` (0,): not computed. Returns -1, or the index of a pair with a geometry that
    ``bits`` lacks.
    """
    for group in range(len(nearest.lowest)):
        nearest.lowest[group], nearest.soonest[group] = math.inf, math.inf
        nearest.lowest_pair[group], nearest.soonest_pair[group] = -1, -1
    ids, last = bits.ids, len(bits.ids) - 1
    for k in range(len(id_As)):
        lower = distances[k] - error_bounds[k]
        if math.isnan(lower):  # unknown, and no rule may treat it as clear
            lower = -math.inf
        if lower > farthest:
            continue
        time = math.inf
        if len(closing_speeds) and closing_speeds[k] > 0.0:
            time = max(lower, 0.0) / closing_speeds[k]
        id_A, id_B = id_As[k], id_Bs[k]
        row_A, row_B = np.searchsorted(ids, id_A), np.searchsorted(ids, id_B)
        if max(row_A, row_B) > last or ids[row_A] != id_A or ids[row_B] != id_B:
            return k
        for first, second in ((row_A, row_B), (row_B, row_A)):
            for at in range(bits.begins_a[first], bits.begins_a[first + 1]):
                place = bits.places_a[at]
                word = bits.words_a[at] & bits.words_b[second, place]
                while word:
                    bit = word & (~word + np.uint64(1))
                    word ^= bit
                    # A power of two is a float without error, its exponent the bit's number.
                    group = place * WORD + math.frexp(float(bit))[1] - 1
                    if lower < nearest.lowest[group] or nearest.lowest_pair[group] < 0:
                        nearest.lowest[group], nearest.lowest_pair[group] = lower, k
                    if time < nearest.soonest[group] or nearest.soonest_pair[group] < 0:
                        nearest.soonest[group], nearest.soonest_pair[group] = time, k
    return -1


def no_pairs(groups: int) -> NearestPairs:
    """Return uninitialised NearestPairs for so many groups."""
    lowest, soonest = np.empty((2, groups))
    lowest_pair, soonest_pair = np.empty((2, groups), dtype=np.int64)
    return NearestPairs(lowest, lowest_pair, soonest, soonest_pair)


# Accepts arrays of any strides, since copying them took as long as the search.
_FIND = Entry(
    _find,
    *[given(np.int64, 1)] * 2,
    *[given(np.float64, 1)] * 3,
    like(0.0),
    like(_NO_BITS),
    like(no_pairs(0)),
)


def prepare() -> None:
    """Compile the search, or load it from the cache."""
    nearest_pairs(NOTHING, 0.0, _NO_BITS, 0)


def nearest_pairs(measured: Measured, farthest: float, bits: SetBits, groups: int) -> NearestPairs:
    """Return the nearest pair of each group, without pairs certainly beyond ``farthest`` [m].

    Raises ValueError for a pair with a geometry that ``bits`` lacks.
    """
    nearest = no_pairs(groups)
    speeds = _NO_SPEEDS if measured.closing_speed is None else measured.closing_speed
    ids = [np.asarray(each, dtype=np.int64) for each in (measured.id_A, measured.id_B)]
    columns = measured.distance, measured.error_bound, speeds
    numbers = [np.asarray(column, dtype=np.float64) for column in columns]
    unknown = _FIND.call(*ids, *numbers, farthest, bits, nearest)
    if unknown >= 0:
        pair = int(measured.id_A[unknown]), int(measured.id_B[unknown])
        raise ValueError(f'pair {pair} is not of the scene that these rules watch')
    return nearest
