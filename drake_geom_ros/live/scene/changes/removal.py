"""Removal of a source and all that is its."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from drake_geom_ros.geometry import (
    FrameId,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
    SceneGraphInspector,
    SourceId,
)
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.held_scene import HeldScene


class _Removed(NamedTuple):
    """The frames and geometries that were removed with a source."""

    frames: Sequence[FrameId]
    geometries: int


def removal(scene: HeldScene, source: SourceId) -> Change[HeldScene, tuple[int, int]]:
    """Return the removal of a source: so many frames and geometries.

    Raises ArgumentError for that of sensed maps.
    """
    if not scene.model.is_tracked(source):  # its trackers may have ended for good
        scene.maps.refuse(source)
    name = scene.model.inspector.GetName(source)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> _Removed:
        inspector = (
            graph.model_inspector() if context is None else QueryObject(context).inspector()
        )
        before = inspector.num_geometries()
        frames = graph.RemoveSource(context=context, source_id=source)
        return _Removed(frames, before - inspector.num_geometries())

    def then(scene: HeldScene, removed: _Removed) -> tuple[int, int]:
        scene.forget_source(name, removed.frames)
        return len(removed.frames), removed.geometries

    return Change(on, then=then, gone=[name])


def in_order_of_removal(
    inspector: SceneGraphInspector, sources: Iterable[SourceId]
) -> list[SourceId]:
    """Return sources, each before those that its frames are mounted on or attached to."""
    waiting, ordered = list(dict.fromkeys(sources)), list[SourceId]()
    while waiting:
        carriers = {
            inspector.GetOwningSourceId(inspector.GetParentFrame(frame))
            for source in waiting
            for frame in inspector.FramesForSource(source)
            if inspector.GetOwningSourceId(inspector.GetParentFrame(frame)) != source
        }
        free = [source for source in waiting if source not in carriers]
        ordered += free or waiting  # each hangs on the other: the scene graph refuses that
        waiting = [source for source in waiting if source not in ordered]
    return ordered
