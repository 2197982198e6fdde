"""Declared bodies that come and go, such as a person by TF frames.

A frame with ``gone_after`` that no message names for so long leaves: it waits for a pose again,
which nobody misses, and its geometries are in no pair. Frames of one source leave together, when
none of them is named any more, and come back together: a hand that is hidden while the head is
seen is stale, and does not leave.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping

from drake_geom_ros.geometry import (
    CollisionFilterManager,
    FrameId,
    GeometrySet,
    Role,
    SceneGraph,
    SceneGraphContext,
    SourceId,
)
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.clocks import Clocks, Heard
from drake_geom_ros.live.scene.scene_log import SceneLog
from drake_geom_ros.live.scene.scene_model import SceneModel


class SceneVisitors:
    """Frames that may leave, with the time at which each was named last; some are ``absent``.

    Frames are the values of their ids.
    """

    def __init__(self, model: SceneModel, clocks: Clocks, log: SceneLog) -> None:
        self._model, self._clocks, self._log = model, clocks, log
        self.begin_anew()

    def begin_anew(self) -> None:
        """Know of no frame that may leave."""
        self.absent: frozenset[int] = frozenset()
        self.gone_after: dict[int, float] = {}
        self._named: dict[int, Heard] = {}
        self._inactive: dict[SourceId, GeometrySet] = {}  # what is in no pair since it left

    def begin(self, gone_after: Mapping[FrameId, float]) -> None:
        """Know of frames that may leave [s]; none has been named yet."""
        for frame, seconds in gone_after.items():
            self.gone_after[frame.get_value()] = seconds
            self._named[frame.get_value()] = self._clocks.heard()

    def forget(self, frames: Iterable[int]) -> None:
        """Forget frames that were removed."""
        for value in frames:
            self.gone_after.pop(value, None)
            self._named.pop(value, None)
        self.absent = self.absent.intersection(self.gone_after)

    def name(self, frames: Collection[int]) -> set[int]:
        """Note that a message named frames; return those that come back with them."""
        here = self.gone_after.keys() & frames
        self._named.update(dict.fromkeys(here, self._clocks.heard()))
        if not self.absent.intersection(here):
            return set()
        groups = self._by_source()
        coming = [s for s, group in groups.items() if self.absent.intersection(here, group)]
        for source in coming:
            self._model.filter_manager.Activate(self._inactive.pop(source))
            self._log.notes.append(f'{self._in_words(groups[source])} came back')
        back = {value for source in coming for value in groups[source]}
        self.absent = self.absent.difference(back)
        self._named.update(dict.fromkeys(back, self._clocks.heard()))
        return back

    def leave(self, stale_after: float, stays: Callable[[int], bool]) -> list[int]:
        """Let sources leave of which no frame was named for too long; return their frames.

        None leaves before it is stale, so ``stale_after`` [s] at least, nor where a frame
        ``stays``. The node's clock counts, by which senders stamp: while simulated time rests,
        nobody leaves. After a jump of that clock the time begins anew.
        """
        if len(self.absent) == len(self.gone_after):
            return []
        now = self._clocks.heard()
        before_jump = [value for value, heard in self._named.items() if heard.epoch != now.epoch]
        self._named.update(dict.fromkeys(before_jump, now))

        def is_silent(value: int) -> bool:
            limit = max(self.gone_after[value], stale_after)
            return now.time - self._named[value].time > limit and not stays(value)

        left: list[int] = []
        for source, group in self._by_source().items():
            if self.absent.isdisjoint(group) and all(map(is_silent, group)):
                self._deactivate(source, group)
                left += group
        self.absent = self.absent.union(left)
        return left

    def activate_all(self, context: SceneGraphContext) -> None:
        """Have all geometries of absent frames be in pairs in a copy of the scene."""
        manager = SceneGraph().collision_filter_manager(context)
        for inactive in self._inactive.values():
            manager.Activate(inactive)

    def in_words(self) -> str:
        """Return who is absent; empty where all are here."""
        return self._in_words(self.absent)

    def _deactivate(self, source: SourceId, group: Collection[int]) -> None:
        manager: CollisionFilterManager = self._model.filter_manager
        before = set(manager.deactivated_geometries())
        inactive = GeometrySet(
            geometry_ids=[
                geometry
                for value in group
                for geometry in self._model.inspector.GetGeometries(
                    FrameId(value), Role.kProximity
                )
                if geometry not in before
            ]
        )
        manager.Deactivate(inactive)
        self._inactive[source] = inactive
        seconds = max(self.gone_after[value] for value in group)
        self._log.notes.append(
            f'{self._in_words(group)} left: no message named it for {seconds:g} s (gone_after)'
        )

    def _by_source(self) -> dict[SourceId, list[int]]:
        groups = defaultdict[SourceId, list[int]](list)
        for value in self.gone_after:
            groups[self._model.inspector.GetOwningSourceId(FrameId(value))].append(value)
        return groups

    def _in_words(self, frames: Collection[int]) -> str:
        names = self._model.names.frame_names
        return some_of(sorted(names[FrameId(value)] for value in frames))
