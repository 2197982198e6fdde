"""Sensed maps in the live scene: each one geometry on a frame of the source ``obstacles``.

A map waits for its first message as any frame does for its first pose: its pairs are left out and
counted. Its age is that of its frame's pose, so results, diagnostics and rules know it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drake_geom_ros.geometry import (
    ArgumentError,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    ProximityProperties,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.live.scene.clocks import ALWAYS, Since
from drake_geom_ros.live.scene.editable_scene import EditableScene
from drake_geom_ros.live.scene.feeders import OBSTACLES
from drake_geom_ros.live.scene.held_scene import MAPS, HeldScene, SeenMap
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_sources import MapSources
from drake_geom_ros.live.scene.out_of_sight import Sight
from drake_geom_ros.live.scene.scene_draft import SceneDraft
from drake_geom_ros.live.scene.seen_shells import NO_SHELL, SeenShell
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import SceneDescription
from drake_geom_ros.sensed_maps import Cells

GEOMETRY = 'map'
_MANY_CELLS = 20_000  # of which a cycle may not wait for the tables
_MARGIN = ('map', 'margin')  # of the geometry, by which each cell is larger on every side


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


_NAMED_AS_MAPS = (
    f'the scene has a source {MAPS!r}, which is what that of sensed maps is called; give it '
    'another name, or remove it'
)


def stand(scene: EditableScene, name: str, margin: float = 0.0) -> SeenMap:
    """Return a map of the scene; one that is not there is registered, and waits.

    Raises ArgumentError where the scene has a source of its own that is called as that of maps.
    """
    existing = scene.maps.get(name)
    if existing is not None:
        return existing
    graph = scene.scene_graph
    source = scene.maps_source
    if source is None:
        if MAPS in map(scene.inspector.GetName, scene.inspector.GetAllSourceIds()):
            raise ArgumentError(_NAMED_AS_MAPS)
        source = scene.maps_source = graph.RegisterSource(MAPS)
    frame = graph.RegisterFrame(source, GeometryFrame(name))
    # Nobody sees it: the frame has no pose.
    some = OccupiedCells(1.0, np.zeros((1, 3)))
    instance = GeometryInstance(RigidTransform(), some, GEOMETRY)
    properties = ProximityProperties()
    if margin:
        properties.AddProperty(*_MARGIN, margin)
    instance.set_proximity_properties(properties)
    geometry = graph.RegisterGeometry(source, frame, instance)
    graph.collision_filter_manager().WeldToWorld([frame])
    seen_map = SeenMap(frame, geometry, None)
    scene.maps[name] = seen_map
    return seen_map


def begin_with_maps(
    scene: EditableScene,
    description: SceneDescription | None,
    names: Sequence[str],
    margin: float = 0.0,
) -> tuple[int, int]:
    """Add maps that wait, and then what a file describes; return frames, geometries of the file.

    The maps come first, because proximity rules of the file may be about them. Raises
    ArgumentError where the file has a source that is called as that of maps.
    """
    if names and description is not None and MAPS in description.sources:
        raise ArgumentError(_NAMED_AS_MAPS)
    for name in names:
        stand(scene, name, margin)
    return (0, 0) if description is None else scene.add(description)


def stand_fed(scene: EditableScene, sources: MapSources) -> None:
    """Have a scene hold the maps that topics feed where they have gone; they wait then."""
    for name, feeder in sources.fed.items():
        if name not in scene.maps:
            feeder.forget()
            stand(scene, name, sources.margin)


def rehearse(graph: SceneGraph, context: SceneGraphContext, shape: OccupiedCells) -> None:
    """Do on a copy of the scene what ``put`` will, for what takes long to be done then."""
    source = graph.RegisterSource(context=context, name='')
    frame = graph.RegisterFrame(context=context, source_id=source, frame=GeometryFrame(GEOMETRY))
    instance = GeometryInstance(RigidTransform(), shape, GEOMETRY)
    instance.set_proximity_properties(ProximityProperties())
    graph.RegisterGeometry(context=context, source_id=source, frame_id=frame, geometry=instance)


def drafted(live: LiveScene, name: str, sighting: Sighting) -> SceneDraft | None:
    """Return a draft of the scene in which a map has another shape; None: that is soon done."""
    with live.reading() as scene:
        known = scene.maps.get(name)
        if known is None or not (scene.is_large or len(sighting.cells) > _MANY_CELLS):
            return None
        draft = SceneDraft(scene)
        source = scene.inspector.GetOwningSourceId(known.frame)
    graph = SceneGraph()
    graph.ChangeShape(draft.context, source, known.geometry, sighting.shape)
    draft.get_ready(live.rehearse, live.tell_compiling)
    return draft


def put(
    scene: EditableScene,
    name: str,
    sighting: Sighting,
    margin: float = 0.0,
    draft: SceneDraft | None = None,
) -> None:
    """Let a map hold what was seen, in place of all that it held.

    A ``draft`` of a scene that has not changed since has the shape already.
    """
    seen_map = stand(scene, name, margin)
    graph, frame = scene.scene_graph, seen_map.frame
    before = scene.version
    if draft is None or not scene.take_over(draft):
        source = scene.inspector.GetOwningSourceId(frame)
        graph.ChangeShape(source, seen_map.geometry, sighting.shape)
    scene.map_changes += scene.version - before
    poses = FramePoseVector({frame: sighting.X_WM})
    posed = {frozenset([frame.get_value()]): sighting.since}
    scene.pose(poses, posed, sighting.stamp, OBSTACLES)
    # What stands in the world and what was seen of it are both at rest, wherever that is.
    if frame not in graph.collision_filter_manager().welded_frames():
        graph.collision_filter_manager().WeldToWorld([frame])
    scene.maps[name] = SeenMap(
        frame,
        seen_map.geometry,
        *(sighting.cells, sighting.shell, sighting.feeds, sighting.sights),
    )


def forget(scene: EditableScene, names: list[str], again: list[str], margin: float = 0.0) -> int:
    """Forget what maps hold, and return how many cells that was; those of ``again`` wait then.

    The others stay what they are, by their ids, too.
    """
    gone = sum(len(scene.maps[n].cells or ()) for n in names if n in scene.maps)
    scene.remove_maps(names)
    for name in again:
        stand(scene, name, margin)
    return gone


def sensor_ages(scene: HeldScene) -> dict[str, float]:
    """Return the age [s] of what each sensor showed, of the maps that several feed, by words."""
    several = {
        name: seen_map.feeds for name, seen_map in scene.maps.items() if len(seen_map.feeds) > 1
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
    for name, seen_map in scene.maps.items():
        since = scene.posed_since(seen_map.frame)
        if since is None or seen_map.cells is None:
            ages[name] = math.inf
        else:
            ages[name] = 0.0 if since == ALWAYS else scene.clocks.age(since)
    return ages
