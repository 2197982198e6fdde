"""Two changes of the scene as one."""

from __future__ import annotations

from typing import Any, TypeVar

from drake_geom_ros.geometry import SceneGraph, SceneGraphContext, SourceId
from drake_geom_ros.live.scene.change import Change

_Scene = TypeVar('_Scene')


def together(one: Change[_Scene, Any], other: Change[_Scene, Any]) -> Change[_Scene, None]:
    """Return a change that is two of them, one after the other, or nothing."""

    def first(scene: _Scene) -> None:
        one.first(scene)
        other.first(scene)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> tuple[Any, Any]:
        if context is None:  # a refusal is to come before anything has changed
            rehearsal = graph.CreateDefaultContext()
            one.on(graph, rehearsal)
            other.on(graph, rehearsal)
        return one.on(graph, context), other.on(graph, context)

    def then(scene: _Scene, made: tuple[Any, Any]) -> None:
        one.then(scene, made[0])
        other.then(scene, made[1])

    def maps_source(made: tuple[Any, Any]) -> SourceId | None:
        source = None
        for change, result in zip((one, other), made, strict=True):
            if change.maps_source is not None:
                source = change.maps_source(result)
        return source

    has_maps = one.maps_source is not None or other.maps_source is not None
    return Change(
        on,
        first,
        then,
        robots=(*one.robots, *other.robots),
        gone=(*one.gone, *other.gone),
        rules=(*one.rules, *other.rules),
        rules_gone=(*one.rules_gone, *other.rules_gone),
        same_content=one.same_content and other.same_content,
        maps_source=maps_source if has_maps else None,
    )
