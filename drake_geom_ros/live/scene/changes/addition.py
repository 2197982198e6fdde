"""Registration of what is described, beside what there is or in the place of sources."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from drake_geom_ros.geometry import (
    ArgumentError,
    FrameId,
    SceneGraph,
    SceneGraphContext,
    SourceId,
)
from drake_geom_ros.live.conversions.names import MAPS
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.scene_poses import Place
from drake_geom_ros.scene_files import (
    LoadedScene,
    SceneDescription,
    register,
    register_rehearsed,
    warm_up,
)


def addition(description: SceneDescription) -> Change[HeldScene, tuple[int, int]]:
    """Return the registration of what is described: so many frames and geometries.

    Frames stand where the description puts them until their first pose comes.
    """

    def first(scene: HeldScene) -> None:
        for camera in description.cameras:
            scene.cameras.refuse_taken(camera.name)
        scene.cameras.refuse_beyond_limits(description.cameras)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> LoadedScene:
        return _registered(graph, description, context)

    def then(scene: HeldScene, loaded: LoadedScene) -> tuple[int, int]:
        return scene.begin(loaded)

    return Change(on, first, then, description.robots, rules=description.rules)


def exchange(
    scene: HeldScene, sources: Sequence[SourceId], description: SceneDescription
) -> Change[HeldScene, tuple[int, int]]:
    """Return the registration of what is described in the place of sources.

    Its result are the numbers of frames and geometries added. Frames of the same source and name,
    of which nothing else is said, keep their poses. Raises ArgumentError for the source of sensed
    maps.
    """
    for source in sources:
        scene.maps.refuse(source)
    names = [scene.model.inspector.GetName(source) for source in sources]
    places: dict[tuple[str, str], Place] = {}

    def first(scene: HeldScene) -> None:
        nonlocal places
        _refuse_exchange(scene, sources, description)
        places = scene.poses.places_of(sources)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> _Exchanged:
        if context is None:  # a refusal is to come before anything is removed
            _exchanged(graph, graph.CreateDefaultContext(), sources, description)
        return _exchanged(graph, context, sources, description)

    def then(scene: HeldScene, made: _Exchanged) -> tuple[int, int]:
        for name, frames in zip(names, made.removed, strict=True):
            scene.forget_source(name, frames)
        scene.replaced += 1
        added = scene.begin(made.loaded)
        scene.poses.stay(places, made.loaded)
        return added

    return Change(on, first, then, description.robots, names, description.rules)


def _refuse_exchange(
    scene: HeldScene, sources: Sequence[SourceId], description: SceneDescription
) -> None:
    """Raise RuntimeError where what is described cannot be in the place of sources."""
    present, inspector = scene.cameras.by_name(), scene.model.inspector
    for camera in description.cameras:
        frame, _ = present.get(camera.name, (None, None))
        if frame is not None and inspector.GetOwningSourceId(frame) not in sources:
            scene.cameras.refuse_taken(camera.name)
    scene.cameras.refuse_beyond_limits(description.cameras)
    if scene.model.maps_source is not None and MAPS in description.sources:
        raise ArgumentError(
            f'the scene has a source {MAPS!r}, which is that of sensed maps; give it another name'
        )


class _Exchanged(NamedTuple):
    """The frames of each source that was removed, and what was registered."""

    removed: list[list[FrameId]]
    loaded: LoadedScene


def _exchanged(
    graph: SceneGraph,
    context: SceneGraphContext | None,
    sources: Iterable[SourceId],
    description: SceneDescription,
) -> _Exchanged:
    """Remove sources and register what is described."""
    removed = [graph.RemoveSource(context=context, source_id=source) for source in sources]
    if context is None:  # it was rehearsed
        return _Exchanged(removed, register_rehearsed(graph, description))
    return _Exchanged(removed, _registered(graph, description, context))


def _registered(
    graph: SceneGraph, description: SceneDescription, context: SceneGraphContext | None
) -> LoadedScene:
    """Register what is described, or nothing; in a context, frames stand where it puts them."""
    if context is None:
        return register(graph, description)
    loaded = warm_up(graph, description, context)
    context.UpdateFramePoses(loaded.first_poses)
    return loaded
