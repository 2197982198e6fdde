"""Shells: sensed cells close to bodies of the scene, which are neither body nor free space.

A point farther from a body than the noise of its sensor is not on the body's surface. Within the
padding it may still belong to the body, such as a robot that is not where its joints say, or to
an approaching object. No distance uses such points, and they must not count as free. A cell of a
shell stays until the sensor looks past it, since a body may hide or touch the object.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.sensed_maps.cells import Cells, Keys, keys_of
from drake_geom_ros.sensed_maps.keeping import KeptCells


class Shell(NamedTuple):
    """Cells with a seen point [m] in each, and the time [s] when it was seen."""

    cells: Cells
    places: Floats  # (n, 3)
    seen: Floats  # (n,)

    @classmethod
    def none(cls, resolution: float) -> Shell:
        """Return no cells."""
        return cls(Cells(resolution, np.zeros(0, dtype=np.int64)), np.zeros((0, 3)), np.zeros(0))

    @classmethod
    def of_points(cls, points: Floats, distances: Floats, resolution: float, now: float) -> Shell:
        """Return the cells of points (n, 3) [m], each with the point of least distance (n,)."""
        if not len(points):  # the common case
            return cls.none(resolution)
        cells = Cells.of_points(points, resolution)  # raises for points beyond the grid
        order = np.argsort(distances, kind='stable')
        _, firsts = np.unique(keys_of(points[order], resolution), return_index=True)
        return cls(cells, points[order[firsts]], np.full(len(cells), now))

    @classmethod
    def of_map(cls, cells: KeptCells) -> Shell:
        """Return the cells of a map, each seen at its centre."""
        return cls(cells.cells, cells.cells.centres(), cells.seen)

    def as_seen_at(self, now: float) -> Shell:
        """Return these cells with all times set to ``now`` [s]."""
        return self._replace(seen=np.full(len(self.seen), now))

    def among(self, flags: Flags) -> Shell:
        """Return the flagged cells, by a mask (n,)."""
        cells = Cells(self.cells.resolution, self.cells.packed[flags])
        return Shell(cells, self.places[flags], self.seen[flags])

    def without(self, packed: Keys) -> Shell:
        """Return the cells without those of ascending ``packed`` keys."""
        return self.among(~_are_in(self.cells.packed, packed))

    def and_others(self, other: Shell) -> Shell:
        """Return the union with another shell; shared cells keep the values of this one."""
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
        """Greatest distance [m] of a point in a cell to its centre."""
        return 0.5 * math.sqrt(3.0) * self.cells.resolution


def _are_in(packed: Keys, others: Keys) -> Flags:
    """Return a mask (n,) of the keys that are among ascending ``others``."""
    if not len(others):
        return np.zeros(len(packed), dtype=np.bool_)
    places = np.minimum(np.searchsorted(others, packed), len(others) - 1)
    return np.asarray(others[places] == packed)
