"""moveit_msgs/PlanningScene to requests, by duck type."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.allowed_collisions import (
    AllowedCollisions,
    allowed_from_message,
)
from drake_geom_ros.live.conversions.collision_objects import (
    AttachedRequest,
    ObjectRequest,
    Operation,
    attached_from_message,
    is_own,
    pose_or_no_rotation,
    request_from_message,
)
from drake_geom_ros.live.conversions.names import shortened
from drake_geom_ros.live.conversions.octomap import cells_from_octomap, refuse_too_many_nodes
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensed_maps import Cells


@dataclass(frozen=True)
class OctomapRequest:
    """The octomap M of a scene, measured in a frame F; without ``cells`` the map goes."""

    frame: str = ''
    X_FM: RigidTransform = field(default_factory=RigidTransform)
    cells: Cells | None = None


@dataclass(frozen=True)
class SceneRequest:
    """A PlanningScene: objects in their order, first those that links carry.

    - ``clears_world``, ``clears_attached``: which objects go before.
    - ``matrix``: the allowed collisions, None where they stay as they are.
    - ``paddings`` [m], ``scales`` [-]: of links by name, of those that the message names.
    - ``octomap``: None where it stays as it is.
    - ``state``: the RobotState.
    - ``notes``: in words, what nobody reads, and what is read otherwise.
    """

    attached: tuple[AttachedRequest, ...]
    objects: tuple[ObjectRequest, ...]
    clears_world: bool
    clears_attached: bool
    matrix: AllowedCollisions | None
    paddings: Mapping[str, float]
    scales: Mapping[str, float]
    octomap: OctomapRequest | None
    state: Any
    notes: tuple[str, ...]


def scene_from_message(message: Any, node: str = '') -> SceneRequest:
    """Return what a PlanningScene asks for; raises RuntimeError for what cannot be.

    Objects that a ``node`` published itself are left out.
    """
    state, matrix = message.robot_state, message.allowed_collision_matrix
    has_state = bool(
        len(state.joint_state.name)
        or len(state.multi_dof_joint_state.joint_names)
        or len(state.attached_collision_objects)
    )
    attached = [
        attached_from_message(each)
        for each in state.attached_collision_objects
        if not is_own(each.object, node)
    ]
    for each in attached:
        if not state.is_diff and each.object.operation != Operation.ADD:
            raise ArgumentError(
                f'object {shortened(each.object.id)!r}: {each.object.operation.name} in a '
                'robot_state that is no diff, where MoveIt takes ADD alone; set its is_diff'
            )
    allowed, notes = None, _ignored(message)
    if len(matrix.entry_names) or not message.is_diff:
        allowed, more = allowed_from_message(matrix)
        notes += more
    elif len(matrix.default_entry_names):
        notes.append('a matrix of defaults alone is ignored in a diff, as by MoveIt')
    return SceneRequest(
        tuple(attached),
        tuple(
            request_from_message(each)
            for each in message.world.collision_objects
            if not is_own(each, node)
        ),
        clears_world=not message.is_diff,
        clears_attached=(has_state or not message.is_diff) and not state.is_diff,
        matrix=allowed,
        paddings=_enlargements(message.link_padding, 'padding', 0.0, notes),
        scales=_enlargements(message.link_scale, 'scale', 1.0, notes),
        octomap=_octomap(message),
        state=state,
        notes=tuple(notes),
    )


def _enlargements(
    messages: Iterable[Any], name: str, least: float, notes: list[str]
) -> dict[str, float]:
    """Return paddings or scales by link; what would make a link smaller counts as ``least``."""
    values = {}
    for each in messages:
        value, link = float(getattr(each, name)), shortened(each.link_name)
        if not math.isfinite(value):
            raise ArgumentError(f'link_{name} of {link!r} is {value}; it must be finite')
        if value < least:
            notes.append(
                f'link_{name} of {link!r} is {value:g} and counts as {least:g}: links are not '
                'made smaller'
            )
        values[each.link_name] = max(value, least)
    return values


def _octomap(message: Any) -> OctomapRequest | None:
    """Return what becomes of the octomap: a diff without one leaves it, as in MoveIt."""
    octomap = message.world.octomap.octomap
    if message.is_diff and not (octomap.id or len(octomap.data)):
        return None
    if not len(octomap.data):
        return OctomapRequest()
    place = message.world.octomap
    try:
        refuse_too_many_nodes(octomap)
        cells = cells_from_octomap(octomap)
        X_FM, _ = pose_or_no_rotation(place.origin, 'origin')
    except RuntimeError as error:
        raise ArgumentError(f'world.octomap: {error}') from error
    frame = place.header.frame_id or octomap.header.frame_id
    return OctomapRequest(frame, X_FM, cells if len(cells) else None)


def _ignored(message: Any) -> list[str]:
    notes = []
    if len(message.fixed_frame_transforms):
        notes.append('fixed_frame_transforms are ignored: frames are those of the scene')
    if len(message.object_colors):
        notes.append('object_colors are not kept')
    return notes
