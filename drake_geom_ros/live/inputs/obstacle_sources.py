"""The sources of a node's sensed maps: those of parameters and those of its scene file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.inputs import obstacle_records
from drake_geom_ros.live.inputs.obstacle_records import ObstacleSettings
from drake_geom_ros.live.inputs.obstacle_refusals import octomap_refusal
from drake_geom_ros.live.scene.scene_maps import AgeLimit
from drake_geom_ros.scene_files import (
    DEPTH_IMAGE,
    OCTOMAP,
    POINT_CLOUD,
    ObstacleSource,
)

# The sources that the parameter `obstacles` names.
_DEFAULTS = {
    obstacle_records.POINTS: (POINT_CLOUD, '~/obstacles/points'),
    obstacle_records.DEPTH: (DEPTH_IMAGE, '~/obstacles/depth/image_rect_raw'),
    obstacle_records.OCTOMAP: (OCTOMAP, '~/obstacles/octomap'),
}


def all_sources(
    names: Iterable[str], of_scene: Sequence[ObstacleSource]
) -> dict[str, ObstacleSource]:
    """Return the sources by name, those of the parameter ``obstacles`` first.

    Raises ArgumentError for a name that both have, and for an OctoMap whose package is missing.
    """
    sources = {name: ObstacleSource(name, *_DEFAULTS[name]) for name in names}
    for each in of_scene:
        if each.name in sources:
            raise ArgumentError(
                f'the scene has an obstacle source {each.name!r}, and so has the parameter '
                'obstacles: leave it out of one of the two'
            )
        sources[each.name] = each
    octomaps = [name for name, each in sources.items() if each.type == OCTOMAP]
    who = f'the obstacle source {octomaps[0]!r} is an octomap' if octomaps else ''
    if who and (reason := octomap_refusal(who)):
        raise ArgumentError(reason)
    return sources


def settings_of(source: ObstacleSource, settings: ObstacleSettings) -> ObstacleSettings:
    """Return settings with what a source says otherwise."""
    own: dict[str, Any] = {
        'resolution': source.resolution,
        'reach': source.range,
        'padding': source.padding,
        'noise': source.noise,
        'least_points': source.least_points,
        'keep': source.keep,
        'rays': source.rays,
        'box': source.box,
        'extrude': source.extrude,
    }
    return settings._replace(**{key: value for key, value in own.items() if value is not None})


def age_limits(sources: Mapping[str, ObstacleSource]) -> dict[str, AgeLimit]:
    """Return when maps are stale, of those whose source says so or is not required."""
    return {
        name: AgeLimit(each.timeout, each.required)
        for name, each in sources.items()
        if each.timeout is not None or not each.required
    }


def camera_info_of(topic: str) -> str:
    """Return the topic of the camera of an image topic, as image_transport names it.

    >>> camera_info_of('/camera/depth/image_rect_raw')
    '/camera/depth/camera_info'
    """
    folder, slash, _ = topic.rpartition('/')
    return f'{folder}{slash}camera_info'
