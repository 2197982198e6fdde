"""Services that change what the scene holds: the scene, a request, a response.

One function a service; those that bring a shape are in ``shapes``. A handler raises RuntimeError
to refuse, and has changed nothing then. No ROS import here.
"""

from __future__ import annotations

from typing import Any

from drake_geom_ros.geometry import ArgumentError, GeometryFrame, Role
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.conversions.fields import fill_pose, pose_from_message
from drake_geom_ros.ros.conversions.names import WORLD
from drake_geom_ros.ros.conversions.scene import role_from_number
from drake_geom_ros.ros.scene.editable_scene import EditableScene


def register_source(scene: EditableScene, request: Any, response: Any) -> None:
    """Register a geometry source."""
    response.source_id = scene.scene_graph.RegisterSource(request.name).get_value()


def register_frame(scene: EditableScene, request: Any, response: Any) -> None:
    """Register a frame in the world or in another frame."""
    if request.name.strip() in (WORLD, scene.world_frame):
        raise ArgumentError(f'name is {request.name!r}, which is the name of the world frame')
    source = scene.names.source(request.source)
    scene.refuse_maps(source)
    frame = GeometryFrame(request.name, request.frame_group)
    if request.parent in ('', WORLD, scene.world_frame):
        frame_id = scene.scene_graph.RegisterFrame(source, frame)
    else:
        parent = scene.names.frame(request.parent, request.source)
        frame_id = scene.scene_graph.RegisterFrame(source, parent, frame)
    response.frame_id = frame_id.get_value()


def remove_role(scene: EditableScene, request: Any, response: Any) -> None:
    """Take a role away."""
    source, geometry = scene.owned_geometry(request.geometry)
    role = role_from_number(request.role)
    if role == Role.kProximity:
        scene.refuse_maps(source)
    response.count = scene.scene_graph.RemoveRole(source, geometry, role)


def remove_source(scene: EditableScene, request: Any, response: Any) -> None:
    """Remove a source and all that is its."""
    source = scene.names.source(request.source)
    response.frames, response.geometries = scene.remove_source(source)


def attach(scene: EditableScene, request: Any, response: Any) -> None:
    """Let a frame follow another one."""
    names = scene.names
    frame, parent = names.frame(request.frame), names.frame(request.parent)
    if frame == names.world:
        raise ArgumentError(f'frame is {request.frame!r}, the world frame, which follows nothing')
    for each in (frame, parent):
        scene.refuse_maps(scene.inspector.GetOwningSourceId(each))
    X_PF, is_part = _given_pose(request), request.part_of_robot
    fill_pose(response.pose, scene.attach(frame, parent, X_PF, is_part=is_part))


def detach(scene: EditableScene, request: Any, response: Any) -> None:
    """Put an attached frame back on the one that it was registered on."""
    frame = scene.names.frame(request.frame)
    scene.refuse_maps(scene.inspector.GetOwningSourceId(frame))
    fill_pose(response.pose, scene.detach(frame, _given_pose(request)))


def _given_pose(request: Any) -> RigidTransform | None:
    return pose_from_message(request.pose) if request.pose_given else None


def remove_geometry(scene: EditableScene, request: Any, response: Any) -> None:
    """Remove a geometry."""
    source, geometry = scene.owned_geometry(request.geometry)
    scene.refuse_maps(source)
    scene.scene_graph.RemoveGeometry(source, geometry)
