"""The sources of a node's sensed maps: those of parameters and those of its scene file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.inputs import obstacle_records
from drake_geom_ros.live.inputs.obstacle_records import ObstacleSettings
from drake_geom_ros.live.inputs.obstacle_refusals import package_refusal
from drake_geom_ros.live.scene.map_sources import NamedSource, SourceOrigin
from drake_geom_ros.live.scene.scene_maps import AgeLimit
from drake_geom_ros.scene_files import (
    DEPTH_IMAGE,
    OCCUPANCY_GRID,
    OCTOMAP,
    POINT_CLOUD,
    ObstacleSource,
    obstacle_sources_of_text,
)

# The sources that the parameter `obstacles` names.
_DEFAULTS = {
    obstacle_records.POINTS: (POINT_CLOUD, '~/obstacles/points'),
    obstacle_records.DEPTH: (DEPTH_IMAGE, '~/obstacles/depth/image_rect_raw'),
    obstacle_records.OCTOMAP: (OCTOMAP, '~/obstacles/octomap'),
}
# Packages of messages that not every installation has, by the type of source.
_PACKAGES = {OCTOMAP: 'octomap_msgs', OCCUPANCY_GRID: 'nav_msgs'}


def all_sources(
    names: Iterable[str],
    of_parameter: Sequence[ObstacleSource],
    of_scene: Sequence[ObstacleSource],
) -> dict[str, NamedSource]:
    """Return the sources by name: of the parameters obstacles and obstacle_sources, of the scene.

    Two of one name have to be the same, as in a scene that was saved with those of a parameter.
    Raises ArgumentError for others, and for messages whose package is missing.
    """
    defaults = [ObstacleSource(name, *_DEFAULTS[name]) for name in names]
    sources: dict[str, NamedSource] = {}
    for origin, several in (
        *((SourceOrigin.PARAMETER, defaults), (SourceOrigin.PARAMETER, of_parameter)),
        (SourceOrigin.SCENE_FILE, of_scene),
    ):
        for each in several:
            refuse_without_package(each)
            there = sources.setdefault(each.name, NamedSource(each, origin))
            if there.source != each:
                raise ArgumentError(
                    f'{origin.in_words()} has an obstacle source {each.name!r}, and so has '
                    f'{there.origin.in_words()}, with other keys: leave one of the two out'
                )
    return sources


def obstacle_sources_of(text: str) -> tuple[ObstacleSource, ...]:
    """Return the sources of the parameter ``obstacle_sources``; raises RuntimeError."""
    return obstacle_sources_of_text(text, 'obstacle_sources') if text.strip() else ()


def refuse_without_package(source: ObstacleSource) -> None:
    """Raise ArgumentError for a source whose messages no package here has."""
    package = _PACKAGES.get(source.type)
    who = f'the obstacle source {source.name!r} is of type {source.type}'
    if package is not None and (reason := package_refusal(package, who)):
        raise ArgumentError(reason)


def refuse_taken_name(source: ObstacleSource, there: Mapping[str, NamedSource]) -> None:
    """Raise ArgumentError where a node has a source of that name."""
    if source.name in there:
        raise ArgumentError(
            f'there is an obstacle source {source.name!r} already, by '
            f'{there[source.name].origin.in_words()}; give this one another name'
        )


def removable(name: str, there: Mapping[str, NamedSource]) -> ObstacleSource:
    """Return the source of that name; ArgumentError where no service may remove it."""
    added = [each for each, (_, origin) in there.items() if origin == SourceOrigin.SERVICE]
    if name in added:
        return there[name].source
    why = 'there is none'
    if name in there:
        why = f'it is by {there[name].origin.in_words()}: leave it out there, and configure anew'
    raise ArgumentError(
        f'the obstacle source {name[:80]!r} cannot be removed: {why}; those of '
        f'add_obstacle_source: {", ".join(added) or "none"}'
    )


def saved_sources(sources: Iterable[ObstacleSource]) -> tuple[ObstacleSource, ...]:
    """Return the sources that a saved scene has: all but those of the parameter ``obstacles``."""
    defaults = [ObstacleSource(name, *default) for name, default in _DEFAULTS.items()]
    return tuple(each for each in sources if each not in defaults)


def settings_of(source: ObstacleSource, settings: ObstacleSettings) -> ObstacleSettings:
    """Return settings with what a source says otherwise."""
    has_padding = source.padding is not None or bool(source.paddings)
    own: dict[str, Any] = {
        'resolution': source.resolution,
        'reach': source.range,
        'padding': source.padding,
        'noise': source.noise,
        'least_points': source.least_points,
        'keep': source.keep,
        'keep_hidden': source.keep_hidden,
        'rays': source.rays,
        'box': source.box,
        'extrude': source.extrude,
        'may_be_empty': source.may_be_empty,
        'threshold': source.threshold,
        'unknown': source.unknown,
        'paddings': source.paddings if has_padding else None,
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
