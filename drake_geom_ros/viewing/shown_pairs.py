"""Pairs for display, nearest first, with lines, points and texts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import SignedDistanceResults
from drake_geom_ros.math.array_types import Floats

_MILLIMETRE = 1000.0


@dataclass(frozen=True, eq=False)
class ReportedPairs:
    """Reported pairs, the deepest or nearest first.

    ``ids`` (k, 2) are geometries A and B, ``distance`` and ``error_bound`` (k,) [m],
    ``p_WCas`` and ``p_WCbs`` (k, 3) [m] the witnesses, ``nhat_BA_Ws`` (k, 3) the normals.
    """

    ids: NDArray[np.int64]
    distance: Floats
    error_bound: Floats
    p_WCas: Floats
    p_WCbs: Floats
    nhat_BA_Ws: Floats

    @classmethod
    def of(cls, results: SignedDistanceResults) -> ReportedPairs:
        """Return the pairs of a query."""
        ids = np.stack([results.id_A, results.id_B], axis=1)
        return cls(
            *(ids, results.distance, results.error_bound),
            *(results.p_WCa, results.p_WCb, results.nhat_BA_W),
        ).sorted()

    @classmethod
    def none(cls) -> ReportedPairs:
        """Return no pairs."""
        points, numbers = np.zeros((0, 3)), np.zeros(0)
        return cls(np.zeros((0, 2), np.int64), numbers, numbers, points, points, points)

    def sorted(self) -> ReportedPairs:
        """Return the pairs in ascending order of their certified lower bounds."""
        return self.rows(np.argsort(self.distance - self.error_bound, kind='stable'))

    def rows(self, rows: NDArray[np.int64] | slice) -> ReportedPairs:
        """Return the pairs of these rows."""
        return ReportedPairs(
            ids=self.ids[rows],
            distance=self.distance[rows],
            error_bound=self.error_bound[rows],
            p_WCas=self.p_WCas[rows],
            p_WCbs=self.p_WCbs[rows],
            nhat_BA_Ws=self.nhat_BA_Ws[rows],
        )

    def __len__(self) -> int:
        return len(self.ids)

    def find(self, pair: tuple[int, int]) -> int | None:
        """Return the row of a pair of id values, in any order; None if it is absent."""
        rows = np.flatnonzero((self.ids == sorted(pair)).all(axis=1))
        return int(rows[0]) if len(rows) else None

    def segments(self) -> Floats:
        """Return the lines (k, 2, 3) [m] between the witnesses."""
        return np.stack([self.p_WCas, self.p_WCbs], axis=1)

    def normals(self, length: float) -> Floats:
        """Return the normals (k, 2, 3) [m] as lines from the witnesses on A, out of B."""
        return np.stack([self.p_WCas, self.p_WCas + length * self.nhat_BA_Ws], axis=1)


def in_words(pairs: ReportedPairs, row: int, *, bounds: bool) -> str:
    """Return a text with the signed distance of a pair [mm], and with ``bounds`` its error [m]."""
    distance = f'{_MILLIMETRE * pairs.distance[row]:.3f} mm'
    return f'{distance} ± {pairs.error_bound[row]:.1e} m' if bounds else distance
