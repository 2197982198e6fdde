"""Sensed maps that wait for their first message: registered in a scene graph, or on a copy."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import (
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    ProximityProperties,
    SceneGraph,
    SceneGraphContext,
    SourceId,
)
from drake_geom_ros.live.conversions.names import MAPS
from drake_geom_ros.live.scene.scene_maps import SeenMap
from drake_geom_ros.math import RigidTransform

GEOMETRY = 'map'
_MARGIN = ('map', 'margin')  # of the geometry, by which each cell is larger on every side
NAMED_AS_MAPS = (
    f'the scene has a source {MAPS!r}, which is what that of sensed maps is called; give it '
    'another name, or remove it'
)


class WaitingMaps(NamedTuple):
    """Maps by name, and their source; None: there is none."""

    source: SourceId | None
    maps: dict[str, SeenMap]


def waiting_maps(
    graph: SceneGraph,
    context: SceneGraphContext | None,
    source: SourceId | None,
    names: Iterable[str],
    margin: float = 0.0,
) -> WaitingMaps:
    """Register maps of a source, or of a new one; their cells are ``margin`` [m] larger."""
    if source is None:
        source = graph.RegisterSource(context=context, name=MAPS)
    maps = {}
    for name in names:
        frame = graph.RegisterFrame(context=context, source_id=source, frame=GeometryFrame(name))
        # Nobody sees it: the frame has no pose.
        some = OccupiedCells(1.0, np.zeros((1, 3)))
        instance = GeometryInstance(RigidTransform(), some, GEOMETRY)
        properties = ProximityProperties()
        if margin:
            properties.AddProperty(*_MARGIN, margin)
        instance.set_proximity_properties(properties)
        geometry = graph.RegisterGeometry(
            context=context, source_id=source, frame_id=frame, geometry=instance
        )
        graph.collision_filter_manager(context).WeldToWorld([frame])
        maps[name] = SeenMap(frame, geometry, None)
    return WaitingMaps(source, maps)
