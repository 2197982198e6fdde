"""Services that change what the scene holds: the scene, a request, a response.

One function a service; those that bring a shape are in ``shapes``. A handler raises RuntimeError
to refuse, and has changed nothing then. One whose change of a large scene takes long is handed the
live scene, and holds it only for the change itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    GeometryFrame,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.live.conversions.fields import fill_pose, pose_from_message
from drake_geom_ros.live.conversions.names import WORLD
from drake_geom_ros.live.conversions.scene import role_from_number
from drake_geom_ros.live.scene.editable_scene import EditableScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.math import RigidTransform


class _Removed(NamedTuple):
    """The frames and geometries that were removed with a source."""

    frames: Sequence[FrameId]
    geometries: int


def register_source(scene: EditableScene, request: Any, response: Any) -> None:
    """Register a geometry source."""
    response.source_id = scene.scene_graph.RegisterSource(request.name).get_value()


def register_frame(live: LiveScene, request: Any, response: Any) -> None:
    """Register a frame in the world or in another frame."""
    with live.reading() as scene:
        if request.name.strip() in (WORLD, scene.world_frame):
            raise ArgumentError(f'name is {request.name!r}, which is the name of the world frame')
        source = scene.names.source(request.source)
        scene.refuse_maps(source)
        parent = scene.names.world
        if request.parent not in ('', WORLD, scene.world_frame):
            parent = scene.names.frame(request.parent, request.source)
    frame = GeometryFrame(request.name, request.frame_group)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> FrameId:
        return graph.RegisterFrame(
            context=context, source_id=source, parent_id=parent, frame=frame
        )

    response.frame_id = live.change(change).get_value()


def remove_role(live: LiveScene, request: Any, response: Any) -> None:
    """Take a role away."""
    role = role_from_number(request.role)
    with live.reading() as scene:
        source, geometry = scene.owned_geometry(request.geometry)
        if role == Role.kProximity:
            scene.refuse_maps(source)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> int:
        return graph.RemoveRole(context=context, source_id=source, geometry_id=geometry, role=role)

    response.count = live.change(change)


def remove_geometry(live: LiveScene, request: Any, response: Any) -> None:
    """Remove a geometry."""
    with live.reading() as scene:
        source, geometry = scene.owned_geometry(request.geometry)
        scene.refuse_maps(source)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.RemoveGeometry(context=context, source_id=source, geometry_id=geometry)

    live.change(change)


def remove_source(live: LiveScene, request: Any, response: Any) -> None:
    """Remove a source and all that is its."""
    with live.reading() as scene:
        source = scene.names.source(request.source)
        scene.refuse_maps(source)
        name = scene.inspector.GetName(source)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> _Removed:
        query = None if context is None else QueryObject(context)
        inspector = graph.model_inspector() if query is None else query.inspector()
        before = inspector.num_geometries()
        frames = graph.RemoveSource(context=context, source_id=source)
        return _Removed(frames, before - inspector.num_geometries())

    def then(scene: EditableScene, removed: _Removed) -> None:
        scene.forget_source(source, name, removed.frames)

    removed = live.change(change, then=then)
    response.frames, response.geometries = len(removed.frames), removed.geometries


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
