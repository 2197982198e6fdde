"""Services that change what the scene holds: a request, the live scene, a response.

One function a service. A handler raises RuntimeError to refuse, and has changed nothing then. The
caller holds the scene's lock. No ROS import here.
"""

from __future__ import annotations

from typing import Any

from drake_geom_ros.geometry import ArgumentError, GeometryFrame, GeometryInstance, RoleAssign
from drake_geom_ros.ros.conversions import pose_from_message
from drake_geom_ros.ros.live_scene import LiveScene
from drake_geom_ros.ros.names import WORLD
from drake_geom_ros.ros.scene_conversions import (
    properties_from_message,
    role_from_number,
    set_role,
)
from drake_geom_ros.ros.shape_conversions import shape_from_message


def register_source(live: LiveScene, request: Any, response: Any) -> None:
    """Register a geometry source."""
    response.source_id = live.scene_graph.RegisterSource(request.name).get_value()


def register_frame(live: LiveScene, request: Any, response: Any) -> None:
    """Register a frame in the world or in another frame."""
    source = live.names.source(request.source)
    frame = GeometryFrame(request.name, request.frame_group)
    if request.parent in ('', WORLD, live.world_frame):
        frame_id = live.scene_graph.RegisterFrame(source, frame)
    else:
        parent = live.names.frame(request.parent, request.source)
        frame_id = live.scene_graph.RegisterFrame(source, parent, frame)
    response.frame_id = frame_id.get_value()


def register_geometry(live: LiveScene, request: Any, response: Any) -> None:
    """Register a geometry with its roles: all of it or nothing."""
    scene_graph = live.scene_graph
    source = live.names.source(request.source)
    if bool(request.frame) == bool(request.parent_geometry):
        raise ArgumentError(
            'frame and parent_geometry are both given or both empty; exactly one says where the '
            'geometry is fixed (frame `world`: anchored)'
        )
    shape = shape_from_message(request.shape, live.files)
    instance = GeometryInstance(pose_from_message(request.pose), shape, request.name)
    for role in request.roles:
        set_role(instance, role)
    if request.parent_geometry:
        parent = live.names.geometry(request.parent_geometry)
        geometry = scene_graph.RegisterGeometry(source, parent, instance)
    elif request.frame in (WORLD, live.world_frame):
        geometry = scene_graph.RegisterAnchoredGeometry(source, instance)
    else:
        frame = live.names.frame(request.frame, request.source)
        geometry = scene_graph.RegisterGeometry(source, frame, instance)
    response.geometry_id = geometry.get_value()


def _owned(live: LiveScene, name: str) -> tuple[Any, Any]:
    """Return a geometry by name and the source that owns it."""
    geometry = live.names.geometry(name)
    return live.inspector.GetOwningSourceId(geometry), geometry


def assign_role(live: LiveScene, request: Any, response: Any) -> None:
    """Assign a role with its properties."""
    source, geometry = _owned(live, request.geometry)
    if request.assign not in (0, 1):
        raise ArgumentError(f'assign is {request.assign}; it must be 0 (NEW) or 1 (REPLACE)')
    assign = RoleAssign.kReplace if request.assign else RoleAssign.kNew
    properties = properties_from_message(request.role)
    live.scene_graph.AssignRole(source, geometry, properties, assign)


def remove_role(live: LiveScene, request: Any, response: Any) -> None:
    """Take a role away."""
    source, geometry = _owned(live, request.geometry)
    role = role_from_number(request.role)
    response.count = live.scene_graph.RemoveRole(source, geometry, role)


def remove_geometry(live: LiveScene, request: Any, response: Any) -> None:
    """Remove a geometry."""
    live.scene_graph.RemoveGeometry(*_owned(live, request.geometry))


def change_shape(live: LiveScene, request: Any, response: Any) -> None:
    """Give a geometry another shape."""
    source, geometry = _owned(live, request.geometry)
    shape = shape_from_message(request.shape, live.files)
    live.scene_graph.ChangeShape(source, geometry, shape)
