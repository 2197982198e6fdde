"""The sensors that feed one map, by publisher and frame: what each showed last, and their union.

A map that each message replaces as a whole shows one of two sensors at a time: what the other
sees comes and goes, and when that dies the map stays fresh. So each keeps a map of its own, what
is in the scene is the union, and its age is that of the oldest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.scene.clocks import Since
from drake_geom_ros.live.scene.feeds import Feed, Feeds
from drake_geom_ros.live.scene.out_of_sight import Sight
from drake_geom_ros.live.scene.seen_shells import SeenShell, joined
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.sensed_maps.cells import MOST_CELLS, Cells


class Shown(NamedTuple):
    """The last map of one sensor."""

    cells: Cells  # in a frame M
    X_WM: RigidTransform
    shell: SeenShell
    since: Since
    sight: Sight
    hidden: Floats = np.zeros((0, 3))  # (n, 3) [m] centres of cells that bodies hide, in the world

    def in_world(self) -> Cells:
        """Return cells of the world's grid that cover these."""
        if self.X_WM.IsExactlyIdentity():
            return self.cells
        return self.cells.moved(self.X_WM.rotation().matrix(), self.X_WM.translation())


class MapFeeds(Feeds[Shown]):
    """The last map of each sensor that feeds one map."""

    what, cleared_by = 'the map', 'clear_obstacles'

    def with_one(self, feed: Feed, shown: Shown) -> MapFeeds:
        """Return these with what a sensor shows now; these stay as they are.

        Raises ArgumentError where there would be too many.
        """
        return self.with_message(feed, shown, shown.since)

    def union(self) -> Shown:
        """Return what all of them show together, as old as the oldest; there is one at least."""
        each = [record.shown for record in self._fed.values()]
        if len(each) == 1:
            return each[0]
        oldest = max((one.since for one in each), key=self._clocks.ages())
        cells = [one.in_world() for one in each]
        resolution = max(some.resolution for some in cells)
        same = [c if c.resolution == resolution else c.coarser(resolution) for c in cells]
        packed = np.unique(np.concatenate([some.packed for some in same]))
        if len(packed) > MOST_CELLS:
            raise ArgumentError(
                f'the map would have {len(packed)} cells; it may have {MOST_CELLS}'
            )
        shell = joined([one.shell for one in each])
        union = Cells(resolution, packed)
        hidden = np.concatenate([one.hidden for one in each])
        return Shown(union, RigidTransform(), shell, oldest, each[0].sight, hidden)

    def sights(self) -> tuple[Sight, ...]:
        """Return where each sensor can see."""
        return tuple(record.shown.sight for record in self._fed.values())
