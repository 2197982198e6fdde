"""The nearest pair of each group of rules, compiled: one pass over what a cycle measured.

NumPy took a tenth of the whole cycle for it, of one rule as of twenty (``bench/costs``).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.compiling import Entry, given, like
from drake_geom_ros.proximity_rules.measured import Measured

Floats = NDArray[np.float64]
Ids = NDArray[np.int64]
Words = NDArray[np.uint64]
WORD = 64  # bits
_NO_SPEEDS, _NO_IDS = np.empty(0), np.empty(0, dtype=np.int64)
_NO_WORDS = np.empty((1, 0), dtype=np.uint64)


class SetBits(NamedTuple):
    """In which groups' sets geometries are, as bits in words of 64 groups.

    Of the first sets most geometries have few words with any bit: those alone, one geometry's
    after the other's.
    """

    ids: Ids  # (n,) of the geometries, ascending
    begins_a: Ids  # (n + 1,) where those of each geometry begin
    places_a: Ids  # which word of its row each is
    words_a: Words
    words_b: Words  # (n, w)


class NearestPairs(NamedTuple):
    """Of each group (g,): its least lower bound and time to contact, and the pairs that have them.

    inf and -1 where it has no pair.
    """

    lowest: Floats  # [m]
    lowest_pair: Ids  # the first of several
    soonest: Floats  # [s]
    soonest_pair: Ids

    def of(self, groups: Ids) -> NearestPairs:
        """Return those of groups (r,)."""
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
    found: NearestPairs,
) -> int:
    """Fill ``found`` by the pairs (k,) whose lower bound is at most ``farthest``.

    No closing speeds: nobody watches. Returns a pair that has a geometry which is not of ``bits``;
    -1: there is none.
    """
    for group in range(len(found.lowest)):
        found.lowest[group], found.soonest[group] = math.inf, math.inf
        found.lowest_pair[group], found.soonest_pair[group] = -1, -1
    ids, last = bits.ids, len(bits.ids) - 1
    for k in range(len(id_As)):
        lower = distances[k] - error_bounds[k]
        if math.isnan(lower):  # a doubt, and no rule may take it for free
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
                    if lower < found.lowest[group] or found.lowest_pair[group] < 0:
                        found.lowest[group], found.lowest_pair[group] = lower, k
                    if time < found.soonest[group] or found.soonest_pair[group] < 0:
                        found.soonest[group], found.soonest_pair[group] = time, k
    return -1


def no_pairs(groups: int) -> NearestPairs:
    """Return room for what is found of so many groups."""
    lowest, soonest = np.empty((2, groups))
    lowest_pair, soonest_pair = np.empty((2, groups), dtype=np.int64)
    return NearestPairs(lowest, lowest_pair, soonest, soonest_pair)


# Of pairs whose arrays are of any strides: to copy them took as long as to look at them.
_FIND = Entry(
    _find,
    *[given(np.int64, 1)] * 2,
    *[given(np.float64, 1)] * 3,
    like(0.0),
    like(SetBits(_NO_IDS, _NO_IDS, _NO_IDS, _NO_WORDS[0], _NO_WORDS)),
    like(no_pairs(0)),
)


def nearest_pairs(measured: Measured, farthest: float, bits: SetBits, groups: int) -> NearestPairs:
    """Return the nearest pairs of groups, of those that are not surely beyond ``farthest`` [m].

    Raises ValueError for a pair that has a geometry which is not of ``bits``.
    """
    found = no_pairs(groups)
    speeds = _NO_SPEEDS if measured.closing_speed is None else measured.closing_speed
    ids = [np.asarray(each, dtype=np.int64) for each in (measured.id_A, measured.id_B)]
    columns = measured.distance, measured.error_bound, speeds
    numbers = [np.asarray(column, dtype=np.float64) for column in columns]
    unknown = _FIND.call(*ids, *numbers, farthest, bits, found)
    if unknown >= 0:
        pair = int(measured.id_A[unknown]), int(measured.id_B[unknown])
        raise ValueError(f'pair {pair} is not of the scene that these rules watch')
    return found
