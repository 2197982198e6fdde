"""The service ``check_state_validity`` with MoveIt's type: contacts of one state of the robots.

Cost sources are those of MoveIt with FCL: of each contact the box that the boxes of both bodies
along the world's axes have in common, with a density of 1, the largest first.

Its answer has no field for a reason, so that whatever cannot be answered raises, and the state
counts as invalid.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import IntEnum
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.common.frame_names import full_name
from drake_geom_ros.geometry import (
    ArgumentError,
    CalcObb,
    Convex,
    FrameId,
    GeometryId,
    HalfSpace,
    Mesh,
    Sphere,
)
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.conversions.request_types import StateValidityRequest
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.multi_dof_joints import multi_dof_joints
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.scene.world_objects import objects_of
from drake_geom_ros.live.services.moved_frames import root_by_virtual_joint
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import ZERO_COMPONENT
from drake_geom_ros.scene_files import carried_frames


class _Body(IntEnum):
    """Types of bodies in a ContactInformation."""

    ROBOT_LINK = 0
    WORLD_OBJECT = 1
    ROBOT_ATTACHED = 2


class ValidityMessages(NamedTuple):
    """Constructors of an empty ContactInformation and an empty CostSource."""

    new_contact: Callable[[], Any]
    new_cost_source: Callable[[], Any]


def check_state_validity(
    live: LiveScene, messages: ValidityMessages, request: StateValidityRequest, response: Any
) -> None:
    """Say whether no pair overlaps at joint values, and list the contacts and cost sources.

    Raises ArgumentError for what is not answered, and then ``valid`` stays false.
    """
    _refuse_unread(request)
    with live.reading() as scene:
        _refuse_strangers(scene, request.robot_state.attached_collision_objects)
        view = live.view(*_posed(scene, request.robot_state))
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
    contacts = [messages.new_contact() for _ in rows]
    for contact, k in zip(contacts, rows, strict=True):
        contact.header.frame_id = view.moment.world_frame
        middle = 0.5 * (results.p_WCa[k] + results.p_WCb[k])
        _fill(contact.position, middle)
        _fill(contact.normal, -results.nhat_BA_W[k])  # out of the first body into the second
        contact.depth = float(results.depth[k])
        contact.contact_body_1, contact.body_type_1 = _body(view, robots, ids[k][0])
        contact.contact_body_2, contact.body_type_2 = _body(view, robots, ids[k][1])
    response.contacts = contacts
    boxes = [_common_box(view, *map(GeometryId, ids[k])) for k in rows]
    boxes.sort(key=lambda box: -float(np.prod(box[1] - box[0])))
    response.cost_sources = [messages.new_cost_source() for _ in boxes]
    for source, (low, high) in zip(response.cost_sources, boxes, strict=True):
        source.cost_density = 1.0
        _fill(source.aabb_min, low)
        _fill(source.aabb_max, high)
    response.valid = not contacts


def _common_box(view: SceneView, id_A: GeometryId, id_B: GeometryId) -> tuple[Floats, Floats]:
    """Return the corners (3,) [m] of what the boxes of two geometries have in common."""
    if isinstance(view.query.inspector().GetShape(id_A), HalfSpace):
        id_A, id_B = id_B, id_A  # two of them have no pair
    (low, high), padding_B = _box(view, id_A), _padding(view, id_B)
    if isinstance(view.query.inspector().GetShape(id_B), HalfSpace):
        X_WB = view.query.X_WG(id_B)
        normal = X_WB.rotation().matrix()[:, 2]
        offset = float(normal @ X_WB.translation()) + padding_B
        low, high = _below(normal, offset, low, high)
    else:
        low_B, high_B = _box(view, id_B)
        low, high = np.maximum(low, low_B), np.minimum(high, high_B)
    return low, np.maximum(low, high)  # of bodies that barely touch, within rounding


def _below(normal: Floats, offset: float, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return the corners of the part of a box in the half space of points p, normal.p <= offset.

    On each axis the others are where they leave it the most room.
    """
    low, high, lowest = low.copy(), high.copy(), np.minimum(normal * low, normal * high)
    for k in np.flatnonzero(np.abs(normal) > ZERO_COMPONENT):
        limit = (offset - (lowest.sum() - lowest[k])) / normal[k]
        if normal[k] > 0.0:
            high[k] = min(high[k], limit)
        else:
            low[k] = max(low[k], limit)
    return low, high


