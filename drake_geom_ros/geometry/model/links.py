"""Geometries of a role, grouped by frame, for viewers to load."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model.properties import Role
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector


class Link(NamedTuple):
    """A frame with its geometries, as Drake's visualiser loads it."""

    frame: FrameId
    name: str
    group: int


def links_of(inspector: SceneGraphInspector, role: Role) -> list[Link]:
    """Return the frames with geometry of a role, without the world."""
    world = inspector.world_frame_id()
    return [
        Link(
            frame,
            f'{inspector.GetOwningSourceName(frame)}::{inspector.GetName(frame)}',
            inspector.GetFrameGroup(frame),
        )
        for frame in inspector.GetAllFrameIds()
        if frame != world and inspector.NumGeometriesForFrameWithRole(frame, role)
    ]
