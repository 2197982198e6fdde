"""Services that bring queries a shape: the live scene, a request, a response.

They may have to read a mesh and to compile kernels, which takes seconds, so they run in a thread
of their own: all that takes long is done on a copy of the scene, which is held only to look names
up and for the change itself. RuntimeError refuses, and nothing has changed then. No ROS import
here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

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
    SceneGraphInspector,
    Shape,
)
from drake_geom_ros.ros.conversions.fields import pose_from_message
from drake_geom_ros.ros.conversions.scene import properties_from_message, set_role
from drake_geom_ros.ros.conversions.shapes import shape_from_message
from drake_geom_ros.ros.scene.live_scene import LiveScene

_Result = TypeVar('_Result')
# Is made in a scene graph, or in a copy of it that is given as the context.
_Change = Callable[[SceneGraph, SceneGraphContext | None], _Result]


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
    parent: FrameId | GeometryId
    with live.reading() as scene:
        names = scene.names
        source = names.source(request.source)
        if request.parent_geometry:
            parent = names.geometry(request.parent_geometry)
            frame = scene.inspector.GetFrameId(parent)
        else:
            parent = frame = names.frame(request.frame, request.source)
        is_new = instance.proximity_properties() is not None and _calls_for_more(
            scene.inspector, shape, anchored=frame == names.world
        )

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> GeometryId:
        return graph.RegisterGeometry(
            context=context, source_id=source, frame_id=parent, geometry=instance
        )

    response.geometry_id = _made(live, change, is_new).get_value()


def assign_role(live: LiveScene, request: Any, response: Any) -> None:
    """Assign a role with its properties."""
    if request.assign not in (0, 1):
        raise ArgumentError(f'assign is {request.assign}; it must be 0 (NEW) or 1 (REPLACE)')
    assign = RoleAssign.kReplace if request.assign else RoleAssign.kNew
    properties = properties_from_message(request.role)
    with live.reading() as scene:
        source, geometry = scene.owned_geometry(request.geometry)
        is_new = isinstance(properties, ProximityProperties) and _is_new(scene.inspector, geometry)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.AssignRole(
            context=context,
            source_id=source,
            geometry_id=geometry,
            properties=properties,
            assign=assign,
        )

    _made(live, change, is_new)


def change_shape(live: LiveScene, request: Any, response: Any) -> None:
    """Give a geometry another shape."""
    shape = shape_from_message(request.shape, live.files)
    with live.reading() as scene:
        source, geometry = scene.owned_geometry(request.geometry)
        inspector = scene.inspector
        proximity = inspector.GetProximityProperties(geometry) is not None
        is_new = proximity and _is_new(inspector, geometry, shape)

    def change(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.ChangeShape(context=context, source_id=source, geometry_id=geometry, shape=shape)

    _made(live, change, is_new)


def _made(live: LiveScene, change: _Change[_Result], is_new: bool) -> _Result:
    """Make a change, on a copy first where that may take long, and return what it returns."""
    if is_new:
        live.make_ready(change)
    with live.editing() as scene:
        return change(scene.scene_graph, None)


def _is_new(
    inspector: SceneGraphInspector, geometry: GeometryId, shape: Shape | None = None
) -> bool:
    """Tell whether a geometry of the scene, with another shape perhaps, calls for more."""
    anchored = inspector.GetFrameId(geometry) == inspector.world_frame_id()
    return _calls_for_more(inspector, shape or inspector.GetShape(geometry), anchored)


def _calls_for_more(inspector: SceneGraphInspector, shape: Shape, anchored: bool) -> bool:
    """Tell whether queries may have to load or compile something for a shape to come.

    They have not where the scene has such a shape already: it need not be made ready then,
    which for many shapes, one after the other, would cost more than registering them.
    """
    if isinstance(shape, Convex | Mesh):
        return True
    world = inspector.world_frame_id()
    return not any(
        type(inspector.GetShape(geometry)) is type(shape)
        and (anchored or inspector.GetFrameId(geometry) != world)
        for geometry in inspector.GetAllGeometryIds(Role.kProximity)
    )
