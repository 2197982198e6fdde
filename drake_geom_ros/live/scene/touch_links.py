"""The filters of attached frames that may touch something."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from drake_geom_ros.geometry import FilterId, FrameId
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.scene_files import TouchLinks


class AttachmentFilters:
    """The filters of attached frames that may touch something."""

    def __init__(self, model: SceneModel) -> None:
        self._model = model
        self._by_frame: dict[FrameId, TouchLinks] = {}

    def begin(self, frame: FrameId, touch_links: TouchLinks) -> None:
        """Keep the filter of an attachment."""
        self._by_frame[frame] = touch_links

    def end(self, frame: FrameId) -> None:
        """Forget the filter of a frame, which was removed or never was."""
        self._by_frame.pop(frame, None)

    def forget(self, frames: Iterable[FrameId]) -> list[FilterId]:
        """Remove the filters of frames that have gone; return those that were active."""
        gone = [self._by_frame.pop(frame) for frame in frames if frame in self._by_frame]
        return self._model.filter_manager.RemoveDeclarations(each.filter_id for each in gone)

    def filter_of(self, frame: FrameId) -> FilterId | None:
        """Return the filter of an attached frame; None: it has none, or it ended."""
        touch_links = self._by_frame.get(frame)
        if touch_links is None or not self._model.filter_manager.IsActive(touch_links.filter_id):
            return None
        return touch_links.filter_id

    def names(self) -> Mapping[FrameId, tuple[str, ...]]:
        """Return what each frame whose filter is active may touch, by full names."""
        return {
            frame: each.names for frame, each in self._by_frame.items() if self.filter_of(frame)
        }