def _box(view: SceneView, id: GeometryId) -> tuple[Floats, Floats]:
    """Return the corners of a box in the world around a geometry that ends, with its padding."""
    shape, X_WG = view.query.inspector().GetShape(id), view.query.X_WG(id)
    if isinstance(shape, Convex | Mesh):  # of which an oriented box takes milliseconds
        points = X_WG.multiply(shape.hull_surface()[0].T)
        low, high = points.min(axis=1), points.max(axis=1)
    else:
        obb = CalcObb(shape)
        assert obb is not None, 'a half space has no box'
        R_WB = np.eye(3) if isinstance(shape, Sphere) else X_WG.rotation().matrix()
        centre, half = X_WG.multiply(obb.center()), np.abs(R_WB) @ obb.half_width()
        low, high = centre - half, centre + half
    padding = _padding(view, id)
    return low - padding, high + padding


def _padding(view: SceneView, id: GeometryId) -> float:
    properties = view.query.inspector().GetProximityProperties(id)
    assert properties is not None, 'it is in a contact'
    return float(properties.GetPropertyOrDefault('proximity', 'padding', 0.0))


def _refuse_unread(request: StateValidityRequest) -> None:
    constraints = request.constraints
    kinds = ('joint', 'position', 'orientation', 'visibility')
    if filled := [k for k in kinds if len(getattr(constraints, f'{k}_constraints'))]:
        raise ArgumentError(f'constraints of {some_of(filled)} are not evaluated; give none')


def _refuse_strangers(scene: HeldScene, attached: Iterable[Any]) -> None:
    """Raise ArgumentError for attached objects other than those that links of the scene carry."""
    held, names = objects_of(scene), scene.model.names
    for each in attached:
        there = held.get(each.object.id)
        link = None if there is None else there.link
        if link is None or each.link_name not in (names.labels[link][1], names.frame_names[link]):
            raise ArgumentError(
                f'robot_state attaches {shortened(each.object.id)!r} to '
                f'{shortened(each.link_name)!r}, which the scene does not; attach it by '
                '/attached_collision_object'
            )


def _posed(scene: HeldScene, state: Any) -> tuple[Any, Any]:
    """Return the root links that virtual joints pose, and values of joints, as a view takes them.

    Raises ArgumentError for a joint of several values that is none of the scene.
    """
    several, own = state.multi_dof_joint_state, state.joint_state
    names, positions = list(own.name), list(own.position)
    frames, rows = list[str](), list[float]()
    joints, place = multi_dof_joints(scene.model.joints), 'robot_state.multi_dof_joint_state'
    if len(several.joint_names) != len(several.transforms):
        raise ArgumentError(
            f'{place} has {len(several.joint_names)} names and {len(several.transforms)} '
            'transforms; it must have one for each'
        )
    for name, transform in zip(several.joint_names, several.transforms, strict=True):
        matches = [joint for joint in joints if name in (joint.name, joint.full_name)]
        root = root_by_virtual_joint(scene, name)
        if len(matches) == 1:
            names += matches[0].columns
            positions += matches[0].values(transform, place).tolist()
        elif root is not None:
            frames.append(scene.model.names.frame_names[root])
            p, q = transform.translation, transform.rotation
            rows += [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
        else:
            raise ArgumentError(f'{place}: {shortened(name)!r} is no joint of a robot here')
    frame_id = several.header.frame_id.removeprefix('/')
    if frames and frame_id not in ('', scene.model.world_frame):
        raise ArgumentError(
            f'{place} is measured in {shortened(frame_id)!r}; give it in the world frame, '
            f'{scene.model.world_frame!r}'
        )
    header = SimpleNamespace(frame_id=scene.model.world_frame, stamp=own.header.stamp)
    poses = SimpleNamespace(header=header, source='', frame_names=frames, frame_ids=[], poses=rows)
    return poses if frames else None, SimpleNamespace(names=names, positions=positions)


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
