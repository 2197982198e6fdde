"""The service ``check_state_validity`` with MoveIt's type: contacts of one state of the robots.

Its answer has no field for a reason, so that whatever cannot be answered raises, and the state
counts as invalid.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from types import SimpleNamespace
from typing import Any

import numpy as np

from drake_geom_ros.common.frame_names import full_name
from drake_geom_ros.geometry import ArgumentError, FrameId, GeometryId
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.scene.touch_links import carried_frames


class _Body(IntEnum):
    """Types of bodies in a ContactInformation."""

    ROBOT_LINK = 0
    WORLD_OBJECT = 1
    ROBOT_ATTACHED = 2


def check_state_validity(
    live: LiveScene, new_contact: Callable[[], Any], request: Any, response: Any
) -> None:
    """Say whether no pair overlaps at joint values, and list the contacts.

    ``new_contact`` returns an empty ContactInformation. Raises ArgumentError for what is not
    answered, and then ``valid`` stays false.
    """
    _refuse_unread(request)
    state = request.robot_state.joint_state
    joints = SimpleNamespace(names=list(state.name), positions=state.position)
    with live.reading() as scene:
        view = live.view(None, joints)
        robots = scene.model.robot_names()
        links = _links_of(scene.model.robots, request.group_name)
    if reason := view.reservations():
        raise ArgumentError(f'the scene is incomplete: {reason}')
    if stale := view.stale_frames():
        raise ArgumentError(f'poses are stale: {some_of(stale)}')
    results = view.query.ComputePointPairPenetration()
    ids = np.column_stack([results.id_A, results.id_B]).tolist()
    group = None if links is None else _frames_of(view, links)
    rows = [k for k, pair in enumerate(ids) if group is None or _is_on(view, pair, group)]
    contacts = [new_contact() for _ in rows]
    for contact, k in zip(contacts, rows, strict=True):
        contact.header.frame_id = view.moment.world_frame
        middle = 0.5 * (results.p_WCa[k] + results.p_WCb[k])
        _fill(contact.position, middle)
        _fill(contact.normal, -results.nhat_BA_W[k])  # out of the first body into the second
        contact.depth = float(results.depth[k])
        contact.contact_body_1, contact.body_type_1 = _body(view, robots, ids[k][0])
        contact.contact_body_2, contact.body_type_2 = _body(view, robots, ids[k][1])
    response.contacts = contacts
    response.valid = not contacts


def _refuse_unread(request: Any) -> None:
    state, constraints = request.robot_state, request.constraints
    if len(state.multi_dof_joint_state.joint_names):
        raise ArgumentError('robot_state.multi_dof_joint_state is not read; it must be empty')
    if len(state.attached_collision_objects):
        raise ArgumentError(
            'robot_state.attached_collision_objects are not read here; attach objects to the '
            'scene by /attached_collision_object'
        )
    kinds = ('joint', 'position', 'orientation', 'visibility')
    if filled := [k for k in kinds if len(getattr(constraints, f'{k}_constraints'))]:
        raise ArgumentError(f'constraints of {some_of(filled)} are not evaluated; give none')


def _links_of(robots: Any, group: str) -> set[tuple[str, str]] | None:
    """Return the links of a group of an SRDF by robot and name; None for the empty name."""
    if not group:
        return None
    named = {(robot.name, name): links for robot in robots for name, links in robot.groups.items()}
    chosen = [key for key in named if group in (key[1], full_name(key))]
    if len(chosen) != 1:
        raise ArgumentError(
            f'group_name is {shortened(group)!r}, which is {len(chosen)} groups; groups: '
            f'{some_of(list(map(full_name, named))) or "none"}'
        )
    return {(chosen[0][0], link) for link in named[chosen[0]]}


def _frames_of(view: SceneView, links: set[tuple[str, str]]) -> set[FrameId]:
    """Return the frames of links, and of what is attached to them."""
    inspector = view.query.inspector()
    frames = [frame for frame, label in view.names.labels.items() if label in links]
    return {each for frame in frames for each in carried_frames(inspector, frame)}


def _is_on(view: SceneView, pair: list[int], frames: set[FrameId]) -> bool:
    inspector = view.query.inspector()
    return any(inspector.GetFrameId(GeometryId(value)) in frames for value in pair)


def _body(view: SceneView, robots: set[str], value: int) -> tuple[str, int]:
    """Return the name and the type of the body that a geometry belongs to."""
    inspector = view.query.inspector()
    frame = inspector.GetFrameId(GeometryId(value))
    if frame == view.names.world:
        return view.names.name_of_value(value), _Body.WORLD_OBJECT
    source, name = view.names.labels[frame]
    if inspector.IsAttached(frame):
        return name, _Body.ROBOT_ATTACHED
    return name, _Body.ROBOT_LINK if source in robots else _Body.WORLD_OBJECT


def _fill(message: Any, vector: Any) -> None:
    message.x, message.y, message.z = map(float, vector)
