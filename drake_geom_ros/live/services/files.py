"""Services that read or write scene files.

They take long, so they run in the thread of those that bring shapes, and hold the scene only
while they take it down or put it up. RuntimeError refuses.
"""

from __future__ import annotations

from typing import Any

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.names import MAPS
from drake_geom_ros.live.conversions.request_types import (
    LoadSceneRequest,
    SavedRequest,
)
from drake_geom_ros.live.scene.changes.addition import addition, exchange
from drake_geom_ros.live.scene.changes.removal import in_order_of_removal
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.waiting_maps import GEOMETRY
from drake_geom_ros.live.services.saved_file import SavedFile
from drake_geom_ros.scene_files import SceneDescription, read_scene, to_yaml


def load_scene(live: LiveScene, request: LoadSceneRequest, response: Any) -> None:
    """Load a scene from a file of the node's machine or from a text."""
    if bool(request.path) == bool(request.text):
        raise ArgumentError('path and text are both given or both empty; give exactly one')
    files = live.files
    # A line break tells a text from a path; an ending one changes neither YAML nor URDF.
    text = str(files.file(request.path, 'path')) if request.path else f'{request.text}\n'
    srdf = request.srdf
    if srdf and not srdf.lstrip().startswith('<'):
        srdf = str(files.file(srdf, 'srdf'))
    lost: list[str] = []
    description = read_scene(
        *(text, request.format, srdf, files.package_roots, files.folders), live.robot_options
    )
    _refuse_other_sensors(live, description)
    _refuse_other_gates(live, description)
    if request.replace and request.replaced_sources:
        raise ArgumentError('replace is true, so replaced_sources must be empty: all is removed')
    if request.replaced_sources:
        with live.editing() as scene:
            replaced = map(scene.model.names.source, request.replaced_sources)
            sources = in_order_of_removal(scene.model.inspector, replaced)
            change = exchange(scene, sources, description)
        added = live.change(change, calls_for_more=True)
    elif request.replace:

        def first(scene: HeldScene) -> None:
            lost.extend(_maps_that_go(live, scene))
            scene.log.warnings += lost

        added = live.replace_all(description, first)
    else:
        added = live.change(addition(description), calls_for_more=True)
    response.frames, response.geometries = added
    response.message = '\n'.join([*description.warnings, *lost])


def _refuse_other_sensors(live: LiveScene, description: SceneDescription) -> None:
    """Raise ArgumentError for obstacle sources that are not those that the node listens to."""
    with live.reading() as scene:
        sources = scene.maps.sources
    if other := [each.name for each in description.obstacle_sources if each not in sources]:
        raise ArgumentError(
            f'the scene has the obstacle source {other[0]!r}, which the node does not listen to: '
            'a node opens the sources of its parameter scene_file when it is configured; leave '
            'obstacle_sources out, or name the file there and configure the node anew'
        )


def _refuse_other_gates(live: LiveScene, description: SceneDescription) -> None:
    """Raise ArgumentError for gates that the node has not opened."""
    with live.reading() as scene:
        gates = scene.gates
    if other := [each for each in description.gates if each not in gates]:
        raise ArgumentError(
            f'the scene has the {other[0].in_words()} for {other[0].robot!r}, which the node has '
            'not opened: a node opens the gates of its parameters gate and scene_file when it is '
            'configured; leave the key gate out, or give it there and configure the node anew'
        )


def _maps_that_go(live: LiveScene, scene: HeldScene) -> list[str]:
    """Return in words which sensed maps go with a scene and are not waited for."""
    return [
        f'the map {MAPS}::{name}/{GEOMETRY} of {counted(len(seen_map.cells or ()), "cell")} went '
        'with the scene of before and is in no answer; call load_obstacles again'
        for name, seen_map in scene.maps.by_name.items()
        if name not in live.map_sources.fed
    ]


def save_scene(live: LiveScene, request: SavedRequest, response: Any) -> None:
    """Write the scene down; the file has one line more than the answer, by which it is known."""
    target = SavedFile(live.files.new_file(request.path, 'path')) if request.path else None
    with live.reading() as scene:
        snapshot = scene.snapshot()
    response.text = to_yaml(snapshot.description())
    if target is not None:
        target.write(response.text.encode())
