"""Persistence of cells from one cloud to the next, by age and by rays that clear them.

A cloud shows occupied cells. Earlier cells stay for ``keep`` seconds since they last contained a
point, even if one point is too few to make a cell. With rays, cells that the sensor looked
through are removed, since the way from the sensor to a point is free. A ray does not clear the
neighbours of the cell in which it ends, where it may graze the surface that it hit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.sensed_maps.cells import MOST_CELLS, Cells, Keys, MapError, unique_numbers

_STEP = 0.5  # between samples of a ray, in cells; it may miss the corner of a cell, which stays
_MOST_SAMPLES = 2_000_000  # of rays at once


@dataclass(frozen=True)
class KeptCells:
    """Cells with the times [s] when each (n,) last contained a point."""

    cells: Cells
    seen: Floats

    @classmethod
    def none(cls, resolution: float) -> KeptCells:
        """Return no cells."""
        return cls(Cells(resolution, np.zeros(0, dtype=np.int64)), np.zeros(0))

    def without(self, others: Cells) -> KeptCells:
        """Return the cells that are not among others of the same grid."""
        return self.among(~np.isin(self.cells.packed, others.packed, assume_unique=True))

    def among(self, flags: Flags) -> KeptCells:
        """Return the flagged cells, by a mask (n,)."""
        cells = Cells(self.cells.resolution, self.cells.packed[flags])
        return KeptCells(cells, self.seen[flags])

    def as_seen_at(self, now: float) -> KeptCells:
        """Return these cells with all times set to ``now`` [s]."""
        return KeptCells(self.cells, np.full(len(self.seen), now))

    def and_then(
        self,
        new: Cells,
        now: float,
        keep: float,
        free: Keys | None = None,
        sparse: Keys | None = None,
        hidden: Flags | None = None,
        keep_hidden: float = math.inf,
    ) -> KeptCells:
        """Return the cells after a cloud of time ``now`` [s] with cells ``new``.

        ``free`` are packed keys of cells that its rays cleared, and ``sparse`` of cells with
        points, too few to make one, which still refresh it. Flagged cells of these (n,) are
        ``hidden`` from the sensor: they stay, and do not age meanwhile; where ``keep_hidden`` [s]
        is finite they age, and stay until then. Cells of another resolution are dropped. Times
        later than ``now`` become ``now``, since clocks are set back. Raises MapError for more
        cells than a map may have.
        """
        old, seen = self.cells.packed, np.minimum(self.seen, now)
        if new.resolution != self.cells.resolution:
            old, seen, hidden = old[:0], seen[:0], None
        shown = np.zeros(len(old), dtype=np.bool_)
        if sparse is not None:
            shown = np.isin(old, sparse, assume_unique=True)
            seen[shown] = now
        if hidden is not None:
            if math.isfinite(keep_hidden):
                hidden = hidden & (now - seen <= keep_hidden)
            else:
                seen[hidden] = now
        held = now - seen <= keep if math.isfinite(keep) else np.ones(len(seen), dtype=np.bool_)
        held &= ~np.isin(old, new.packed, assume_unique=True)
        if keep <= 0.0:
            held[:] = False
        if free is not None and held.any():
            held &= shown | ~np.isin(old, free)
        if hidden is not None:
            held |= hidden & ~np.isin(old, new.packed, assume_unique=True)
        packed = np.concatenate([old[held], new.packed])
        if len(packed) > MOST_CELLS:
            raise MapError(f'the map would have {len(packed)} cells; it may have {MOST_CELLS}')
        times = np.concatenate([seen[held], np.full(len(new), now)])
        order = np.argsort(packed, kind='stable')
        return KeptCells(Cells(new.resolution, packed[order]), times[order])


def seen_through(origin: Floats, cells: Cells) -> Keys:
    """Return the packed keys of cells that rays from ``origin`` (3,) [m] to cells traverse."""
    centres = cells.centres()
    ways = centres - origin
    lengths = np.linalg.norm(ways, axis=1)
    counts = np.maximum(0, np.floor((lengths / cells.resolution - 2.0) / _STEP)).astype(np.int64)
    key_parts = [np.zeros(0, dtype=np.int64)]
    start = 0
    ends = np.cumsum(counts)
    while start < len(counts):
        done = ends[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(ends, done + _MOST_SAMPLES, side='right')))
        some = counts[start:stop]
        which = np.repeat(np.arange(start, stop), some)
        number = np.arange(len(which)) - np.repeat(np.cumsum(some) - some, some)
        share = number * _STEP * cells.resolution / lengths[which]
        samples = origin + ways[which] * share[:, np.newaxis]
        key_parts.append(Cells.of_points(samples, cells.resolution).packed)
        start = stop
    return unique_numbers(np.concatenate(key_parts))
