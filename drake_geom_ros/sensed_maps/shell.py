"""Cells beside bodies that the scene knows: too near to be no part of them, and no free space.

A point farther from a body than the noise of its sensor is not of the body's surface, and within
the padding it may be: of a robot that is not where its joints say, or of what comes close. No
distance is computed with these, and nothing may take them for free. A cell beside a body stays
until the sensor looks past it: what a body hides, or has come too near to be told from, is there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.sensed_maps.cells import Cells, Keys, keys_of
from drake_geom_ros.sensed_maps.keeping import KeptCells

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


class Shell(NamedTuple):
    """Cells, of each a place [m] where something was seen, and when [s] that was."""

    cells: Cells
    places: Floats  # (n, 3)
    seen: Floats  # (n,)

    @classmethod
    def none(cls, resolution: float) -> Shell:
        """Return no cells."""
        return cls(Cells(resolution, np.zeros(0, dtype=np.int64)), np.zeros((0, 3)), np.zeros(0))

    @classmethod
    def of_points(cls, points: Floats, distances: Floats, resolution: float, now: float) -> Shell:
        """Return the cells of points (n, 3) [m]: of each that of the least distance (n,) [m]."""
        if not len(points):  # as of most clouds
            return cls.none(resolution)
        cells = Cells.of_points(points, resolution)  # refuses what is too far away for keys
        order = np.argsort(distances, kind='stable')
        _, firsts = np.unique(keys_of(points[order], resolution), return_index=True)
        return cls(cells, points[order[firsts]], np.full(len(cells), now))

    @classmethod
    def of_map(cls, kept: KeptCells) -> Shell:
        """Return the cells of a map, each seen at its centre."""
        return cls(kept.cells, kept.cells.centres(), kept.seen)

    def as_seen_at(self, now: float) -> Shell:
        """Return these cells as if something was seen in each at ``now`` [s]."""
        return self._replace(seen=np.full(len(self.seen), now))

    def among(self, flags: Flags) -> Shell:
        """Return the cells (n,) that are flagged."""
        cells = Cells(self.cells.resolution, self.cells.packed[flags])
        return Shell(cells, self.places[flags], self.seen[flags])

    def without(self, packed: Keys) -> Shell:
        """Return the cells but those of ascending keys."""
        return self.among(~_are_in(self.cells.packed, packed))

    def and_others(self, other: Shell) -> Shell:
        """Return these cells and those of another one that are not of these."""
        more = other.without(self.cells.packed)
        packed = np.concatenate([self.cells.packed, more.cells.packed])
        order = np.argsort(packed, kind='stable')
        return Shell(
            Cells(self.cells.resolution, packed[order]),
            np.concatenate([self.places, more.places])[order],
            np.concatenate([self.seen, more.seen])[order],
        )

    @property
    def reach(self) -> float:
        """How far [m] a point in a cell is from its centre at most."""
        return 0.5 * math.sqrt(3.0) * self.cells.resolution


def _are_in(packed: Keys, others: Keys) -> Flags:
    """Return which keys (n,) are among others, which ascend."""
    if not len(others):
        return np.zeros(len(packed), dtype=np.bool_)
    places = np.minimum(np.searchsorted(others, packed), len(others) - 1)
    return np.asarray(others[places] == packed)
