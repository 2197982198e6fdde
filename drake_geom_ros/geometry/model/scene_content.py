"""``SceneContent``: the model and the filters behind a scene graph or a context."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model._records import (
    WORLD_FRAME_ID,
    FrameRecord,
    GeometryRecord,
    Versions,
)

if TYPE_CHECKING:
    from drake_geom_ros.geometry._proximity.filters.state import FilterState
    from drake_geom_ros.geometry.model._model import Model
    from drake_geom_ros.math import RigidTransform


class ContentMark(NamedTuple):
    """A model, with its version and that of its filters."""

    model: Model
    versions: Versions
    filters: int


class SceneContent:
    """A model and the filters of its pairs, shared by the classes behind a scene or a context.

    ``copied_from`` is the mark of the original of a copy, at the time of the copy. ``former`` is
    what a copy that was taken over replaced. It ends with the copy: to free thousands of records
    takes long, and who takes over may hold what others wait for.
    """

    copied_from: ContentMark | None = None
    former: object = None

    def __init__(self, model: Model, filters: FilterState) -> None:
        self.model = model
        self.filters = filters

    def mark(self) -> ContentMark:
        """Return the mark of the current content."""
        return ContentMark(self.model, self.model.versions.copy(), self.filters.version)

    def take_over(self, copy: SceneContent) -> bool:
        """Adopt the state of a copy that is no longer used, unless this content has changed.

        Return whether it did.
        """
        if copy.copied_from is None or copy.copied_from.model is not self.model:
            return False
        if copy.copied_from != self.mark():
            return False
        copy.former = {**vars(self.model)}, {**vars(self.filters)}
        vars(self.model).update(vars(copy.model))  # in place: others refer to this model
        self.filters.become(copy.filters)
        return True

    def copy(self) -> SceneContent:
        """Return an independent copy."""
        return SceneContent(self.model.copy(), self.filters.copy())

    def begin_at(self, frame: FrameRecord, X_PF: RigidTransform) -> None:
        """Set the first pose of a frame in its new parent, and end its weld to the world."""
        self.model.first_X_PFs[frame.id] = X_PF
        if frame.id.get_value() in self.filters.welded:
            self.unweld(frame.id.get_value())

    def unweld(self, frame: int) -> None:
        """End the weld to the world of a frame, by its id value."""
        self.filters.unweld(frame, proximity_keys_on(self.model, FrameId(frame)))


def add_to_filters(on: SceneContent, record: GeometryRecord) -> None:
    """Add a geometry that got the proximity role to the filters."""
    key, frame = record.id.get_value(), record.frame_id
    on.filters.add(key, frame.get_value(), anchored=frame == WORLD_FRAME_ID)


def proximity_keys_on(model: Model, frame_id: FrameId) -> list[int]:
    """Return the id values of the geometries with the proximity role on a frame."""
    on_it = model.geometries_on(frame_id)
    return [record.id.get_value() for record in on_it if record.proximity is not None]


class SceneHolder:
    """Base of holders of a scene: a scene graph, or a context with a copy of it."""

    _state: SceneContent


def content_of(holder: SceneHolder) -> SceneContent:
    """Return the content of a scene graph or a context, for the packages that work on it."""
    return holder._state
