"""Sensed maps in the live scene: each one geometry on a frame of the source ``obstacles``.

A map waits for its first message as any frame does for its first pose: its pairs are left out and
counted. Its age is that of its frame's pose, so results, diagnostics and rules know it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.names import MAPS
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.changes.standing_maps import standing_maps
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_sources import MapSources
from drake_geom_ros.live.scene.scene_maps import SeenMap
from drake_geom_ros.live.scene.waiting_maps import NAMED_AS_MAPS
from drake_geom_ros.scene_files import SceneDescription


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


def clear_maps(live: LiveScene, names: Sequence[str]) -> int:
    """Forget maps of the scene, and return how many cells they had; fed ones wait again."""
    sources = live.map_sources
    fed = [name for name in names if name in sources.fed]
    with live.editing() as scene:
        change = standing_maps(scene, names, fed, sources.margin)

    def first(scene: HeldScene) -> None:
        for name in fed:
            sources.fed[name].forget()

    cells = live.change(replace(change, first=first))
    sources.changed()
    return cells


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
