"""moveit_msgs/CollisionObject and AttachedCollisionObject to requests, by duck type."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Any

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.fields import pose_from_message
from drake_geom_ros.live.conversions.moveit_shapes import KINDS, PlacedShape
from drake_geom_ros.live.conversions.names import shortened
from drake_geom_ros.math import RigidTransform

OCTOMAP_ID = '<octomap>'  # of MoveIt's own map
OWN_TYPE = 'drake_geom_ros'  # the key of the type of objects of a node, whose name is their db


class Operation(IntEnum):
    """The operations of a CollisionObject, by their numbers in the message."""

    ADD = 0
    REMOVE = 1
    APPEND = 2
    MOVE = 3


@dataclass(frozen=True)
class ObjectRequest:
    """A CollisionObject: what to do with the object O, whose pose is measured in a frame F.

    - ``shapes``, ``subframes``: those that an ADD or APPEND brings; poses are in O.
    - ``shape_poses``: those that a MOVE brings, X_OS, for all shapes of the object or for none.
    - ``has_pose``: whether the object's own pose is another one than the identity.
    - ``notes``: in words, what the message says and nobody reads, and what is read otherwise.
    """

    id: str
    operation: Operation
    frame: str = ''
    X_FO: RigidTransform = field(default_factory=RigidTransform)
    shapes: tuple[PlacedShape, ...] = ()
    subframes: Mapping[str, RigidTransform] = field(default_factory=dict, hash=False)
    shape_poses: tuple[RigidTransform, ...] = ()
    has_pose: bool = False
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class AttachedRequest:
    """An AttachedCollisionObject: the object, the link that carries it, and what it may touch."""

    object: ObjectRequest
    link: str
    touch_links: tuple[str, ...]


def request_from_message(message: Any) -> ObjectRequest:
    """Return what a CollisionObject asks for; raises ArgumentError, which names the object."""
    operation = _operation(message)
    _check_id(message.id, operation)
    if operation == Operation.REMOVE:
        return ObjectRequest(message.id, operation)
    try:
        request = _read(message, operation)
    except RuntimeError as error:
        raise ArgumentError(f'object {shortened(message.id)!r}: {error}') from error
    notes = list(request.notes)
    if message.type.key or message.type.db:
        notes.append(f'its type {message.type.key!r} of the database is not kept')
    named = tuple(f'object {shortened(message.id)!r}: {note}' for note in notes)
    return replace(request, notes=named)


def is_own(message: Any, node: str) -> bool:
    """Return whether a CollisionObject is one that a node published, and that comes back."""
    is_marked = (message.type.key, message.type.db) == (OWN_TYPE, node)
    return bool(node) and is_marked and _operation(message) != Operation.REMOVE


def attached_from_message(message: Any) -> AttachedRequest:
    """Return what an AttachedCollisionObject asks for; raises ArgumentError like the other."""
    request = request_from_message(message.object)
    ignored = []
    if message.detach_posture.joint_names:
        ignored.append('its detach_posture is not kept')
    if message.weight:
        ignored.append(f'its weight of {message.weight:g} kg is not kept')
    notes = tuple(f'object {shortened(message.object.id)!r}: {note}' for note in ignored)
    request = replace(request, notes=request.notes + notes)
    return AttachedRequest(request, message.link_name, tuple(message.touch_links))


def _operation(message: Any) -> Operation:
    """Return an operation, which rclpy brings as one byte."""
    value = message.operation
    number = value[0] if isinstance(value, bytes) and len(value) == 1 else value
    try:
        return Operation(number)
    except ValueError:
        allowed = ', '.join(f'{each.value} ({each.name})' for each in Operation)
        raise ArgumentError(
            f'object {shortened(message.id)!r}: operation is {number!r}; it must be one of '
            f'{allowed}'
        ) from None


def _check_id(name: str, operation: Operation) -> None:
    """Raise ArgumentError for what cannot be the id of an object."""
    if name == OCTOMAP_ID:
        raise ArgumentError(f'object {name!r}: MoveIt reserves this id for its octomap')
    if not name and operation != Operation.REMOVE:
        raise ArgumentError(f'an object to {operation.name} has an empty id; it needs one')
    if name != name.strip(' \t') or '\0' in name:
        raise ArgumentError(
            f'object {shortened(name)!r}: an id has no space or tab at its ends, and no NUL'
        )


def _read(message: Any, operation: Operation) -> ObjectRequest:
    """Return an ADD, APPEND or MOVE; raises RuntimeError for what cannot be."""
    X_FO, notes = pose_or_no_rotation(message.pose, 'pose')
    base = ObjectRequest(
        message.id,
        operation,
        message.header.frame_id,
        X_FO,
        has_pose=not _is_empty(message.pose),
        notes=tuple(notes),
    )
    for shapes, poses, _ in KINDS:
        count, most = len(getattr(message, poses)), len(getattr(message, shapes))
        if count > most and operation != Operation.MOVE:
            raise ArgumentError(f'{poses} holds {count} poses for {most} {shapes}')
    if operation == Operation.MOVE:
        return _read_move(message, base)
    if not any(len(getattr(message, shapes)) for shapes, _, _ in KINDS):
        return _with_subframes(message, base)
    return _with_subframes(message, _with_shapes(message, base))


def _read_move(message: Any, base: ObjectRequest) -> ObjectRequest:
    notes, shape_poses = list(base.notes), []
    for shapes, poses, _ in KINDS:
        if len(getattr(message, shapes)):
            notes.append(f'a MOVE takes poses only, so its {shapes} are ignored, as by MoveIt')
        for k, each in enumerate(getattr(message, poses)):
            X_OS, more = pose_or_no_rotation(each, f'{poses}[{k}]')
            shape_poses.append(X_OS)
            notes += more
    if len(message.subframe_names):
        notes.append('a MOVE takes poses only, so its subframes are ignored, as by MoveIt')
    return replace(base, shape_poses=tuple(shape_poses), notes=tuple(notes))


def _with_shapes(message: Any, base: ObjectRequest) -> ObjectRequest:
    """Return a request with its shapes.

    The pose of a lone shape counts as the object's where that is the identity, as for MoveIt.
    """
    placed, notes = [], list(base.notes)
    is_lone = sum(len(getattr(message, shapes)) for shapes, _, _ in KINDS) == 1
    for shapes, poses, convert in KINDS:
        places = getattr(message, poses)
        for k, each in enumerate(getattr(message, shapes)):
            X_OS, more = RigidTransform(), list[str]()
            if k < len(places):
                X_OS, more = pose_or_no_rotation(places[k], f'{poses}[{k}]')
            if is_lone and not base.has_pose:
                base = replace(base, X_FO=X_OS, has_pose=not X_OS.IsExactlyIdentity())
                X_OS = RigidTransform()
            try:
                shape = convert(each, X_OS)
            except RuntimeError as error:
                raise ArgumentError(f'{shapes}[{k}]: {error}') from error
            notes += more + ([f'{shapes}[{k}] {shape.note}'] if shape.note else [])
            placed.append(shape)
    return replace(base, shapes=tuple(placed), notes=tuple(notes))


def _with_subframes(message: Any, base: ObjectRequest) -> ObjectRequest:
    names = list(message.subframe_names)
    if len(names) != len(message.subframe_poses):
        raise ArgumentError(
            f'subframe_poses holds {len(message.subframe_poses)} poses for {len(names)} '
            'subframe_names'
        )
    if len(set(names)) < len(names) or not all(name.strip(' \t') for name in names):
        raise ArgumentError(f'subframe_names is {names}; each must be another one, and not empty')
    subframes, notes = {}, list(base.notes)
    for k, (name, message_pose) in enumerate(zip(names, message.subframe_poses, strict=True)):
        subframes[name], more = pose_or_no_rotation(message_pose, f'subframe_poses[{k}]')
        notes += more
    return replace(base, subframes=subframes, notes=tuple(notes))


def pose_or_no_rotation(message: Any, name: str) -> tuple[RigidTransform, list[str]]:
    """Return a pose and notes; a quaternion of zeros counts as no rotation, as for MoveIt."""
    q = message.orientation
    if (q.x, q.y, q.z, q.w) == (0.0, 0.0, 0.0, 0.0):
        p = message.position
        X = RigidTransform.FromArray([p.x, p.y, p.z, 0.0, 0.0, 0.0, 1.0])
        return X, [f'the quaternion of {name} is 0 and counts as no rotation']
    try:
        return pose_from_message(message), []
    except RuntimeError as error:
        raise ArgumentError(f'{name}: {error}') from error


def _is_empty(message: Any) -> bool:
    p, q = message.position, message.orientation
    at_origin = (p.x, p.y, p.z) == (0.0, 0.0, 0.0)
    return at_origin and (q.x, q.y, q.z) == (0.0, 0.0, 0.0) and q.w in (0.0, 1.0)
