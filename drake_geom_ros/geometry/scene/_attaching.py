"""Part of ``SceneGraph`` that removes sources and attaches frames to those of other sources."""

from __future__ import annotations

from drake_geom_ros.geometry.checks import checked_pose
from drake_geom_ros.geometry.ids import FrameId, SourceId
from drake_geom_ros.geometry.model import _attachments
from drake_geom_ros.geometry.model.scene_content import SceneContent, SceneHolder
from drake_geom_ros.geometry.scene._or_on_context import or_on_context
from drake_geom_ros.math import RigidTransform


class Attaching(SceneHolder):
    """Changes of a SceneGraph that pydrake lacks, where sources, frames and parents are final."""

    @or_on_context
    def RemoveSource(self, on: SceneContent, source_id: SourceId) -> list[FrameId]:
        """Remove a source with its frames and geometries; return the removed frames.

        Collision filters of its geometries are removed, too. Raises RuntimeError if the source is
        not registered, and while frames of other sources are attached to its frames.
        """
        removed = _attachments.remove_source(on.model, source_id)
        _remove_from_filters(on, removed)
        return removed.frames

    @or_on_context
    def RemoveFrame(self, on: SceneContent, source_id: SourceId, frame_id: FrameId) -> None:
        """Remove a frame with the geometries on it; all others keep their ids.

        Collision filters of its geometries are removed, too. Raises RuntimeError if the frame is
        not the source's, and while it has child frames.
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
        """Attach a frame, with its descendants, to a frame of any source, at X_PF in that one.

        X_PF becomes its pose, with which later contexts begin. With ``is_part``, sets by name that
        stand for the other frame, or for its source, include this one. A weld of the frame to the
        world ends. Collision filters do not change. Raises RuntimeError if the frame is not the
        source's, or if the other one is the world or a descendant of it.
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
        """Give a frame a permanent parent of any source, as if it had been registered there.

        An example is a robot on another one's flange. The poses X_PF, which the frame's own source
        still sets, are then those in the new parent. Raises RuntimeError if the frame is not the
        source's, is attached, or if the other one is a descendant of it.
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
        """Return an attached frame to the parent that it was registered on, at X_PF in that one.

        Raises RuntimeError if the frame is not the source's, or is not attached.
        """
        pose = checked_pose(X_PF, 'DetachFrame: X_PF')
        on.begin_at(_attachments.detach_frame(on.model, source_id, frame_id), pose)


def _remove_from_filters(on: SceneContent, removed: _attachments.Removed) -> None:
    """Remove the collision filters of removed frames and geometries."""
    for record in removed.geometries:
        if record.proximity is not None:
            on.filters.remove(record.id.get_value())
    for frame in removed.frames:
        on.filters.welded.pop(frame.get_value(), None)
