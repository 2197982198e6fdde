"""Attachments that a recorded ``~/scene`` shows, made in the played scene at the same time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from drake_geom_ros.geometry import FrameId, GeometryId
from drake_geom_ros.live.conversions.fields import pose_from_message
from drake_geom_ros.live.scene.changes.attachment import attachment, detachment
from drake_geom_ros.live.scene.held_scene import HeldScene

_Label = tuple[str, str]  # source and name of a frame


class RecordedAttachments:
    """Attaches and detaches frames as the ``~/scene`` of one node did.

    Only frames that both scenes have are followed. A frame is detached only if the recording
    showed it attached before, since a starting node has not attached anything yet.
    """

    def __init__(self) -> None:
        self._topic = ''
        self._carriers: dict[_Label, tuple[Any, ...]] = {}  # of the attached frames

    def follow(self, topic: str, message: Any, scene: HeldScene) -> Iterator[str]:
        """Have frames hang where a Scene message shows them; yield what cannot be done, in words.

        Messages of other topics than the first are ignored.
        """
        self._topic = self._topic or topic
        if topic != self._topic:
            return
        sources = {source.id: source.name for source in message.sources}
        labels = {
            frame.id: (sources.get(frame.source_id, ''), frame.name) for frame in message.frames
        }
        frames = {label: frame for frame, label in scene.model.names.labels.items()}
        for each in message.frames:
            label = labels[each.id]
            frame, parent = frames.get(label), frames.get(labels[each.parent_id])
            if frame is None:
                continue
            try:
                if not each.is_attached:
                    if self._carriers.pop(label, None) and scene.model.inspector.IsAttached(frame):
                        scene.make(detachment(scene, frame))
                elif parent is not None:
                    self._attach(label, frame, parent, each, scene)
            except RuntimeError as error:
                yield f'{topic} attaches or detaches {"::".join(label)}, which fails here: {error}'

    def _attach(
        self, label: _Label, frame: FrameId, parent: FrameId, each: Any, scene: HeldScene
    ) -> None:
        touch_links = tuple(getattr(each, 'touch_links', ()))
        # A recording of an earlier version lacks the pose: the frame stays where it is then.
        X_PF = pose_from_message(each.attached_pose) if hasattr(each, 'attached_pose') else None
        seen = parent, touch_links, None if X_PF is None else X_PF.ToArray().tobytes()
        if self._carriers.get(label) == seen:
            return
        geometries = _geometries_of(scene, touch_links)
        change = attachment(
            scene, frame, parent, X_PF, is_part=each.part_of_robot, touching=geometries
        )
        scene.make(change)
        self._carriers[label] = seen


def _geometries_of(scene: HeldScene, names: Sequence[str]) -> list[GeometryId]:
    """Return the geometries of full names; those that the scene lacks are differences anyway."""
    by_name = {name: id for id, name in scene.model.names.geometry_names.items()}
    return [by_name[name] for name in names if name in by_name]
