"""What each service does: a request, the live scene, a response. One function a service.

A handler raises RuntimeError to refuse; ``answer`` turns that into ``success: false`` with the
message, so that a refusal never stops the node. No ROS import here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.geometry import (
    ArgumentError,
    FilterId,
    GeometryFrame,
    GeometryInstance,
    RoleAssign,
)
from drake_geom_ros.ros.conversions import (
    declaration_from_message,
    fill_penetrations,
    fill_point_distances,
    fill_pose,
    fill_signed_distances,
    pose_from_message,
    unsigned,
)
from drake_geom_ros.ros.live_scene import LiveScene
from drake_geom_ros.ros.scene_conversions import (
    properties_from_message,
    role_from_number,
    set_role,
    shape_from_message,
)

Handler = Callable[[LiveScene, Any, Any], None]


def answer(handler: Handler, live: LiveScene, request: Any, response: Any) -> Any:
    """Run a handler and say in the response whether it did what was asked."""
    try:
        handler(live, request, response)
    except RuntimeError as error:
        response.success = False
        response.message = str(error)
    else:
        response.success = True
    return response


# The scene.


def register_source(live: LiveScene, request: Any, response: Any) -> None:
    """Register a geometry source."""
    response.source_id = live.scene_graph.RegisterSource(request.name).get_value()


def register_frame(live: LiveScene, request: Any, response: Any) -> None:
    """Register a frame in the world or in another frame."""
    source = live.names.source(request.source)
    frame = GeometryFrame(request.name, request.frame_group)
    if request.parent in ('', 'world'):
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
    instance = GeometryInstance(
        pose_from_message(request.pose), shape_from_message(request.shape), request.name
    )
    for role in request.roles:
        set_role(instance, role)
    if request.parent_geometry:
        parent = live.names.geometry(request.parent_geometry)
        geometry = scene_graph.RegisterGeometry(source, parent, instance)
    elif request.frame == 'world':
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
    live.scene_graph.ChangeShape(source, geometry, shape_from_message(request.shape))


def load_scene(live: LiveScene, request: Any, response: Any) -> None:
    """Load a scene from a file of the node's machine or from a text."""
    if bool(request.path) == bool(request.text):
        raise ArgumentError('path and text are both given or both empty; give exactly one')
    # A line break tells a text from a path; an ending one changes neither YAML nor URDF.
    scene = request.path or f'{request.text}\n'
    if request.path and '\n' in request.path:
        raise ArgumentError('path holds a line break; a scene as text goes into `text`')
    response.frames, response.geometries = live.load(
        scene, request.format, request.srdf, replace=request.replace
    )
    live.context.compile_kernels()


def save_scene(live: LiveScene, request: Any, response: Any) -> None:
    """Write the scene down."""
    response.text = live.save()
    if request.path:
        try:
            Path(request.path).write_text(response.text)
        except OSError as error:
            raise ArgumentError(
                f'the scene cannot be written to {request.path!r}: {error}'
            ) from None


# Filters.


def apply_filter(live: LiveScene, request: Any, response: Any) -> None:
    """Apply a persistent declaration."""
    declaration = declaration_from_message(request.declaration, live.names)
    live.scene_graph.collision_filter_manager().Apply(declaration)


def flatten_filters(live: LiveScene, request: Any, response: Any) -> None:
    """Make the current configuration the persistent one."""
    live.scene_graph.collision_filter_manager().Flatten()


def get_filters(live: LiveScene, request: Any, response: Any) -> None:
    """Tell the state of the filters."""
    manager = live.scene_graph.collision_filter_manager()
    response.has_transient_history = manager.has_transient_history()
    active = [f.get_value() for f in manager.active_filter_ids()]
    response.active_filter_ids = unsigned(np.array(active))
    response.filtered_pairs = manager.num_filtered_pairs()


def explain_filter(live: LiveScene, request: Any, response: Any) -> None:
    """Tell whether a pair is filtered, and by what."""
    a, b = live.names.geometry(request.geometry_a), live.names.geometry(request.geometry_b)
    response.reasons = live.scene_graph.collision_filter_manager().explain(a, b)
    response.filtered = bool(response.reasons)


def _lease(request: Any) -> float:
    """Return the lease [s] of a request; raises for what is none."""
    if not (math.isfinite(request.lease) and request.lease >= 0.0):
        raise ArgumentError(f'lease is {request.lease}; it must be finite and >= 0 [s], 0: none')
    return float(request.lease)


