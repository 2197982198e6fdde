"""Services that register geometries, assign roles and change shapes.

They may have to read a mesh and to compile kernels, which takes seconds, so they run in a thread
of their own: all that takes long is done on a copy of the scene, which is held only to look names
up and for the change itself. RuntimeError refuses, and nothing has changed then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from drake_geom_ros.geometry import (
    ArgumentError,
    Convex,
    FrameId,
    GeometryId,
    GeometryInstance,
    Mesh,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
    SceneGraphContext,
    Shape,
)
from drake_geom_ros.live.conversions.fields import pose_from_message
from drake_geom_ros.live.conversions.message_types import NewGeometryMessage
from drake_geom_ros.live.conversions.names import NameTable
from drake_geom_ros.live.conversions.request_types import (
    AssignRoleRequest,
    ChangeShapeRequest,
    RegisterGeometriesRequest,
    RegisterGeometryRequest,
)
from drake_geom_ros.live.conversions.scene import properties_from_message, set_role
from drake_geom_ros.live.conversions.shapes import shape_from_message
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_model import is_many
from drake_geom_ros.proximity_rules import check_zone
from drake_geom_ros.scene_files.hydroelastic import GROUP as HYDROELASTIC


def register_geometry(live: LiveScene, request: RegisterGeometryRequest, response: Any) -> None:
    """Register a geometry with its roles: all of it or nothing."""
    (geometry,) = _registered(live, request.source, [request])
    response.geometry_id = geometry.get_value()


def register_geometries(
    live: LiveScene, request: RegisterGeometriesRequest, response: Any
) -> None:
    """Register several geometries of a source with their roles: all of them or none."""
    ids = _registered(live, request.source, request.geometries, 'geometries[{}]: ')
    response.geometry_ids = [geometry.get_value() for geometry in ids]


def _registered(
    live: LiveScene, source_name: str, messages: Sequence[NewGeometryMessage], place: str = ''
) -> list[GeometryId]:
    """Register geometries; errors begin with ``place``, which takes the number of one."""
    instances = []
    for k, message in enumerate(messages):
        with _at(place.format(k)):
            instances.append(_instance(live, message))
    with live.reading() as scene:
        names = scene.model.names
        source = names.source(source_name)
        scene.maps.refuse(source)
    parents: list[FrameId | GeometryId] = []
    for k, message in enumerate(messages):
        with _at(place.format(k)):
            parents.append(_parent(names, message, source_name))
    is_new = is_many(len(messages)) or _any_calls_for_more(live, parents, instances)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> list[GeometryId]:
        made: list[GeometryId] = []
        try:
            for k, (parent, instance) in enumerate(zip(parents, instances, strict=True)):
                with _at(place.format(k)):
                    made.append(
                        graph.RegisterGeometry(
                            context=context, source_id=source, frame_id=parent, geometry=instance
                        )
                    )
        except RuntimeError:
            for geometry in reversed(made):
                graph.RemoveGeometry(context=context, source_id=source, geometry_id=geometry)
            raise
        return made

    return live.change(Change(change), calls_for_more=is_new)


def _instance(live: LiveScene, message: NewGeometryMessage) -> GeometryInstance:
    """Return what a message wants to be registered."""
    if bool(message.frame) == bool(message.parent_geometry):
        raise ArgumentError(
            'frame and parent_geometry are both given or both empty; exactly one says where the '
            'geometry is fixed (frame `world`: anchored)'
        )
    shape = shape_from_message(message.shape, live.files)
    instance = GeometryInstance(pose_from_message(message.pose), shape, message.name)
    for role in message.roles:
        set_role(instance, role)
    check_zone(shape, instance.illustration_properties())
    return instance


def _parent(names: NameTable, message: NewGeometryMessage, source: str) -> FrameId | GeometryId:
    """Return what a geometry is to be fixed to."""
    if message.parent_geometry:
        return names.geometry(message.parent_geometry)
    return names.frame(message.frame, source)


def _any_calls_for_more(
    live: LiveScene,
    parents: Sequence[FrameId | GeometryId],
    instances: Sequence[GeometryInstance],
) -> bool:
    """Return whether queries may have to load or compile something for new geometries."""
    with live.reading() as scene:
        inspector, world = scene.model.inspector, scene.model.names.world
        kinds: dict[tuple[type[Shape], bool], Shape] = {}
        for parent, instance in zip(parents, instances, strict=True):
            properties = instance.proximity_properties()
            if properties is None:
                continue
            if properties.HasGroup(HYDROELASTIC):
                return True
            frame = parent if isinstance(parent, FrameId) else inspector.GetFrameId(parent)
            kinds[type(instance.shape()), frame == world] = instance.shape()
        return any(_calls_for_more(scene, shape, fixed) for (_, fixed), shape in kinds.items())


@contextmanager
def _at(place: str) -> Iterator[None]:
    """Say in a refusal which of several things it is about."""
    try:
        yield
    except RuntimeError as error:
        if not place:
            raise
        raise ArgumentError(f'{place}{error}') from error


def assign_role(live: LiveScene, request: AssignRoleRequest, response: Any) -> None:
    """Assign a role with its properties."""
    if request.assign not in (0, 1):
        raise ArgumentError(f'assign is {request.assign}; it must be 0 (NEW) or 1 (REPLACE)')
    assign = RoleAssign.kReplace if request.assign else RoleAssign.kNew
    properties = properties_from_message(request.role)
    with live.reading() as scene:
        source, geometry = scene.model.owned_geometry(request.geometry)
        is_new = False
        if isinstance(properties, ProximityProperties):
            scene.maps.refuse(source)
            is_new = properties.HasGroup(HYDROELASTIC) or _is_new(scene, geometry)
        check_zone(scene.model.inspector.GetShape(geometry), properties)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.AssignRole(
            context=context,
            source_id=source,
            geometry_id=geometry,
            properties=properties,
            assign=assign,
        )

    live.change(Change(change), calls_for_more=is_new)


def change_shape(live: LiveScene, request: ChangeShapeRequest, response: Any) -> None:
    """Give a geometry another shape."""
    shape = shape_from_message(request.shape, live.files)
    with live.reading() as scene:
        source, geometry = scene.model.owned_geometry(request.geometry)
        scene.maps.refuse(source)
        check_zone(shape, scene.model.inspector.GetIllustrationProperties(geometry))
        proximity = scene.model.inspector.GetProximityProperties(geometry)
        is_new = proximity is not None and (
            proximity.HasGroup(HYDROELASTIC) or _is_new(scene, geometry, shape)
        )

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.ChangeShape(context=context, source_id=source, geometry_id=geometry, shape=shape)

    live.change(Change(change), calls_for_more=is_new)


def _is_new(scene: HeldScene, geometry: GeometryId, shape: Shape | None = None) -> bool:
    """Return whether a geometry of the scene, with another shape perhaps, needs preparation."""
    inspector = scene.model.inspector
    anchored = inspector.GetFrameId(geometry) == inspector.world_frame_id()
    return _calls_for_more(scene, shape or inspector.GetShape(geometry), anchored)


def _calls_for_more(scene: HeldScene, shape: Shape, anchored: bool) -> bool:
    """Return whether queries may have to load or compile something for a new shape.

    They need not where the scene has such a shape already: it need not be made ready then,
    which for many shapes, one after the other, would cost more than registering them. In a large
    scene every change is made ready.
    """
    if scene.model.is_large or isinstance(shape, Convex | Mesh):
        return True
    inspector = scene.model.inspector
    world = inspector.world_frame_id()
    return not any(
        type(inspector.GetShape(geometry)) is type(shape)
        and (anchored or inspector.GetFrameId(geometry) != world)
        for geometry in inspector.GetAllGeometryIds(Role.kProximity)
    )
