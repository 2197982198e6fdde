"""Services that change the collision filters: the scene, a request, a response.

As in ``scene``: a handler raises RuntimeError to refuse.
"""

from __future__ import annotations

import math
from typing import Any

from drake_geom_ros.geometry import ArgumentError, CollisionFilterManager, FilterId
from drake_geom_ros.live.conversions.filters import declaration_from_message
from drake_geom_ros.live.scene.editable_scene import EditableScene, owned_by


def apply_filter(scene: EditableScene, request: Any, response: Any) -> None:
    """Apply a persistent declaration."""
    declaration = declaration_from_message(request.declaration, scene.names)
    _manager(scene).Apply(declaration)


def flatten_filters(scene: EditableScene, request: Any, response: Any) -> None:
    """Make the current configuration the persistent one."""
    _manager(scene).Flatten()


def _lease(request: Any) -> float:
    """Return the lease [s] of a request; raises for what is none."""
    if not (math.isfinite(request.lease) and request.lease >= 0.0):
        raise ArgumentError(f'lease is {request.lease}; it must be finite and >= 0 [s], 0: none')
    return float(request.lease)


def apply_transient_filter(scene: EditableScene, request: Any, response: Any) -> None:
    """Apply a declaration that can be taken back, or that ends with its lease."""
    lease = _lease(request)
    scene.refuse_too_many_filters(request.owner)
    declaration = declaration_from_message(request.declaration, scene.names)
    filter_id = _manager(scene).ApplyTransient(declaration)
    scene.lease(filter_id, lease)
    scene.own(filter_id, request.owner)
    response.filter_id = filter_id.get_value()
    until = f'for {lease:g} s' if lease else 'until it is removed'
    scene.told.append(f'transient filter {response.filter_id} {until}{owned_by(request.owner)}')


def renew_filter(scene: EditableScene, request: Any, response: Any) -> None:
    """Prolong the lease of a transient declaration, unless another asked for it."""
    lease, filter_id = _lease(request), FilterId(request.filter_id)
    response.active = _is_of(scene, request) and _manager(scene).IsActive(filter_id)
    if response.active:
        scene.lease(filter_id, lease)


def remove_filter(scene: EditableScene, request: Any, response: Any) -> None:
    """Take a transient declaration back, unless another asked for it."""
    filter_id = FilterId(request.filter_id)
    response.removed = _is_of(scene, request) and _manager(scene).RemoveDeclaration(filter_id)
    if response.removed:
        scene.lease(filter_id, 0.0)
        owner = owned_by(scene.owner_of(filter_id))
        scene.told.append(f'transient filter {request.filter_id} removed{owner}')


def _manager(scene: EditableScene) -> CollisionFilterManager:
    return scene.scene_graph.collision_filter_manager()


def _is_of(scene: EditableScene, request: Any) -> bool:
    """Return whether a filter is of who asks; of anybody, where a request does not say who."""
    return request.owner in ('', scene.owner_of(FilterId(request.filter_id)))
