"""The sensed maps of the live scene: what is known of each, and of all."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from drake_geom_ros.geometry import ArgumentError, FrameId, GeometryId, SourceId
from drake_geom_ros.live.scene.clocks import Since
from drake_geom_ros.live.scene.out_of_sight import MapSights, Sight
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.live.scene.scene_rules import SceneRules
from drake_geom_ros.live.scene.scene_snapshot import MAPS
from drake_geom_ros.live.scene.seen_shells import (
    NO_SHELL,
    NOTHING_BESIDE,
    BesideBodies,
    SeenShell,
    beside_bodies,
)
from drake_geom_ros.sensed_maps import Cells


class SeenMap(NamedTuple):
    """A sensed map of the scene, and the cells that it holds; None before the first message."""

    frame: FrameId
    geometry: GeometryId
    cells: Cells | None
    shell: SeenShell = NO_SHELL
    feeds: tuple[tuple[str, Since], ...] = ()  # sensors, and since when what each showed holds
    sights: tuple[Sight, ...] = ()  # of each of them


class SceneMaps:
    """The sensed maps by name, of the source ``SceneModel.maps_source``."""

    def __init__(self, model: SceneModel, rules: SceneRules) -> None:
        self._model, self._rules = model, rules
        self.by_name: dict[str, SeenMap] = {}
        # Called with the scene where the maps that topics feed have gone, to have them again.
        self.stand: Callable[[Any], object] | None = None
        # The distance [m] to bodies from which on a map that a topic feeds has what is there.
        self.told_apart: Callable[[str], float] = lambda name: 0.0

    def refuse(self, source: SourceId) -> None:
        """Raise ArgumentError for the source of the maps, which only messages change."""
        if source == self._model.maps_source:
            raise ArgumentError(
                f'the source {MAPS!r} holds sensed maps, which only messages of sensors, '
                'load_obstacles and clear_obstacles change; for what is to stand beside them '
                'register a source of another name'
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
        """Return where sensors can see, of the maps that these feed."""
        return [(each.geometry, each.sights) for each in self.by_name.values() if each.sights]

    def finer_rules(self, rule: str = '') -> list[str]:
        """Return in words which rules, or whether this one, are finer than maps can resolve."""
        limits = {
            each.geometry: max(self.told_apart(name), each.cells.resolution if each.cells else 0.0)
            for name, each in self.by_name.items()
        }
        return self._rules.finer_than(limits, rule)
