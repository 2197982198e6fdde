"""Services that bring queries a shape: a request, the live scene, a response.

They may have to read a mesh and to compile kernels, which takes seconds, so they run in a thread
of their own: all that takes long is done on a copy of the scene, and the lock is held only to
look names up and for the change itself. RuntimeError refuses, and nothing has changed then. No
ROS import here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drake_geom_ros.geometry import (
    ArgumentError,
    GeometryInstance,
    ProximityProperties,
    RoleAssign,
    Shape,
)
from drake_geom_ros.ros.conversions.fields import pose_from_message
from drake_geom_ros.ros.conversions.scene import properties_from_message, set_role
from drake_geom_ros.ros.conversions.shapes import shape_from_message
from drake_geom_ros.ros.scene.live_scene import LiveScene


def register_geometry(live: LiveScene, request: Any, response: Any) -> None:
    """Register a geometry with its roles: all of it or nothing."""
    if bool(request.frame) == bool(request.parent_geometry):
        raise ArgumentError(
            'frame and parent_geometry are both given or both empty; exactly one says where the '
            'geometry is fixed (frame `world`: anchored)'
        )
    shape = shape_from_message(request.shape, live.files)
    instance = GeometryInstance(pose_from_message(request.pose), shape, request.name)
    for role in request.roles:
        set_role(instance, role)
    with live.lock:
        names = live.names
        source = names.source(request.source)
        if request.parent_geometry:
            parent: Any = names.geometry(request.parent_geometry)
            frame = live.inspector.GetFrameId(parent)
        else:
            parent = frame = names.frame(request.frame, request.source)
        is_new = instance.proximity_properties() is not None and live.calls_for_more(
            shape, anchored=frame == names.world
        )

    def change(*on: Any) -> Any:
        return live.scene_graph.RegisterGeometry(*on, source, parent, instance)

    response.geometry_id = _made(live, change, is_new).get_value()


def assign_role(live: LiveScene, request: Any, response: Any) -> None:
    """Assign a role with its properties."""
    if request.assign not in (0, 1):
        raise ArgumentError(f'assign is {request.assign}; it must be 0 (NEW) or 1 (REPLACE)')
    assign = RoleAssign.kReplace if request.assign else RoleAssign.kNew
    properties = properties_from_message(request.role)
    with live.lock:
        source, geometry = live.owned_geometry(request.geometry)
        is_new = isinstance(properties, ProximityProperties) and _is_new(live, geometry)

    def change(*on: Any) -> None:
        live.scene_graph.AssignRole(*on, source, geometry, properties, assign)

    _made(live, change, is_new)


def change_shape(live: LiveScene, request: Any, response: Any) -> None:
    """Give a geometry another shape."""
    shape = shape_from_message(request.shape, live.files)
    with live.lock:
        source, geometry = live.owned_geometry(request.geometry)
        proximity = live.inspector.GetProximityProperties(geometry) is not None
        is_new = proximity and _is_new(live, geometry, shape)

    def change(*on: Any) -> None:
        live.scene_graph.ChangeShape(*on, source, geometry, shape)

    _made(live, change, is_new)


def _is_new(live: LiveScene, geometry: Any, shape: Shape | None = None) -> bool:
    """Tell whether a geometry of the scene, with another shape perhaps, calls for more."""
    inspector = live.inspector
    anchored = inspector.GetFrameId(geometry) == inspector.world_frame_id()
    return live.calls_for_more(shape or inspector.GetShape(geometry), anchored)


def _made(live: LiveScene, change: Callable[..., Any], is_new: bool) -> Any:
    """Make a change, on a copy first where that may take long, and return what it returns."""
    if is_new:
        live.make_ready(change)
    with live.lock:
        return change()