def apply_transient_filter(live: LiveScene, request: Any, response: Any) -> None:
    """Apply a declaration that can be taken back, or that ends with its lease."""
    lease = _lease(request)
    declaration = declaration_from_message(request.declaration, live.names)
    filter_id = live.scene_graph.collision_filter_manager().ApplyTransient(declaration)
    live.lease(filter_id, lease)
    response.filter_id = filter_id.get_value()


def renew_filter(live: LiveScene, request: Any, response: Any) -> None:
    """Prolong the lease of a transient declaration."""
    lease, filter_id = _lease(request), FilterId(request.filter_id)
    response.active = live.scene_graph.collision_filter_manager().IsActive(filter_id)
    if response.active:
        live.lease(filter_id, lease)


def remove_filter(live: LiveScene, request: Any, response: Any) -> None:
    """Take a transient declaration back."""
    manager = live.scene_graph.collision_filter_manager()
    filter_id = FilterId(request.filter_id)
    response.removed = manager.RemoveDeclaration(filter_id)
    live.lease(filter_id, 0.0)


# Queries.


def _accuracy(request: Any) -> str | None:
    return request.accuracy or None


def compute_point_pair_penetration(live: LiveScene, request: Any, response: Any) -> None:
    """Report the pairs that overlap."""
    query = live.what_if(request.poses)
    results = query.ComputePointPairPenetration(accuracy=_accuracy(request))
    fill_penetrations(response.result, results)


def _limit(name: str, value: float) -> float:
    """Return a distance limit of a request; 0 stands for infinity, as the query's default is."""
    if not value >= 0.0:
        raise ArgumentError(f'{name} is {value}; it must be >= 0 [m], and 0 stands for infinity')
    return value or math.inf


def compute_signed_distance_pairwise(live: LiveScene, request: Any, response: Any) -> None:
    """Report the signed distances up to a limit."""
    limit = _limit('max_distance', request.max_distance)
    results = live.what_if(request.poses).ComputeSignedDistancePairwiseClosestPoints(
        limit, accuracy=_accuracy(request)
    )
    fill_signed_distances(response.result, results, limit)


def compute_signed_distance_pair(live: LiveScene, request: Any, response: Any) -> None:
    """Report the signed distance of one pair."""
    a, b = live.names.geometry(request.geometry_a), live.names.geometry(request.geometry_b)
    results = live.what_if(request.poses).signed_distance_of_pair(
        a, b, accuracy=_accuracy(request)
    )
    fill_signed_distances(response.result, results, math.inf)


def compute_signed_distance_to_point(live: LiveScene, request: Any, response: Any) -> None:
    """Report the signed distances to points."""
    limit = _limit('threshold', request.threshold)
    points = np.asarray(request.points, dtype=np.float64)
    if points.size % 3:
        raise ArgumentError(f'points holds {points.size} numbers; it must hold x y z a point')
    results = live.what_if(request.poses).ComputeSignedDistanceToPoint(
        points.reshape(-1, 3), limit, accuracy=_accuracy(request)
    )
    fill_point_distances(response.result, results, limit)


def find_collision_candidates(live: LiveScene, request: Any, response: Any) -> None:
    """Report the pairs that bounds alone do not keep apart."""
    ids = live.what_if(request.poses).collision_candidates()
    response.id_a, response.id_b = unsigned(ids[:, 0]), unsigned(ids[:, 1])


def has_collisions(live: LiveScene, request: Any, response: Any) -> None:
    """Tell whether any pair overlaps."""
    response.has_collisions = live.what_if(request.poses).HasCollisions()


def get_pose(live: LiveScene, request: Any, response: Any) -> None:
    """Tell the live pose of a frame or a geometry."""
    if bool(request.frame) == bool(request.geometry):
        raise ArgumentError('frame and geometry are both given or both empty; give exactly one')
    if request.relative_to not in (0, 1):
        raise ArgumentError(
            f'relative_to is {request.relative_to}; it must be 0 (WORLD) or 1 (PARENT)'
        )
    inspector, names, query = live.inspector, live.names, live.query
    world = inspector.world_frame_id()
    if request.frame:
        frame = names.frame(request.frame)
        parent = inspector.GetParentFrame(frame) if request.relative_to else world
        X = query.X_PF(frame) if request.relative_to else query.X_WF(frame)
    else:
        geometry = names.geometry(request.geometry)
        parent = inspector.GetFrameId(geometry) if request.relative_to else world
        X = inspector.GetPoseInFrame(geometry) if request.relative_to else query.X_WG(geometry)
    fill_pose(response.pose.pose, X)
    response.pose.header.frame_id = names.frame_names[parent]
