"""The sensed maps of the live scene: what is known of each, and of all."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError, FrameId, GeometryId, SourceId
from drake_geom_ros.live.conversions.names import MAPS, TRACKED
from drake_geom_ros.live.scene.clocks import Clocks, Since
from drake_geom_ros.live.scene.out_of_sight import MapSights, Sight
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.live.scene.scene_rules import Blind, SceneRules
from drake_geom_ros.live.scene.seen_shells import (
    NO_SHELL,
    NOTHING_BESIDE,
    BesideBodies,
    SeenShell,
    beside_bodies,
)
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import ObstacleSource
from drake_geom_ros.sensed_maps import Cells


class SeenMap(NamedTuple):
    """A sensed map of the scene, and the cells that it holds; None before the first message."""

    frame: FrameId
    geometry: GeometryId
    cells: Cells | None
    shell: SeenShell = NO_SHELL
    feeds: tuple[tuple[str, Since], ...] = ()  # sensors, and since when what each showed holds
    sights: tuple[Sight, ...] = ()  # of each of them
    hidden: Floats = np.zeros((0, 3))  # (n, 3) [m] centres of cells that bodies hide, in the world


class AgeLimit(NamedTuple):
    """When a map is stale, and whether rules about it are stale with it."""

    timeout: float | None  # [s] the age from which on; None: as of any pose
    required: bool = True


class SceneMaps:
    """The sensed maps by name, of the source ``SceneModel.maps_source``."""

    def __init__(self, model: SceneModel, rules: SceneRules) -> None:
        self._model, self._rules = model, rules
        self.by_name: dict[str, SeenMap] = {}
        # Called with the scene where the maps that topics feed have gone, to have them again.
        self.stand: Callable[[Any], object] | None = None
        # When each map is stale, where that is not when poses are; those of topics alone.
        self.limits: Mapping[str, AgeLimit] = {}
        # Sources of the scene file, to be saved with it.
        self.sources: tuple[ObstacleSource, ...] = ()
        # The distance [m] to bodies from which on a map that a topic feeds has what is there.
        self.told_apart: Callable[[str], float] = lambda name: 0.0

    def refuse(self, source: SourceId) -> None:
        """Raise ArgumentError for the source of maps or of trackers, which messages change."""
        if source == self._model.maps_source:
            raise ArgumentError(
                f'the source {MAPS!r} holds sensed maps, which only messages of sensors, '
                'load_obstacles and clear_obstacles change; for what is to stand beside them '
                'register a source of another name'
            )
        if self._model.is_tracked(source):
            raise ArgumentError(
                f'the source {TRACKED!r} holds bodies that trackers see, which only their '
                'messages change; for what is to stand beside them register a source of another '
                'name'
            )

    def shells(self) -> list[tuple[GeometryId, SeenShell]]:
        """Return what sensors saw beside bodies, by the map that lacks it."""
        maps = self.by_name.values()
        return [(each.geometry, each.shell) for each in maps if len(each.shell.centres)]

    def beside_bodies(self) -> BesideBodies:
        """Return how many points were seen beside bodies, and how near."""
        if not self.by_name:
            return NOTHING_BESIDE
        return beside_bodies([each.shell for each in self.by_name.values()])

    def sights(self) -> list[MapSights]:
        """Return where sensors can see, of the maps that these feed and that rules need.

        One that is not required may be silent for long, and is no evidence that a body is seen.
        """
        waived = {name for name, limit in self.limits.items() if not limit.required}
        return [
            (each.geometry, each.sights)
            for name, each in self.by_name.items()
            if each.sights and name not in waived
        ]

    def among_stale(
        self, stale: Mapping[int, float], since: Callable[[FrameId], Since | None], clocks: Clocks
    ) -> dict[int, float]:
        """Return the ages [s] of stale frames, of maps with a timeout those that are past it."""
        ages = dict(stale)
        for frame, limit in self._limited():
            if limit.timeout is not None:
                ages.pop(frame.get_value(), None)
                posed = since(frame)
                if posed is not None and (age := clocks.age(posed)) > limit.timeout:
                    ages[frame.get_value()] = age
        return ages

    def among_blind(
        self, unreliable: Blind, since: Callable[[FrameId], Since | None], clocks: Clocks
    ) -> Blind:
        """Return what rules cannot rely on, with maps by their own limits."""
        if not self.limits:
            return unreliable
        stale = self.among_stale(dict.fromkeys(unreliable.stale, math.inf), since, clocks)
        waived = {frame.get_value() for frame, limit in self._limited() if not limit.required}
        return Blind(*(set(frames) - waived for frames in unreliable._replace(stale=stale)))

    def _limited(self) -> Iterator[tuple[FrameId, AgeLimit]]:
        for name, limit in self.limits.items():
            if name in self.by_name:
                yield self.by_name[name].frame, limit

    def finer_rules(self, rule: str = '') -> list[str]:
        """Return in words which rules, or whether this one, are finer than maps can resolve."""
        limits = {
            each.geometry: max(self.told_apart(name), each.cells.resolution if each.cells else 0.0)
            for name, each in self.by_name.items()
        }
        return self._rules.finer_than(limits, rule)
