"""The part of a SceneGraph that lets sources go, and lets frames follow frames of others."""

from __future__ import annotations

from drake_geom_ros.geometry.checks import checked_pose
from drake_geom_ros.geometry.ids import FrameId, SourceId
from drake_geom_ros.geometry.model import _attachments
from drake_geom_ros.geometry.model.scene_content import SceneContent, SceneHolder
from drake_geom_ros.geometry.scene._or_on_context import or_on_context
from drake_geom_ros.math import RigidTransform


class Attaching(SceneHolder):
    """What is ours of a SceneGraph's changes: pydrake's sources, frames, parents stay."""

    @or_on_context
    def RemoveSource(self, on: SceneContent, source_id: SourceId) -> list[FrameId]:
        """Remove a source with its frames and geometries; return its frames, which are gone.

        What was said of its geometries in collision filters goes with them. Raises RuntimeError
        if the source is not registered, and while frames of others are attached to its frames.
        """
        removed = _attachments.remove_source(on.model, source_id)
        _remove_from_filters(on, removed)
        return removed.frames

    @or_on_context
    def RemoveFrame(self, on: SceneContent, source_id: SourceId, frame_id: FrameId) -> None:
        """Remove a frame with the geometries on it; all others keep their ids.

        What was said of its geometries in collision filters goes with them. Raises RuntimeError
        if the frame is not the source's, and while other frames hang on it.
        """
        _remove_from_filters(on, _attachments.remove_frame(on.model, source_id, frame_id))

    @or_on_context
    def AttachFrame(
        self,
        on: SceneContent,
        source_id: SourceId,
        frame_id: FrameId,
        parent_id: FrameId,
        X_PF: RigidTransform,
        is_part: bool = True,
    ) -> None:
        """Let a frame, with all that hangs on it, follow a frame of any source, at X_PF in it.

        X_PF is its pose from then on: contexts that are made later begin with it. ``is_part``:
        sets by name that stand for the other frame, or for its source, include this one. A weld of
        the frame to the world ends. Collision filters stay as they are. Raises RuntimeError if the
        frame is not the source's, or the other one is the world or hangs on it.
        """
        pose = checked_pose(X_PF, 'AttachFrame: X_PF')
        frame = _attachments.attach_frame(
            on.model, source_id, frame_id, parent_id, is_part=is_part
        )
        on.begin_at(frame, pose)

    @or_on_context
    def MountFrame(
        self,
        on: SceneContent,
        source_id: SourceId,
        frame_id: FrameId,
        parent_id: FrameId,
    ) -> None:
        """Let a frame hang on a frame of any source for good, as if it had been registered there.

        Its poses X_PF, which its own source goes on giving, are those in that frame from then on:
        a robot on another one's flange. Raises RuntimeError if the
        frame is not the source's, is attached, or the other one hangs on it.
        """
        _attachments.mount_frame(on.model, source_id, frame_id, parent_id)

    @or_on_context
    def DetachFrame(
        self,
        on: SceneContent,
        source_id: SourceId,
        frame_id: FrameId,
        X_PF: RigidTransform,
    ) -> None:
        """Put an attached frame back, at X_PF, on the frame that it was registered on.

        Raises RuntimeError if the frame is not the source's, or is not attached.
        """
        pose = checked_pose(X_PF, 'DetachFrame: X_PF')
        on.begin_at(_attachments.detach_frame(on.model, source_id, frame_id), pose)


def _remove_from_filters(on: SceneContent, removed: _attachments.Removed) -> None:
    """Forget what was said in collision filters of what has gone."""
    for record in removed.geometries:
        if record.proximity is not None:
            on.filters.remove(record.id.get_value())
    for frame in removed.frames:
        on.filters.welded.pop(frame.get_value(), None)
