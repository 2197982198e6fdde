"""moveit_msgs/PlanningScene to requests, by duck type."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from drake_geom_ros.common.counting import counted
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
    request_from_message,
)
from drake_geom_ros.live.conversions.names import shortened


@dataclass(frozen=True)
class SceneRequest:
    """A PlanningScene: objects in their order, first those that links carry.

    - ``clears_world``, ``clears_attached``: which objects go before.
    - ``matrix``: the allowed collisions, None where they stay as they are.
    - ``notes``: in words, what nobody reads, and what is read otherwise.
    """

    attached: tuple[AttachedRequest, ...]
    objects: tuple[ObjectRequest, ...]
    clears_world: bool
    clears_attached: bool
    matrix: AllowedCollisions | None
    notes: tuple[str, ...]


def scene_from_message(message: Any) -> SceneRequest:
    """Return what a PlanningScene asks for.

    Raises ArgumentError for what cannot be, and for paddings, scales and an octomap.
    """
    _refuse_unread(message)
    state, matrix = message.robot_state, message.allowed_collision_matrix
    has_state = bool(
        len(state.joint_state.name)
        or len(state.multi_dof_joint_state.joint_names)
        or len(state.attached_collision_objects)
    )
    attached = [attached_from_message(each) for each in state.attached_collision_objects]
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
        tuple(map(request_from_message, message.world.collision_objects)),
        clears_world=not message.is_diff,
        clears_attached=(has_state or not message.is_diff) and not state.is_diff,
        matrix=allowed,
        notes=tuple(notes),
    )


def _refuse_unread(message: Any) -> None:
    """Raise ArgumentError for parts without which the scene would seem freer than it is."""
    for each in message.link_padding:
        if each.padding != 0.0:
            raise ArgumentError(
                f'link_padding of {shortened(each.link_name)!r} is {each.padding:g}; paddings of '
                'planning scenes are not read: give it by the key padding of the robot in the '
                'scene file'
            )
    for scale in message.link_scale:
        if scale.scale != 1.0:
            raise ArgumentError(
                f'link_scale of {shortened(scale.link_name)!r} is {scale.scale:g}; links are not '
                'scaled: give a padding by the key padding of the robot in the scene file'
            )
    if len(message.world.octomap.octomap.data):
        raise ArgumentError(
            'world.octomap: octomaps of planning scenes are not read; send it on '
            '~/obstacles/octomap, or name its topic in obstacle_sources'
        )


def _ignored(message: Any) -> list[str]:
    state, notes = message.robot_state, []
    joints = len(state.joint_state.name) + len(state.multi_dof_joint_state.joint_names)
    if joints:
        notes.append(
            f'values of {counted(joints, "joint")} are ignored: the node hears them as joint '
            'states'
        )
    if len(message.fixed_frame_transforms):
        notes.append('fixed_frame_transforms are ignored: frames are those of the scene')
    if len(message.object_colors):
        notes.append('object_colors are not kept')
    return notes
