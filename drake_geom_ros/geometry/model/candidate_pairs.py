"""``CandidatePairs``: the pairs of a scene that pairwise queries consider, without a matrix."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.math.array_types import Flags

Ids = NDArray[np.int64]
_BLOCK = 2**20  # pairs that are in memory at once
_NO_ROW = -1


class CandidatePairs:
    """The pairs of geometries that may be reported, as they were when this object was made.

    It takes memory for each geometry, and for each one with a filter a bit for all others, where
    a matrix of all pairs of 16 000 geometries takes 256 MB.
    """

    def __init__(
        self, ids: Ids, bodies: Ids, row_of: Ids, columns: Ids, excluded: NDArray[np.uint8]
    ) -> None:
        """``ids`` (n,) are ascending; pairs of equal ``bodies`` (n,), or of one below 0, are out.

        Row ``row_of[i]`` of the packed bits ``excluded`` has bit ``columns[j]`` set where a filter
        excludes the pair (i, j); a geometry without filters has row -1.
        """
        self.ids = ids
        self._bodies, self._row_of, self._columns = bodies, row_of, columns
        self._excluded = excluded

    @classmethod
    def of_filters(cls, filters: FilterState) -> CandidatePairs:
        """Return the pairs that the filters of a scene leave."""
        ids, slots = filters.table()
        bits, bodies, bit_rows = filters.matrix
        rows = bit_rows[slots]
        with_row = rows >= 0
        row_of = np.full(len(ids), _NO_ROW, dtype=np.int64)
        row_of[with_row] = np.arange(np.count_nonzero(with_row))
        return cls(ids, bodies[slots], row_of, slots, bits[-1, rows[with_row]])

    @classmethod
    def of_all(cls, ids: Ids) -> CandidatePairs:
        """Return all pairs of geometries, for programs that know of no filters."""
        count = len(ids)
        every, no_rows = np.arange(count), np.full(count, _NO_ROW, dtype=np.int64)
        return cls(ids, every, no_rows, every, np.zeros((0, 0), dtype=np.uint8))

    def matches(self, other: CandidatePairs) -> bool:
        """Return whether another object is about the same geometries, and the same pairs."""
        return all(
            np.array_equal(own, others)
            for own, others in zip(self._parts, other._parts, strict=True)
        )

    @property
    def _parts(self) -> tuple[NDArray[np.generic], ...]:
        return self.ids, self._bodies, self._row_of, self._columns, self._excluded

    def rows(self, places: Ids) -> Flags:
        """Return the rows (k, n) of the symmetric matrix of pairs at some places (k,) of ids."""
        return self._block(places, np.arange(len(self.ids)))

    def matrix(self) -> Flags:
        """Return the symmetric matrix (n, n) of pairs."""
        return self.rows(np.arange(len(self.ids)))

    def partners(self, of: Flags, among: Flags) -> Ids:
        """Return the number of candidates ``among`` some geometries (n,) for each of others (n,).

        It is 0 for those that are not among these. Takes time for each pair of the two sets whose
        geometry of the first one has filters.
        """
        is_active = self._bodies >= 0
        of, among = of & is_active, among & is_active
        in_bodies = np.bincount(self._body_of, weights=among)
        counts = np.where(of, in_bodies.sum() - in_bodies[self._body_of], 0.0).astype(np.int64)
        filtered, columns = np.flatnonzero(of & (self._row_of != _NO_ROW)), np.flatnonzero(among)
        step = max(1, _BLOCK // max(1, len(columns)))
        for first in range(0, len(filtered), step):
            places = filtered[first : first + step]
            counts[places] = self._block(places, columns).sum(axis=1)
        return counts

    def _block(self, places: Ids, columns: Ids) -> Flags:
        """Return the pairs of some places (k,) and others (m,) as a matrix (k, m)."""
        own, others = self._bodies[places, np.newaxis], self._bodies[columns]
        flags: Flags = (own != others) & (others >= 0) & (own >= 0)
        filtered = np.flatnonzero(self._row_of[places] != _NO_ROW)
        if len(filtered):
            rows, at = self._row_of[places[filtered], np.newaxis], self._columns[columns]
            bits = self._excluded[rows, at >> 3] >> (at & 7).astype(np.uint8)
            flags[filtered] &= bits & 1 == 0
        return flags

    @cached_property
    def _body_of(self) -> Ids:
        """The number of the body of each geometry (n,), from 0 on."""
        return np.unique(self._bodies, return_inverse=True)[1].ravel()
