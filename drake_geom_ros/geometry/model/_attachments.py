"""Removal of sources and frames from a model, and attachment of frames to others."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.common.counting import are, counted
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


class RemovedObjects(NamedTuple):
    """Frames and geometries that were removed with a source or a frame."""

    frames: list[FrameId]
    geometries: list[GeometryRecord]


def remove_source(model: Model, source_id: SourceId) -> RemovedObjects:
    """Remove a source with its frames and its geometries, anchored ones included.

    Raises GeometryError for the source of the world frame, and OwnershipError while frames of
    other sources are attached to its frames, or mounted on them.
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
        raise OwnershipError(_refusal(model, name, guests))
    geometries = [g for g in model.geometries.values() if g.source_id == source_id]
    removed = _drop(model, frames, geometries)
    del model.sources[source_id]
    model.source_names.remove(name)
    return removed


def remove_frame(model: Model, source_id: SourceId, frame_id: FrameId) -> RemovedObjects:
    """Remove a frame and the geometries on it.

    Raises OwnershipError for a frame that is not the source's, and GeometryError while it has
    child frames.
    """
    frame = model.owned_frame(source_id, frame_id)
    hanging = [named(other) for other in model.frames.values() if other.parent_id == frame_id]
    if hanging:
        raise GeometryError(
            f'RemoveFrame: {", ".join(hanging[:5])} {"hang" if len(hanging) > 1 else "hangs"} on '
            f'{named(frame)}; remove or detach {"them" if len(hanging) > 1 else "it"} first'
        )
    return _drop(model, [frame_id], [model.geometries[id] for id in frame.geometry_ids])


def _drop(model: Model, frames: list[FrameId], geometries: list[GeometryRecord]) -> RemovedObjects:
    """Remove frames without other children, and geometries, with all that refers to them."""
    for record in geometries:
        model.children.pop(record.id, None)
        for role in record.roles():
            del model.geometry_names[record.frame_id, role, record.name]
        del model.frames[record.frame_id].geometry_ids[record.id]
        del model.geometries[record.id]
    for id in frames:
        frame = model.frames.pop(id)
        model.frame_names.remove((frame.source_id, frame.name))
        model.first_X_PFs.pop(id, None)
    roles = {role for record in geometries for role in record.roles()}
    model.changed_geometries(geometries, roles, frames=bool(frames))
    return RemovedObjects(frames, geometries)


def attach_frame(
    model: Model, source_id: SourceId, frame_id: FrameId, parent_id: FrameId, *, is_part: bool
) -> FrameRecord:
    """Attach a frame to one of any source, as a part of it or not, and return its record.

    Raises OwnershipError for a frame that is not the source's, ArgumentError if the other one is
    the world or a descendant of the frame.
    """
    frame, parent = model.owned_frame(source_id, frame_id), model.frame(parent_id)
    if parent_id == WORLD_FRAME_ID:
        raise ArgumentError(
            f'AttachFrame: {named(frame)} cannot be attached to the world frame; DetachFrame puts '
            'it back on the frame that it was registered on'
        )
    _refuse_ring(model, frame, parent, 'AttachFrame')
    if frame.home_id is None:
        frame.home_id = frame.parent_id
    frame.is_part = is_part
    _hang_on(model, frame, parent_id)
    return frame


def mount_frame(model: Model, source_id: SourceId, frame_id: FrameId, parent_id: FrameId) -> None:
    """Give a frame a parent of any source, as if it had been registered on it.

    Raises OwnershipError for a frame that is not the source's, GeometryError for one that is
    attached, and ArgumentError if the new parent is a descendant of the frame.
    """
    frame, parent = model.owned_frame(source_id, frame_id), model.frame(parent_id)
    if frame.home_id is not None:
        raise GeometryError(f'MountFrame: {named(frame)} is attached to a frame; detach it first')
    _refuse_ring(model, frame, parent, 'MountFrame')
    _hang_on(model, frame, parent_id)


def detach_frame(model: Model, source_id: SourceId, frame_id: FrameId) -> FrameRecord:
    """Return a frame to the parent that it was registered on, and return its record.

    Raises OwnershipError for a frame that is not the source's, and GeometryError for one that is
    not attached.
    """
    frame = model.owned_frame(source_id, frame_id)
    if frame.home_id is None:
        raise GeometryError(f'DetachFrame: {named(frame)} is not attached to a frame')
    home_id, frame.home_id, frame.is_part = frame.home_id, None, False
    _hang_on(model, frame, home_id)
    return frame


def _refuse_ring(model: Model, frame: FrameRecord, parent: FrameRecord, call: str) -> None:
    """Raise ArgumentError if the new parent is a descendant of the frame."""
    above = parent
    while above.id != WORLD_FRAME_ID:
        if above.id == frame.id:
            raise ArgumentError(
                f'{call}: {named(parent)} hangs on {named(frame)}, which cannot follow it'
            )
        above = model.frames[above.parent_id]


def _refusal(model: Model, name: str, guests: list[FrameRecord]) -> str:
    """Return the error text for a source with child frames of other sources."""
    reasons = []
    attached = [frame for frame in guests if frame.home_id is not None]
    if attached:
        them = 'it' if len(attached) == 1 else 'them'
        reasons.append(
            f'{", ".join(map(named, attached))} of other sources '
            f'{"is" if len(attached) == 1 else "are"} attached to its frames; detach {them} first '
            '(DetachFrame)'
        )
    mounted = [frame for frame in guests if frame.home_id is None]
    if mounted:
        sources = dict.fromkeys(model.source_name(frame.source_id) for frame in mounted)
        reasons.append(
            f'{counted(len(mounted), "frame")} of {", ".join(map(repr, sources))} '
            f'{are(len(mounted))} mounted on its frames; remove {", ".join(map(repr, sources))} '
            'first'
        )
    return f'RemoveSource of {name!r}: {", and ".join(reasons)}'


def _hang_on(model: Model, frame: FrameRecord, parent_id: FrameId) -> None:
    """Give a frame another parent, and move it and its descendants behind that one."""
    frame.parent_id = parent_id
    below = {frame.id}
    for id, other in model.frames.items():
        if other.parent_id in below and id != WORLD_FRAME_ID:
            below.add(id)
    # Frames are ordered parents first, and must stay so.
    for id in [id for id in model.frames if id in below]:
        model.frames[id] = model.frames.pop(id)
    model.first_X_PFs.pop(frame.id, None)
    model.changed(frames=True, reordered=True)
