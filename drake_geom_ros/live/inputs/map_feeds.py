"""The sensors that feed one map, by publisher and frame: what each showed last, and their union.

A map that each message replaces as a whole shows one of two sensors at a time: what the other
sees comes and goes, and when that dies the map stays fresh. So each keeps a map of its own, what
is in the scene is the union, and its age is that of the oldest. A driver that is started anew has
another publisher for the same frame: it takes the place of the one before, once that has said
nothing for some messages.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.scene.clocks import Clocks, Since
from drake_geom_ros.live.scene.out_of_sight import Sight
from drake_geom_ros.live.scene.seen_shells import SeenShell, joined
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.sensed_maps.cells import MOST_CELLS, Cells

MOST_FEEDS = 16  # of a map; each costs a map
_REPLACED_AFTER = 3  # messages of a new publisher of a frame, and none of the one before


class Feed(NamedTuple):
    """A sensor that feeds a map: its publisher and frame."""

    frame: str
    publisher: str  # by what the middleware calls it; empty: it tells nothing

    def in_words(self) -> str:
        """Return it in words."""
        return f'frame {self.frame!r}, publisher {self.publisher or "unknown"}'


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


@dataclass
class _Known:
    """The last map of a sensor, and its messages since others of its frame fell silent.

    Those were there before it, and said nothing since it came.
    """

    shown: Shown
    silent: dict[Feed, int] = field(default_factory=dict)


class MapFeeds:
    """The last map of each sensor that feeds one map."""

    def __init__(self, clocks: Clocks) -> None:
        self._clocks = clocks
        self._known: dict[Feed, _Known] = {}

    def __len__(self) -> int:
        return len(self._known)

    def since(self, feed: Feed) -> Since | None:
        """Return since when a sensor's last message holds; None: there was none."""
        record = self._known.get(feed)
        return None if record is None else record.shown.since

    def with_one(self, feed: Feed, shown: Shown) -> MapFeeds:
        """Return these with what a sensor shows now; these stay as they are.

        Raises ArgumentError where there would be too many.
        """
        other = MapFeeds(self._clocks)
        before = self._known.get(feed)
        silent = {old: count + 1 for old, count in before.silent.items()} if before else {}
        if before is None:
            same = (old for old in self._known if old.frame == feed.frame)
            silent = dict.fromkeys(same, 1)
        gone = {old for old, count in silent.items() if count >= _REPLACED_AFTER}
        for each, record in self._known.items():
            if each not in gone:
                waits_for = {f: n for f, n in record.silent.items() if f not in (feed, *gone)}
                other._known[each] = _Known(record.shown, waits_for)
        silent = {f: n for f, n in silent.items() if f in other._known}
        other._known[feed] = _Known(shown, silent)
        if len(other._known) > MOST_FEEDS:
            raise ArgumentError(
                f'it is of {feed.in_words()}, and {MOST_FEEDS} others feed the map; no more are '
                'taken until clear_obstacles'
            )
        return other

    def union(self) -> Shown:
        """Return what all of them show together, as old as the oldest; there is one at least."""
        each = [record.shown for record in self._known.values()]
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

    def sinces(self) -> Iterator[tuple[Feed, Since]]:
        """Yield each sensor, and since when what it showed last holds."""
        for feed, record in self._known.items():
            yield feed, record.shown.since

    def sights(self) -> tuple[Sight, ...]:
        """Return where each sensor can see."""
        return tuple(record.shown.sight for record in self._known.values())

    def ages(self) -> Iterator[tuple[Feed, float]]:
        """Yield each sensor and the age [s] of what it showed last."""
        age = self._clocks.ages()
        for feed, since in self.sinces():
            yield feed, age(since)
