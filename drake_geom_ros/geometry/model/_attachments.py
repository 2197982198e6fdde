"""Changes of a model that concern all that a source has, or whom a frame follows."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry.errors import ArgumentError, GeometryError, OwnershipError
from drake_geom_ros.geometry.ids import FrameId, SourceId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model._records import (
    INTERNAL_SOURCE_NAME,
    WORLD_FRAME_ID,
    FrameRecord,
    GeometryRecord,
    named,
)


class Removed(NamedTuple):
    """What went with a source."""

    frames: list[FrameId]
    geometries: list[GeometryRecord]


def remove_source(model: Model, source_id: SourceId) -> Removed:
    """Remove a source, its frames, and its geometries, anchored ones as well.

    Raises GeometryError for the source of the world frame, and OwnershipError while frames of
    other sources are attached to its frames.
    """
    name = model.source_name(source_id)
    if name == INTERNAL_SOURCE_NAME:
        raise GeometryError(f'RemoveSource: {name!r} owns the world frame and stays')
    frames = model.frames_of_source(source_id)
    gone = set(frames)
    guests = [
        frame
        for frame in model.frames.values()
        if frame.parent_id in gone and frame.source_id != source_id
    ]
    if guests:
        raise OwnershipError(
            f'RemoveSource of {name!r}: {", ".join(map(named, guests))} of other sources '
            f'{"is" if len(guests) == 1 else "are"} attached to its frames; detach '
            f'{"it" if len(guests) == 1 else "them"} first (DetachFrame)'
        )
    geometries = [g for g in model.geometries.values() if g.source_id == source_id]
    for record in geometries:
        model.children.pop(record.id, None)
        for role in record.roles():
            del model.geometry_names[record.frame_id, role, record.name]
        del model.frames[record.frame_id].geometry_ids[record.id]
        del model.geometries[record.id]
    for frame in frames:
        model.frame_names.remove((source_id, model.frames.pop(frame).name))
        model.first_X_PFs.pop(frame, None)
    del model.sources[source_id]
    model.source_names.remove(name)
    model.changed(
        frames=bool(frames), roles={role for record in geometries for role in record.roles()}
    )
    return Removed(frames, geometries)


def attach_frame(
    model: Model, source_id: SourceId, frame_id: FrameId, parent_id: FrameId
) -> FrameRecord:
    """Let a frame follow another one, of any source; return its record.

    Raises OwnershipError for a frame that is not the source's, ArgumentError where the other one
    is the world or hangs on the frame itself.
    """
    frame, parent = model.owned_frame(source_id, frame_id), model.frame(parent_id)
    if parent_id == WORLD_FRAME_ID:
        raise ArgumentError(
            f'AttachFrame: {named(frame)} cannot be attached to the world frame; DetachFrame puts '
            'it back on the frame that it was registered on'
        )
    above = parent
    while above.id != WORLD_FRAME_ID:
        if above.id == frame_id:
            raise ArgumentError(
                f'AttachFrame: {named(parent)} hangs on {named(frame)}, which cannot follow it'
            )
        above = model.frames[above.parent_id]
    if frame.home_id is None:
        frame.home_id = frame.parent_id
    _hang_on(model, frame, parent_id)
    return frame


def detach_frame(model: Model, source_id: SourceId, frame_id: FrameId) -> FrameRecord:
    """Put a frame back on the one that it was registered on; return its record.

    Raises OwnershipError for a frame that is not the source's, and GeometryError for one that is
    not attached.
    """
    frame = model.owned_frame(source_id, frame_id)
    if frame.home_id is None:
        raise GeometryError(f'DetachFrame: {named(frame)} is not attached to a frame')
    home_id, frame.home_id = frame.home_id, None
    _hang_on(model, frame, home_id)
    return frame


def _hang_on(model: Model, frame: FrameRecord, parent_id: FrameId) -> None:
    """Give a frame another parent; it comes after that one, and what hangs on it after it."""
    frame.parent_id = parent_id
    below = {frame.id}
    for id, other in model.frames.items():
        if other.parent_id in below and id != WORLD_FRAME_ID:
            below.add(id)
    # Registration order put a parent before its children, and this keeps it so.
    for id in [id for id in model.frames if id in below]:
        model.frames[id] = model.frames.pop(id)
    model.first_X_PFs.pop(frame.id, None)
    model.changed(frames=True)
