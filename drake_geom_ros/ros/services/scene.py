"""Services that change what the scene holds: a request, the live scene, a response.

One function a service; those that bring a shape are in ``shapes``. A handler raises
RuntimeError to refuse, and has changed nothing then. The caller holds the scene's lock. No ROS
import here.
"""

from __future__ import annotations

from typing import Any

from drake_geom_ros.geometry import ArgumentError, GeometryFrame
from drake_geom_ros.ros.conversions.names import WORLD
from drake_geom_ros.ros.conversions.scene import role_from_number
from drake_geom_ros.ros.scene.live_scene import LiveScene


def register_source(live: LiveScene, request: Any, response: Any) -> None:
    """Register a geometry source."""
    response.source_id = live.scene_graph.RegisterSource(request.name).get_value()


def register_frame(live: LiveScene, request: Any, response: Any) -> None:
    """Register a frame in the world or in another frame."""
    if request.name.strip() in (WORLD, live.world_frame):
        raise ArgumentError(f'name is {request.name!r}, which is what the world frame is called')
    source = live.names.source(request.source)
    frame = GeometryFrame(request.name, request.frame_group)
    if request.parent in ('', WORLD, live.world_frame):
        frame_id = live.scene_graph.RegisterFrame(source, frame)
    else:
        parent = live.names.frame(request.parent, request.source)
        frame_id = live.scene_graph.RegisterFrame(source, parent, frame)
    response.frame_id = frame_id.get_value()


def remove_role(live: LiveScene, request: Any, response: Any) -> None:
    """Take a role away."""
    source, geometry = live.owned_geometry(request.geometry)
    role = role_from_number(request.role)
    response.count = live.scene_graph.RemoveRole(source, geometry, role)


def remove_geometry(live: LiveScene, request: Any, response: Any) -> None:
    """Remove a geometry."""
    live.scene_graph.RemoveGeometry(*live.owned_geometry(request.geometry))
