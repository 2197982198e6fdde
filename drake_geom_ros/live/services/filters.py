"""Services that apply, renew, remove and flatten collision filters.

As in ``scene``: a handler raises RuntimeError to refuse.
"""

from __future__ import annotations

import math
from typing import Any

from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    FilterId,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.live.conversions.filters import declaration_from_message
from drake_geom_ros.live.conversions.request_types import (
    ApplyFilterRequest,
    ApplyTransientFilterRequest,
    EmptyRequest,
    LeaseRequest,
    RemoveFilterRequest,
    RenewFilterRequest,
)
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene

_MANY = 100  # names or geometries of a declaration that take longer than a cycle may wait


def apply_filter(live: LiveScene, request: ApplyFilterRequest, response: Any) -> None:
    """Apply a persistent declaration."""
    declaration, is_short = _declaration(live, request)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.collision_filter_manager(context).Apply(declaration)

    live.change(Change(on, same_content=True), is_short=is_short)


def flatten_filters(live: LiveScene, request: EmptyRequest, response: Any) -> None:
    """Make the current configuration the persistent one."""
    with live.editing() as scene:
        scene.model.filter_manager.Flatten()


def apply_transient_filter(
    live: LiveScene, request: ApplyTransientFilterRequest, response: Any
) -> None:
    """Apply a declaration that can be taken back, or that ends with its lease."""
    lease, owner = _lease(request), request.owner
    declaration, is_short = _declaration(live, request)

    def first(scene: HeldScene) -> None:
        scene.filters.refuse_too_many(owner)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> FilterId:
        return graph.collision_filter_manager(context).ApplyTransient(declaration)

    def then(scene: HeldScene, filter_id: FilterId) -> int:
        return scene.filters.begin(filter_id, owner, lease, is_short=is_short)

    change = Change(on, first, then, same_content=True)
    response.filter_id = live.change(change, is_short=is_short)


def renew_filter(live: LiveScene, request: RenewFilterRequest, response: Any) -> None:
    """Prolong the lease of a transient declaration, unless another asked for it."""
    lease, filter_id = _lease(request), FilterId(request.filter_id)
    with live.editing() as scene:
        is_active = scene.model.filter_manager.IsActive(filter_id)
        response.active = is_active and _is_of(scene, request)
        if response.active:
            scene.filters.lease(filter_id, lease)


def remove_filter(live: LiveScene, request: RemoveFilterRequest, response: Any) -> None:
    """Take a transient declaration back, unless another asked for it."""
    filter_id = FilterId(request.filter_id)
    with live.reading() as scene:
        if not _is_of(scene, request):
            response.removed = False
            return
        is_short = scene.filters.is_short(filter_id)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> bool:
        return graph.collision_filter_manager(context).RemoveDeclaration(filter_id)

    def then(scene: HeldScene, removed: bool) -> bool:
        if removed:
            scene.filters.end(filter_id)
        return removed

    response.removed = live.change(Change(on, then=then, same_content=True), is_short=is_short)


def _lease(request: LeaseRequest) -> float:
    """Return the lease [s] of a request; raises for what is none."""
    if not (math.isfinite(request.lease) and request.lease >= 0.0):
        raise ArgumentError(f'lease is {request.lease}; it must be finite and >= 0 [s], 0: none')
    return float(request.lease)


def _declaration(
    live: LiveScene, request: ApplyFilterRequest
) -> tuple[CollisionFilterDeclaration, bool]:
    """Return the declaration of a request by the names of now, and whether it is short.

    A short one, of few names and geometries, is soon applied in any scene.
    """
    with live.reading() as scene:
        names = scene.model.names
    read = declaration_from_message(request.declaration, names)
    return read.declaration, max(read.num_names, read.num_geometries) < _MANY


def _is_of(scene: HeldScene, request: RemoveFilterRequest) -> bool:
    """Return whether a filter is of who asks; of anybody, where a request does not say who."""
    return request.owner in ('', scene.filters.owner_of(FilterId(request.filter_id)))
