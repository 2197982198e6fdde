"""Services about sensed maps and their sensors: the live scene, a request, a response."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.request_types import (
    AddObstacleSourceRequest,
    ClearObstaclesRequest,
    EmptyRequest,
    LoadObstaclesRequest,
    NamedRequest,
    SaveObstaclesRequest,
)
from drake_geom_ros.live.scene.changes.map_update import Sighting, has_many, shape_of, showing
from drake_geom_ros.live.scene.changes.standing_maps import standing_maps
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import clear_maps, map_ages
from drake_geom_ros.live.scene.map_sources import FILE
from drake_geom_ros.live.services.saved_file import MAP_FILE, SavedFile
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import obstacle_source_of_text, obstacle_source_text
from drake_geom_ros.sensed_maps import MAP_SUFFIXES, map_bytes, read_map
from drake_geom_ros.sensed_maps.map_files import MapFile


def clear_obstacles(live: LiveScene, request: ClearObstaclesRequest, response: Any) -> None:
    """Forget one map, or all; those that topics feed wait again."""
    with live.reading() as scene:
        names = [request.map] if request.map else list(scene.maps.by_name)
        if unknown := [name for name in names if name not in scene.maps.by_name]:
            raise ArgumentError(
                f'map is {unknown[0][:80]!r}; maps: {", ".join(scene.maps.by_name) or "none"}'
            )
    response.cells = clear_maps(live, names)


def load_obstacles(live: LiveScene, request: LoadObstaclesRequest, response: Any) -> None:
    """Make the map of a file."""
    path = live.files.file(request.path, 'path')
    if Path(path).suffix.lower() not in MAP_SUFFIXES:
        raise ArgumentError(
            f'path is {request.path!r}; it must end with {", ".join(MAP_SUFFIXES)}'
        )
    read, sources = read_map(path), live.map_sources
    own = None if read.cells is not None else sources.resolution()
    cells = read.as_cells(request.resolution or own)
    if not len(cells):
        raise ArgumentError(f'path is {request.path!r}, and the file holds nothing')
    shape = shape_of(cells, sources.margin)
    with live.editing() as scene:
        is_new = FILE not in scene.maps.by_name
        change = standing_maps(scene, [], [FILE], sources.margin)
    if is_new:
        live.change(change, calls_for_more=True)
    with live.editing() as scene:
        # It holds for good; no stamp is newer for it.
        stamp = scene.poses.ages.newest_stamp
        sighting = Sighting(cells, shape, RigidTransform(), ALWAYS, stamp)
        showing_cells = showing(scene, FILE, sighting)
    live.change(showing_cells, calls_for_more=has_many(cells))
    sources.changed()
    response.cells = len(cells)
    if n := read.left_out:
        response.message = f'left out {counted(n, "point")} that {are(n)} not finite'


def save_obstacles(live: LiveScene, request: SaveObstaclesRequest, response: Any) -> None:
    """Write the cells of a map to a file of OctoMap."""
    target = SavedFile(live.files.new_file(request.path, 'path'), MAP_FILE)
    with live.reading() as scene:
        name = _named(scene, request.map)
        seen_map = scene.maps.by_name[name]
        cells, X_WM = seen_map.cells, scene.query.X_WF(seen_map.frame)
    assert cells is not None, 'a map that waits is refused'
    if not X_WM.IsExactlyIdentity():
        cells = cells.moved(X_WM.rotation().matrix(), X_WM.translation())
    target.write(map_bytes(MapFile(cells.centres(), cells), '.bt'))
    response.cells = len(cells)


def _named(scene: HeldScene, name: str) -> str:
    """Return the name of a map that holds something; raises ArgumentError for another one."""
    there = [each for each, seen_map in scene.maps.by_name.items() if seen_map.cells is not None]
    if name in there or (not name and len(there) == 1):
        return name or there[0]
    waiting = [each for each in scene.maps.by_name if each not in there]
    raise ArgumentError(
        f'map is {name[:80]!r}; maps that hold something: {", ".join(there) or "none"}; '
        f'that wait for their first message: {", ".join(waiting) or "none"}'
    )


def add_obstacle_source(live: LiveScene, request: AddObstacleSourceRequest, response: Any) -> None:
    """Listen to one more sensor."""
    source = obstacle_source_of_text(request.name, request.settings, 'settings')
    live.map_sources.add(source)


def remove_obstacle_source(live: LiveScene, request: NamedRequest, response: Any) -> None:
    """Listen to a sensor no more."""
    response.cells = live.map_sources.remove(request.name)


def list_obstacle_sources(live: LiveScene, request: EmptyRequest, response: Any) -> None:
    """Return the sensors that the node listens to."""
    with live.reading() as scene:
        listed = sorted(live.map_sources.listed(), key=lambda each: each.source.name)
        ages = map_ages(scene)
    response.names = [each.source.name for each in listed]
    response.settings = [obstacle_source_text(each.source) for each in listed]
    response.origins = [int(each.origin) for each in listed]
    response.messages = [each.messages for each in listed]
    response.ages = [ages[name] for name in response.names]
