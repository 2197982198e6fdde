"""What a scene is made of, and who holds it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model._records import FrameRecord, Versions

if TYPE_CHECKING:
    from drake_geom_ros.geometry._proximity.filters.state import FilterState
    from drake_geom_ros.geometry.model._model import Model
    from drake_geom_ros.math import RigidTransform


class ContentMark(NamedTuple):
    """A model, and the versions that it and its filters were at."""

    model: Model
    versions: Versions
    filters: int


class SceneContent:
    """A model and the filters of its pairs: what rooms hand around behind a scene or a context.

    ``copied_from`` is what a content that is a copy was copied from, as that was then.
    """

    copied_from: ContentMark | None = None

    def __init__(self, model: Model, filters: FilterState) -> None:
        self.model = model
        self.filters = filters

    def mark(self) -> ContentMark:
        """Return what this content is now."""
        return ContentMark(self.model, self.model.versions.copy(), self.filters.version)

    def take_over(self, copy: SceneContent) -> bool:
        """Become what a copy has become that nobody uses from now on, if this is as it was.

        Return whether it was.
        """
        if copy.copied_from is None or copy.copied_from.model is not self.model:
            return False
        if copy.copied_from != self.mark():
            return False
        vars(self.model).update(vars(copy.model))  # for all who hold this very model
        self.filters.become(copy.filters)
        return True

    def copy(self) -> SceneContent:
        """Return a content that shares nothing that either could change."""
        return SceneContent(self.model.copy(), self.filters.copy())

    def begin_at(self, frame: FrameRecord, X_PF: RigidTransform) -> None:
        """Pose a frame that has another parent now, and end its weld to the world."""
        self.model.first_X_PFs[frame.id] = X_PF
        if frame.id.get_value() in self.filters.welded:
            self.unweld(frame.id.get_value())

    def unweld(self, frame: int) -> None:
        """End the weld of a frame, by the value of its id, to the world."""
        self.filters.unweld(frame, proximity_keys_on(self.model, FrameId(frame)))


def proximity_keys_on(model: Model, frame_id: FrameId) -> list[int]:
    """Return the id values of the geometries on a frame that take part in proximity queries."""
    on_it = model.geometries_on(frame_id)
    return [record.id.get_value() for record in on_it if record.proximity is not None]


class SceneHolder:
    """Who holds a scene: a scene graph, or a context with a copy of it."""

    _state: SceneContent


def content_of(holder: SceneHolder) -> SceneContent:
    """Return what a scene graph or a context holds, for the rooms that act on it."""
    return holder._state
