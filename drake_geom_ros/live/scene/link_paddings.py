"""Paddings and scales of links, as MoveIt's planning scenes give them, as paddings of geometries.

A padding makes a geometry larger all around. A link that is scaled by s about the middle of each
of its shapes is held by the same link with a padding of s - 1 times the reach of the shape. Where
the scene has a padding of its own for a geometry the larger one counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import (
    CalcObb,
    Convex,
    GeometryId,
    Mesh,
    ProximityProperties,
    Role,
    Shape,
)
from drake_geom_ros.live.scene.held_scene import HeldScene

PADDING = 'proximity', 'padding'  # the property of a geometry [m]


class Enlargement(NamedTuple):
    """By how much a link is to be larger."""

    padding: float = 0.0  # [m]
    scale: float = 1.0  # [-] at least 1


class Padded(NamedTuple):
    """The padding [m] of a geometry that a planning scene made larger, and that of the scene."""

    now: float
    own: float


def merged(
    before: Mapping[str, Enlargement], paddings: Mapping[str, float], scales: Mapping[str, float]
) -> dict[str, Enlargement]:
    """Return the enlargements of links after a message, which says something of some of them."""
    links = dict(before)
    for link, padding in paddings.items():
        links[link] = links.get(link, Enlargement())._replace(padding=padding)
    for link, scale in scales.items():
        links[link] = links.get(link, Enlargement())._replace(scale=scale)
    return links


def padded_geometries(
    scene: HeldScene,
    links: Mapping[str, Enlargement],
    before: Mapping[GeometryId, Padded],
) -> dict[GeometryId, Padded]:
    """Return the paddings of the geometries of links of robots, by name, where these are enlarged.

    ``before`` are those that were set; a geometry with another padding by now has got a new one of
    the scene.
    """
    padded = {}
    for geometry, name in _geometries_of_robots(scene):
        if name not in links:
            continue
        properties = scene.model.inspector.GetProximityProperties(geometry)
        assert properties is not None, 'it has the role'
        now = float(properties.GetPropertyOrDefault(*PADDING, 0.0))
        was = before.get(geometry)
        own = was.own if was is not None and was.now == now else now
        padding, scale = links[name]
        if scale > 1.0:
            padding += (scale - 1.0) * _reach(scene.model.inspector.GetShape(geometry))
        padded[geometry] = Padded(max(own, padding), own)
    return padded


def with_padding(properties: ProximityProperties, padding: float) -> ProximityProperties:
    """Return properties with another padding [m]."""
    changed = ProximityProperties(properties)
    changed.RemoveProperty(*PADDING)  # it may be a whole number
    changed.AddProperty(*PADDING, padding)
    return changed


def unknown_links(scene: HeldScene, links: Mapping[str, Enlargement]) -> list[str]:
    """Return the names of enlarged links that no robot of the scene has."""
    robots = scene.model.robot_names()
    link_names = {name for source, name in scene.model.names.labels.values() if source in robots}
    return [
        name for name, each in links.items() if each != Enlargement() and name not in link_names
    ]


def _geometries_of_robots(scene: HeldScene) -> Iterable[tuple[GeometryId, str]]:
    """Yield the geometries of robots that queries see, with the names of their links."""
    robots, inspector = scene.model.robot_names(), scene.model.inspector
    for frame, (source, name) in scene.model.names.labels.items():
        if source in robots:
            for geometry in inspector.GetGeometries(frame, Role.kProximity):
                yield geometry, name


def _reach(shape: Shape) -> float:
    """Return how far [m] a point of a shape may be from the middle that it is scaled about.

    That of a mesh is the mean of its vertices, wherever in their box that is.
    """
    if isinstance(shape, Convex | Mesh):
        points = shape.hull_surface()[0]
        return float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
    box = CalcObb(shape)
    if box is None:
        return 0.0  # a half space has no size
    return math.hypot(*(box.half_width() + np.abs(box.center())))
