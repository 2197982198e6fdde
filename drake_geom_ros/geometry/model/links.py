"""The geometries of a role by the frame that carries them: what viewers load."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model.properties import Role
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector


class Link(NamedTuple):
    """A frame as the visualiser knows it."""

    frame: FrameId
    name: str
    group: int


def links_of(inspector: SceneGraphInspector, role: Role) -> list[Link]:
    """Return the frames other than the world that carry geometry of a role."""
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
