"""Services about the sensors that maps are made of: the live scene, a request, a response."""

from __future__ import annotations

from typing import Any

from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import map_ages
from drake_geom_ros.scene_files import obstacle_source_of_text, obstacle_source_text


def add_obstacle_source(live: LiveScene, request: Any, response: Any) -> None:
    """Listen to one more sensor."""
    source = obstacle_source_of_text(request.name, request.settings, 'settings')
    live.map_sources.add(source)


def remove_obstacle_source(live: LiveScene, request: Any, response: Any) -> None:
    """Listen to a sensor no more."""
    response.cells = live.map_sources.remove(request.name)


def list_obstacle_sources(live: LiveScene, request: Any, response: Any) -> None:
    """Return the sensors that the node listens to."""
    with live.reading() as scene:
        listed = sorted(live.map_sources.listed(), key=lambda each: each.source.name)
        ages = map_ages(scene)
    response.names = [each.source.name for each in listed]
    response.settings = [obstacle_source_text(each.source) for each in listed]
    response.origins = [int(each.origin) for each in listed]
    response.messages = [each.messages for each in listed]
    response.ages = [ages[name] for name in response.names]
