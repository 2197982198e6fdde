"""Sensed maps that come, and wait for their first message, or go."""

from __future__ import annotations

from collections.abc import Collection

from drake_geom_ros.geometry import ArgumentError, SceneGraph, SceneGraphContext
from drake_geom_ros.live.conversions.names import MAPS
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.waiting_maps import NAMED_AS_MAPS, WaitingMaps, waiting_maps


def standing_maps(
    scene: HeldScene, gone: Collection[str], waiting: Collection[str], margin: float = 0.0
) -> Change[HeldScene, int]:
    """Return a change after which maps are ``gone`` and others are ``waiting``.

    Its result is the number of cells that were in those that are gone. With the last map its
    source goes; all other maps stay. Raises ArgumentError where the scene has a source of its own
    that is called as that of maps.
    """
    source, maps, inspector = scene.model.maps_source, scene.maps.by_name, scene.model.inspector
    frames = [maps[name].frame for name in gone if name in maps]
    stay = [name for name in maps if name not in gone]
    new = [name for name in waiting if name not in stay]
    others = map(inspector.GetName, inspector.GetAllSourceIds())
    if source is None and new and MAPS in others:
        raise ArgumentError(NAMED_AS_MAPS)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> WaitingMaps:
        if source is not None:
            for frame in frames:
                graph.RemoveFrame(context=context, source_id=source, frame_id=frame)
            if not stay and not new:
                graph.RemoveSource(context=context, source_id=source)
        if not stay and not new:
            return WaitingMaps(None, {})
        return waiting_maps(graph, context, source, new, margin)

    def then(scene: HeldScene, made: WaitingMaps) -> int:
        maps = scene.maps.by_name
        cells = sum(len(maps[name].cells or ()) for name in gone if name in maps)
        if frames:
            scene.forget_source(MAPS, frames)
        there = {name: seen_map for name, seen_map in maps.items() if name in stay}
        scene.maps.by_name = {**there, **made.maps}
        return cells

    return Change(on, then=then, maps_source=lambda made: made.source)
