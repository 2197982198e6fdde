"""Roles and the whole scene: messages to values of the core and back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import (
    ArgumentError,
    CoulombFriction,
    FrameId,
    GeometryId,
    GeometryInstance,
    GeometryProperties,
    HydroelasticType,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    Rgba,
    Role,
    SceneGraphInspector,
)
from drake_geom_ros.live.conversions.fields import fill_pose, fill_pose_row
from drake_geom_ros.live.conversions.message_types import RoleMessage
from drake_geom_ros.live.conversions.shapes import fill_shape
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.batched import poses_from_matrices
from drake_geom_ros.scene_files.hydroelastic import in_words, proximity_property


class Attachment(NamedTuple):
    """The pose of an attached frame in its carrier, and what it may touch."""

    X_PF: RigidTransform
    touch_links: tuple[str, ...] = ()  # full names of geometries


_ROLES: tuple[tuple[int, Role, type[GeometryProperties]], ...] = (
    (1, Role.kProximity, ProximityProperties),
    (2, Role.kIllustration, IllustrationProperties),
    (3, Role.kPerception, PerceptionProperties),
)

# rcl_interfaces/ParameterType: the field of ParameterValue that holds the value.
_VALUE_FIELDS = {
    1: 'bool_value',
    2: 'integer_value',
    3: 'double_value',
    4: 'string_value',
    5: 'byte_array_value',
    6: 'bool_array_value',
    7: 'integer_array_value',
    8: 'double_array_value',
    9: 'string_array_value',
}


def role_from_number(number: int) -> Role:
    """Return the Role of a constant of the Role message."""
    for constant, role, _ in _ROLES:
        if number == constant:
            return role
    raise ArgumentError(
        f'role is {number}; it must be 1 (PROXIMITY), 2 (ILLUSTRATION) or 3 (PERCEPTION)'
    )


def properties_from_message(message: RoleMessage) -> GeometryProperties:
    """Return the properties of a Role message, of the class of its role."""
    role_from_number(message.role)
    properties = next(kind for number, _, kind in _ROLES if number == message.role)()
    for entry in message.properties:
        group = entry.group or GeometryProperties.default_group_name()
        field = _VALUE_FIELDS.get(entry.value.type)
        if field is None:
            raise ArgumentError(
                f"property ('{group}', '{entry.name}') has value type {entry.value.type}; it must "
                'be a constant of rcl_interfaces/ParameterType other than NOT_SET'
            )
        value = getattr(entry.value, field)
        if not isinstance(value, (bool, int, float, str)):
            # Bytes come one by one; they are kept as numbers, which a scene file can hold.
            value = [item[0] if isinstance(item, bytes) else item for item in value]
        _check_finite(group, entry.name, value)
        if isinstance(properties, ProximityProperties):
            value = proximity_property(group, entry.name, value)
        properties.AddProperty(group, entry.name, value)
    return properties


def _check_finite(group: str, name: str, value: Any) -> None:
    """Raise ArgumentError for numbers that no scene file can hold."""
    for item in value if isinstance(value, list) else [value]:
        if isinstance(item, float) and not math.isfinite(item):
            raise ArgumentError(f"property ('{group}', '{name}') is {item}; it must be finite")


def set_role(instance: GeometryInstance, message: RoleMessage) -> None:
    """Give an instance the role of a Role message; raises RuntimeError where it has it already."""
    properties = properties_from_message(message)
    name = role_from_number(message.role).name.removeprefix('k').lower()
    if getattr(instance, f'{name}_properties')() is not None:
        raise ArgumentError(f'roles names the role {message.role} ({name}) twice')
    getattr(instance, f'set_{name}_properties')(properties)


def _fill_value(message: Any, value: Any) -> None:
    """Fill a ParameterValue with a property of any type; a type it does not know as its text."""
    if isinstance(value, HydroelasticType):
        value = in_words(value)
    if isinstance(value, CoulombFriction):
        value = [value.static_friction(), value.dynamic_friction()]
    if isinstance(value, Rgba):
        value = [value.r(), value.g(), value.b(), value.a()]
    if isinstance(value, (set, frozenset)) and all(isinstance(item, str) for item in value):
        value = sorted(value)
    items = value if isinstance(value, (list, tuple, np.ndarray)) else [value]
    kinds = ((bool, 1, 6), (int, 2, 7), ((int, float), 3, 8), (str, 4, 9))
    items = [item.item() if isinstance(item, np.generic) else item for item in items]
    for kind, single, several in kinds:
        if items and all(
            isinstance(item, kind) and (kind is bool or not isinstance(item, bool))
            for item in items
        ):
            message.type = single if items == [value] else several
            if message.type in (3, 8):
                items = [float(item) for item in items]
            filled = items[0] if message.type == single else items
            setattr(message, _VALUE_FIELDS[message.type], filled)
            return
    message.type, message.string_value = 4, str(value)


def fill_roles(message: Any, inspector: SceneGraphInspector, id: GeometryId, types: Any) -> None:
    """Append a Role for each role of a geometry to a SceneGeometry's ``roles``."""
    for number, role, _ in _ROLES:
        properties = inspector.GetProperties(id, role)
        if properties is None:
            continue
        entry = types.Role(role=number)
        for group in sorted(properties.GetGroupNames()):
            for name, value in sorted(properties.GetPropertiesInGroup(group).items()):
                filled = types.Property(group=group, name=name)
                _fill_value(filled.value, value.get_value())
                entry.properties.append(filled)
        message.roles.append(entry)


