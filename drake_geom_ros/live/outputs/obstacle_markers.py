"""~/markers of sensed maps: three layers a map, cells, shell and shadow.

Namespaces are ``obstacles::NAME``, ``shell::NAME`` (seen beside bodies, in no distance) and
``shadow::NAME`` (cells of the map that a body hides from the sensor). Cells are coloured by age:
blue while they are new, orange where the map is about to be stale, and red beyond.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import GeometryId
from drake_geom_ros.live.outputs.markers import MarkerWriter
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.map_placing import map_ages
from drake_geom_ros.live.scene.scene_maps import SeenMap
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.viewing.looks import (
    MAP_AGES,
    SHADOW_COLOUR,
    SHELL_COLOUR,
    STALE_COLOUR,
    Colour,
)

MOST_CELLS = 20_000  # of a marker; rclpy takes about 0.1 s for them
_STEPS = 8  # of colour, from new to stale: each is sent once
_SHELL_SIZE = 2.0 / math.sqrt(3.0)  # edge of a cell, by the greatest distance from its centre
_ENLARGED = 1.02  # what lies on cells would flicker in their surface


LAYERS = 'obstacles', 'shell', 'shadow'


class Layer(NamedTuple):
    """Cubes of a marker, in its frame, with its pose in the world."""

    namespace: str
    centres: Floats  # (n, 3) [m]
    edge: float  # [m]
    colour: Colour
    X_WM: RigidTransform


class _Sent(NamedTuple):
    """A map as it was sent last: the content itself, and the step of its colour."""

    seen_map: SeenMap
    step: int


class ObstacleMarkers:
    """The layers of the maps of a scene, of which those are sent that changed."""

    def __init__(self, live: LiveScene) -> None:
        self._live = live
        self._sent: dict[str, _Sent] = {}  # by map

    def forget(self) -> None:
        """Send all again."""
        self._sent.clear()

    def geometries(self) -> set[GeometryId]:
        """Return the geometries that are drawn here."""
        with self._live.reading() as scene:
            return {each.geometry for each in scene.maps.by_name.values()}

    def changed(self, writer: MarkerWriter) -> list[Any]:
        """Return the markers of layers that are new, changed or gone."""
        markers: list[Any] = []
        sent: dict[str, _Sent] = {}
        for seen_map, name, step, X_WM in self._maps():
            sent[name] = _Sent(seen_map, step)
            before = self._sent.get(name)
            if before is None or before.seen_map is not seen_map or before.step != step:
                markers += [writer.cubes(*each) for each in layers_of(seen_map, name, step, X_WM)]
        nothing = np.zeros((0, 3)), 1.0, SHELL_COLOUR, RigidTransform()
        for name in sorted(self._sent.keys() - sent.keys()):
            markers += [writer.cubes(f'{layer}::{name}', *nothing) for layer in LAYERS]
        self._sent = sent
        return markers

    def _maps(self) -> list[tuple[SeenMap, str, int, RigidTransform]]:
        """Return the maps that hold something, with names, steps of colour and poses."""
        with self._live.reading() as scene:
            ages, limits = map_ages(scene), scene.maps.limits
            maps = {n: each for n, each in scene.maps.by_name.items() if each.cells is not None}
            poses = {name: scene.query.X_WF(each.frame) for name, each in maps.items()}
        rows = []
        for name, seen_map in maps.items():
            timeout = limits[name].timeout if name in limits else None
            limit = self._live.stale_after if timeout is None else timeout
            rows.append((seen_map, name, colour_step(ages[name], limit), poses[name]))
        return rows


def colour_step(age: float, limit: float) -> int:
    """Return the step of colour of a map: 0 is new, the last one but one old, the last stale."""
    if age > limit:
        return _STEPS
    return min(int(_STEPS * age / limit), _STEPS - 1) if limit > 0.0 else 0


def layers_of(seen_map: SeenMap, name: str, step: int, X_WM: RigidTransform) -> list[Layer]:
    """Return the layers of a map that holds something."""
    cells, shell = seen_map.cells, seen_map.shell
    assert cells is not None
    shown = cells
    while len(shown) > MOST_CELLS:
        shown = shown.coarser(2.0 * shown.resolution)
    here, edge = RigidTransform(), _ENLARGED * cells.resolution
    return [
        Layer(f'{LAYERS[0]}::{name}', shown.centres(), shown.resolution, colour_of(step), X_WM),
        Layer(
            f'{LAYERS[1]}::{name}', shell.centres, _SHELL_SIZE * shell.reach, SHELL_COLOUR, here
        ),
        Layer(f'{LAYERS[2]}::{name}', seen_map.hidden[:MOST_CELLS], edge, SHADOW_COLOUR, here),
    ]


def colour_of(step: int) -> Colour:
    """Return the colour of a step of age."""
    if step == _STEPS:
        return STALE_COLOUR
    new, old = (np.array(colour) for colour in MAP_AGES)
    r, g, b, a = (new + (old - new) * step / (_STEPS - 1)).tolist()
    return r, g, b, a
