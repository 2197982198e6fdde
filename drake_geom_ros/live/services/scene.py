"""Services that add and remove sources, frames and geometries, and that attach frames.

One function a service; those that bring a shape are in ``shapes``. A handler raises RuntimeError
to refuse, and has changed nothing then.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    GeometryFrame,
    GeometryId,
    Role,
    SceneGraph,
    SceneGraphContext,
    SourceId,
)
from drake_geom_ros.live.conversions.fields import fill_pose, pose_from_message
from drake_geom_ros.live.conversions.names import WORLD
from drake_geom_ros.live.conversions.request_types import (
    AttachRequest,
    DetachRequest,
    NamedRequest,
    OfGeometryRequest,
    OfSourceRequest,
    RegisterFrameRequest,
    RemoveRoleRequest,
)
from drake_geom_ros.live.conversions.scene import role_from_number
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes.attachment import attachment, detachment
from drake_geom_ros.live.scene.changes.removal import removal
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.world_objects import SOURCE as PLANNING_SCENE
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import touched_geometries


def register_source(live: LiveScene, request: NamedRequest, response: Any) -> None:
    """Register a geometry source."""

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> SourceId:
        return graph.RegisterSource(context=context, name=request.name)

    response.source_id = live.change(Change(change)).get_value()


def register_frame(live: LiveScene, request: RegisterFrameRequest, response: Any) -> None:
    """Register a frame in the world or in another frame."""
    with live.reading() as scene:
        if request.name.strip() in (WORLD, scene.model.world_frame):
            raise ArgumentError(f'name is {request.name!r}, which is the name of the world frame')
        source = scene.model.names.source(request.source)
        scene.maps.refuse(source)
        parent = scene.model.names.world
        if request.parent not in ('', WORLD, scene.model.world_frame):
            parent = scene.model.names.frame(request.parent, request.source)
    frame = GeometryFrame(request.name, request.frame_group)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> FrameId:
        return graph.RegisterFrame(
            context=context, source_id=source, parent_id=parent, frame=frame
        )

    response.frame_id = live.change(Change(change)).get_value()


def remove_role(live: LiveScene, request: RemoveRoleRequest, response: Any) -> None:
    """Take a role away."""
    role = role_from_number(request.role)
    with live.reading() as scene:
        source, geometry = scene.model.owned_geometry(request.geometry)
        if role == Role.kProximity:
            scene.maps.refuse(source)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> int:
        return graph.RemoveRole(context=context, source_id=source, geometry_id=geometry, role=role)

    response.count = live.change(Change(change))


def remove_geometry(live: LiveScene, request: OfGeometryRequest, response: Any) -> None:
    """Remove a geometry."""
    with live.reading() as scene:
        source, geometry = scene.model.owned_geometry(request.geometry)
        scene.maps.refuse(source)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.RemoveGeometry(context=context, source_id=source, geometry_id=geometry)

    live.change(Change(change))


def remove_source(live: LiveScene, request: OfSourceRequest, response: Any) -> None:
    """Remove a source and all that is its."""
    with live.editing() as scene:
        change = removal(scene, scene.model.names.source(request.source))
    response.frames, response.geometries = live.change(change)


def attach(live: LiveScene, request: AttachRequest, response: Any) -> None:
    """Let a frame follow another one, which it may touch where the request says."""
    X_PF = _given_pose(request)
    touched = _touched(live, request)
    with live.editing() as scene:
        names = scene.model.names
        frame, parent = names.frame(request.frame), names.frame(request.parent)
        if frame == names.world:
            raise ArgumentError(
                f'frame is {request.frame!r}, the world frame, which follows nothing'
            )
        for each in (frame, parent):
            scene.maps.refuse(scene.model.inspector.GetOwningSourceId(each))
        _refuse_planning_scene(scene, frame)
        touching = touched.of_now(scene, frame, request.touch_links)
        change = attachment(
            scene, frame, parent, X_PF, is_part=request.part_of_robot, touching=touching
        )
    fill_pose(response.pose, live.change(change))
    with live.reading() as scene:
        filter_id = scene.filters.touch_links.filter_of(frame)
    response.filter_id = 0 if filter_id is None else filter_id.get_value()


class _Touched(NamedTuple):
    """The geometries that a frame may touch, in the scene of some version of its names."""

    names_version: int
    geometries: tuple[GeometryId, ...]

    def of_now(
        self, scene: HeldScene, frame: FrameId, patterns: Sequence[str]
    ) -> tuple[GeometryId, ...]:
        """Return them; they are looked for again where the scene has changed meanwhile."""
        model = scene.model
        if self.names_version == model.names_version:
            return self.geometries
        return touched_geometries(model.inspector, model.robots, frame, patterns)


def _touched(live: LiveScene, request: AttachRequest) -> _Touched:
    """Return the geometries that ``attach`` lets a frame touch, found beside the cycles."""
    if not request.touch_links:
        return _Touched(-1, ())
    with live.reading() as scene:
        model = scene.model
        robots, names, names_version = list(model.robots), model.names, model.names_version
        inspector = live.view().query.inspector()
    frame = names.frame(request.frame)
    touched = touched_geometries(inspector, robots, frame, request.touch_links)
    return _Touched(names_version, touched)


def detach(live: LiveScene, request: DetachRequest, response: Any) -> None:
    """Put an attached frame back on the one that it was registered on."""
    X_PF = _given_pose(request)
    with live.editing() as scene:
        frame = scene.model.names.frame(request.frame)
        scene.maps.refuse(scene.model.inspector.GetOwningSourceId(frame))
        _refuse_planning_scene(scene, frame)
        change = detachment(scene, frame, X_PF)
    fill_pose(response.pose, live.change(change))


def _refuse_planning_scene(scene: HeldScene, frame: FrameId) -> None:
    """Raise ArgumentError for an object of MoveIt's, whose filters follow MoveIt's messages."""
    if scene.model.inspector.GetOwningSourceName(frame) == PLANNING_SCENE:
        raise ArgumentError(
            f'{scene.model.names.frame_names[frame]} is an object of the planning scene: attach '
            'and detach it by /attached_collision_object'
        )


def _given_pose(request: DetachRequest) -> RigidTransform | None:
    return pose_from_message(request.pose) if request.pose_given else None