def fill_scene(
    message: Any,
    inspector: SceneGraphInspector,
    types: Any,
    attachments: Mapping[FrameId, Attachment] = MappingProxyType({}),
) -> None:
    """Fill a Scene message; ``types`` holds the classes of the messages inside.

    ``attachments`` are those of attached frames.
    """
    for source in sorted(inspector.GetAllSourceIds()):
        message.sources.append(
            types.SceneSource(id=source.get_value(), name=inspector.GetName(source))
        )
    world = inspector.world_frame_id()
    for frame in inspector.FramesParentsFirst():
        filled = _frame_message(inspector, frame, world, types)
        if (attachment := attachments.get(frame)) is not None:
            fill_pose(filled.attached_pose, attachment.X_PF)
            filled.touch_links = list(attachment.touch_links)
        message.frames.append(filled)
    geometries = sorted(inspector.GetAllGeometryIds())
    poses = [inspector.GetPoseInFrame(geometry) for geometry in geometries]
    Rs = np.array([X.rotation().matrix() for X in poses]).reshape(-1, 3, 3)
    rows = poses_from_matrices(Rs, np.array([X.translation() for X in poses]).reshape(-1, 3))
    for geometry, row in zip(geometries, rows, strict=True):
        entry = types.SceneGeometry(
            id=geometry.get_value(),
            name=inspector.GetName(geometry),
            source_id=inspector.GetOwningSourceId(geometry).get_value(),
            frame_id=inspector.GetFrameId(geometry).get_value(),
        )
        fill_pose_row(entry.pose, row)
        fill_shape(entry.shape, inspector.GetShape(geometry))
        fill_roles(entry, inspector, geometry, types)
        message.geometries.append(entry)


def _frame_message(
    inspector: SceneGraphInspector, frame: FrameId, world: FrameId, types: Any
) -> Any:
    """Return the SceneFrame message of a frame; the world names itself as its parent."""
    parent = world if frame == world else inspector.GetParentFrame(frame)
    return types.SceneFrame(
        id=frame.get_value(),
        name=inspector.GetName(frame),
        source_id=inspector.GetOwningSourceId(frame).get_value(),
        parent_id=parent.get_value(),
        is_attached=inspector.IsAttached(frame),
        part_of_robot=inspector.IsPartOfParent(frame),
        frame_group=inspector.GetFrameGroup(frame),
    )
