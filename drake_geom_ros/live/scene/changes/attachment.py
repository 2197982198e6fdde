"""Frames that follow others, and that are put back."""

from __future__ import annotations

from drake_geom_ros.geometry import FrameId, SceneGraph, SceneGraphContext
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.math import RigidTransform


def attachment(
    scene: HeldScene,
    frame: FrameId,
    parent: FrameId,
    X_PF: RigidTransform | None = None,
    *,
    is_part: bool = True,
) -> Change[HeldScene, RigidTransform]:
    """Return the attachment of a frame to another one, where it is or at X_PF: its X_PF.

    ``is_part``: it counts as part of what carries it in sets by name. Raises ArgumentError where
    nobody knows where the frame is.
    """
    source = scene.model.inspector.GetOwningSourceId(frame)
    X_now = X_PF or scene.poses.pose_in(frame, parent)

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.AttachFrame(
            context=context,
            source_id=source,
            frame_id=frame,
            parent_id=parent,
            X_PF=X_now,
            is_part=is_part,
        )

    def first(scene: HeldScene) -> None:
        nonlocal X_now
        X_now = X_PF or scene.poses.pose_in(frame, parent)

    def then(scene: HeldScene, made: None) -> RigidTransform:
        scene.poses.rest_at(frame, X_now)
        return X_now

    return Change(on, first, then)


def detachment(
    scene: HeldScene, frame: FrameId, X_PF: RigidTransform | None = None
) -> Change[HeldScene, RigidTransform]:
    """Return the return of a frame to its home, where it is or at X_PF: its X_PF there.

    Its pose is as old as the oldest of those that led to it. Raises ArgumentError where nobody
    knows where the frame is.
    """
    home = scene.model.inspector.GetHomeFrame(frame)
    source = scene.model.inspector.GetOwningSourceId(frame)
    X_now, since = X_PF or scene.poses.pose_in(frame, home), ALWAYS

    def on(graph: SceneGraph, context: SceneGraphContext | None) -> None:
        graph.DetachFrame(context=context, source_id=source, frame_id=frame, X_PF=X_now)

    def first(scene: HeldScene) -> None:
        nonlocal X_now, since
        X_now = X_PF or scene.poses.pose_in(frame, home)
        since = scene.poses.since_now(None if X_PF else frame)

    def then(scene: HeldScene, made: None) -> RigidTransform:
        scene.poses.move_again_from(frame, X_now, since)
        return X_now

    return Change(on, first, then)
