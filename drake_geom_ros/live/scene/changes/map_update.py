"""The change that puts cells in the place of those of a sensed map."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drake_geom_ros.geometry import FramePoseVector, OccupiedCells, SceneGraph, SceneGraphContext
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.clocks import Since
from drake_geom_ros.live.scene.feeders import OBSTACLES
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.out_of_sight import Sight
from drake_geom_ros.live.scene.scene_maps import SeenMap
from drake_geom_ros.live.scene.seen_shells import NO_SHELL, SeenShell
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.sensed_maps import Cells

_MANY_CELLS = 20_000  # of which a cycle may not wait for the tables


@dataclass(frozen=True)
class Sighting:
    """The content of a map: cells in its frame M, as a shape, and since when they hold."""

    cells: Cells
    shape: OccupiedCells
    X_WM: RigidTransform
    since: Since
    stamp: Any  # builtin_interfaces/Time; None: of no message
    shell: SeenShell = NO_SHELL
    feeds: tuple[tuple[str, Since], ...] = ()  # sensors, and since when what each showed holds
    sights: tuple[Sight, ...] = ()  # of each of them
    # (n, 3) [m] centres of cells that bodies hide from their sensor, in the world.
    hidden: Floats = field(default_factory=lambda: np.zeros((0, 3)))


def shape_of(cells: Cells, margin: float) -> OccupiedCells:
    """Return cells as a shape, which takes long for many: hold no scene meanwhile."""
    shape = OccupiedCells(cells.resolution, cells.centres())
    shape.prepare(margin)
    return shape


def showing(
    scene: HeldScene,
    name: str,
    sighting: Sighting,
    first: Callable[[HeldScene], object] = lambda scene: None,
    done: Callable[[], object] = lambda: None,
) -> Change[HeldScene, None]:
    """Return the change after which a map of the scene holds what was seen, and nothing else.

    ``first`` raises RuntimeError where that is not to be any more; ``done`` is called with the
    scene held.
    """
    seen_map = scene.maps.by_name[name]
    frame = seen_map.frame
    source = scene.model.inspector.GetOwningSourceId(frame)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.ChangeShape(
            context=context,
            source_id=source,
            geometry_id=seen_map.geometry,
            shape=sighting.shape,
        )

    def then(scene: HeldScene, _: None) -> None:
        poses = FramePoseVector({frame: sighting.X_WM})
        posed = {frozenset([frame.get_value()]): sighting.since}
        scene.poses.pose(poses, posed, sighting.stamp, OBSTACLES)
        # What stands in the world and what was seen of it are both at rest, wherever that is.
        manager = scene.model.filter_manager
        if frame not in manager.welded_frames():
            manager.WeldToWorld([frame])
        held = sighting.cells, sighting.shell, sighting.feeds, sighting.sights, sighting.hidden
        scene.maps.by_name[name] = SeenMap(frame, seen_map.geometry, *held)
        done()

    return Change(on, first, then, same_content=True)


def has_many(cells: Cells) -> bool:
    """Return whether a cycle may not wait for the tables of cells."""
    return len(cells) > _MANY_CELLS
