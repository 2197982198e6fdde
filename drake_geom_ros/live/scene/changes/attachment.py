"""Frames that follow others, and that are put back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from drake_geom_ros.geometry import (
    FilterId,
    FrameId,
    GeometryId,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import TouchLinks, touch_filter


class _Attached(NamedTuple):
    """The filter of an attachment, and the one of the attachment before; None: there is none."""

    filter_id: FilterId | None
    ended: FilterId | None


def attachment(
    scene: HeldScene,
    frame: FrameId,
    parent: FrameId,
    X_PF: RigidTransform | None = None,
    *,
    is_part: bool = True,
    touching: Sequence[GeometryId] = (),
) -> Change[HeldScene, RigidTransform]:
    """Return the attachment of a frame to another one, where it is or at X_PF: its X_PF.

    ``is_part``: it counts as part of what carries it in sets by name. Its pairs with the
    geometries ``touching`` are excluded by a transient filter, which takes the place of the one
    that an earlier attachment had, and which ``detachment`` removes. Raises ArgumentError where
    nobody knows where the frame is.
    """
    inspector, names = scene.model.inspector, scene.model.names
    source = inspector.GetOwningSourceId(frame)
    X_now = X_PF or scene.poses.pose_in(frame, parent)
    before = scene.filters.touch_links.filter_of(frame)
    owner = f'attach {names.frame_names[frame]}'
    excluded = touch_filter(inspector, frame, touching) if touching else None
    may_touch = tuple(sorted(names.geometry_names[each] for each in touching))

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> _Attached:
        graph.AttachFrame(
            context=context,
            source_id=source,
            frame_id=frame,
            parent_id=parent,
            X_PF=X_now,
            is_part=is_part,
        )
        manager = graph.collision_filter_manager(context)
        ended = before if before is not None and manager.RemoveDeclaration(before) else None
        return _Attached(None if excluded is None else manager.ApplyTransient(excluded), ended)

    def first(scene: HeldScene) -> None:
        nonlocal X_now
        X_now = X_PF or scene.poses.pose_in(frame, parent)

    def then(scene: HeldScene, made: _Attached) -> RigidTransform:
        scene.poses.rest_at(frame, X_now)
        if made.ended is not None:
            scene.filters.end(made.ended)
        if made.filter_id is None:
            scene.filters.touch_links.end(frame)
        else:
            scene.filters.begin_attached(frame, owner, TouchLinks(made.filter_id, may_touch))
        return X_now

    return Change(on, first, then)


def detachment(
    scene: HeldScene, frame: FrameId, X_PF: RigidTransform | None = None
) -> Change[HeldScene, RigidTransform]:
    """Return the return of a frame to its home, where it is or at X_PF: its X_PF there.

    The filter of what it might touch ends. Its pose is as old as the oldest of those that led to
    it. Raises ArgumentError where nobody knows where the frame is.
    """
    home = scene.model.inspector.GetHomeFrame(frame)
    source = scene.model.inspector.GetOwningSourceId(frame)
    X_now, since = X_PF or scene.poses.pose_in(frame, home), ALWAYS
    touching = scene.filters.touch_links.filter_of(frame)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> bool:
        graph.DetachFrame(context=context, source_id=source, frame_id=frame, X_PF=X_now)
        manager = graph.collision_filter_manager(context)
        return touching is not None and manager.RemoveDeclaration(touching)

    def first(scene: HeldScene) -> None:
        nonlocal X_now, since
        X_now = X_PF or scene.poses.pose_in(frame, home)
        since = scene.poses.since_now(None if X_PF else frame)

    def then(scene: HeldScene, removed: bool) -> RigidTransform:
        if removed and touching is not None:
            scene.filters.end(touching)
        scene.filters.touch_links.end(frame)
        scene.poses.move_again_from(frame, X_now, since)
        return X_now

    return Change(on, first, then)
