"""Sensed maps in the live scene: each one geometry on a frame of the source ``obstacles``.

A map waits for its first message as any frame does for its first pose: its pairs are left out and
counted. Its age is that of its frame's pose, so results, diagnostics and rules know it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from drake_geom_ros.geometry import (
    ArgumentError,
    FramePoseVector,
    OccupiedCells,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.changes.standing_maps import standing_maps
from drake_geom_ros.live.scene.clocks import ALWAYS, Since
from drake_geom_ros.live.scene.feeders import OBSTACLES
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.map_sources import MapSources
from drake_geom_ros.live.scene.out_of_sight import Sight
from drake_geom_ros.live.scene.scene_maps import SeenMap
from drake_geom_ros.live.scene.scene_snapshot import MAPS
from drake_geom_ros.live.scene.seen_shells import NO_SHELL, SeenShell
from drake_geom_ros.live.scene.waiting_maps import NAMED_AS_MAPS
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import SceneDescription
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


def shape_of(cells: Cells, margin: float) -> OccupiedCells:
    """Return cells as a shape, which takes long for many: hold no scene meanwhile."""
    shape = OccupiedCells(cells.resolution, cells.centres())
    shape.prepare(margin)
    return shape


def stand(scene: HeldScene, name: str, margin: float = 0.0) -> SeenMap:
    """Return a map of the scene; one that is not there is registered, and waits.

    Raises ArgumentError where the scene has a source of its own that is called as that of maps.
    """
    if name not in scene.maps.by_name:
        scene.make(standing_maps(scene, [], [name], margin))
    return scene.maps.by_name[name]


def begin_with_maps(
    scene: HeldScene,
    description: SceneDescription | None,
    names: Sequence[str],
    margin: float = 0.0,
) -> tuple[int, int]:
    """Add maps that wait, and then what a file describes; return frames, geometries of the file.

    The maps come first, because proximity rules of the file may be about them. Raises
    ArgumentError where the file has a source that is called as that of maps.
    """
    if names and description is not None and MAPS in description.sources:
        raise ArgumentError(NAMED_AS_MAPS)
    for name in names:
        stand(scene, name, margin)
    return (0, 0) if description is None else scene.make(addition(description))


def stand_fed(scene: HeldScene, sources: MapSources) -> None:
    """Have a scene hold the maps that topics feed where they have gone; they wait then."""
    for name, feeder in sources.fed.items():
        if name not in scene.maps.by_name:
            feeder.forget()
            stand(scene, name, sources.margin)


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
        held = sighting.cells, sighting.shell, sighting.feeds, sighting.sights
        scene.maps.by_name[name] = SeenMap(frame, seen_map.geometry, *held)
        done()

    return Change(on, first, then, same_content=True)


def has_many(cells: Cells) -> bool:
    """Return whether a cycle may not wait for the tables of cells."""
    return len(cells) > _MANY_CELLS


def sensor_ages(scene: HeldScene) -> dict[str, float]:
    """Return the age [s] of what each sensor showed, of the maps that several feed, by words."""
    several = {
        name: seen_map.feeds
        for name, seen_map in scene.maps.by_name.items()
        if len(seen_map.feeds) > 1
    }
    if not several:  # as of most scenes
        return {}
    age = scene.clocks.ages()
    return {
        f'{name}: {feed}': age(since) for name, feeds in several.items() for feed, since in feeds
    }


def map_ages(scene: HeldScene) -> dict[str, float]:
    """Return the age [s] of what each map holds; inf for one that waits, 0 of a file."""
    ages = {}
    for name, seen_map in scene.maps.by_name.items():
        since = scene.poses.since(seen_map.frame)
        if since is None or seen_map.cells is None:
            ages[name] = math.inf
        else:
            ages[name] = 0.0 if since == ALWAYS else scene.clocks.age(since)
    return ages
