"""Shapes, roles and the whole scene: messages to values of the core and back, no ROS import."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    FrameId,
    GeometryId,
    GeometryInstance,
    GeometryProperties,
    HalfSpace,
    IllustrationProperties,
    Mesh,
    PerceptionProperties,
    ProximityProperties,
    Rgba,
    Role,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from drake_geom_ros.ros.conversions import fill_pose, floats
from drake_geom_ros.scene_files import ResourceResolver

# Shape.type, the class, and the names of its dimensions in the message's order.
_PRIMITIVES: tuple[tuple[int, type, tuple[str, ...]], ...] = (
    (1, Sphere, ('radius',)),
    (2, Box, ('width', 'depth', 'height')),
    (3, Capsule, ('radius', 'length')),
    (4, Cylinder, ('radius', 'length')),
    (5, Ellipsoid, ('a', 'b', 'c')),
    (6, HalfSpace, ()),
)
_CONVEX, _MESH = 7, 8

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


def shape_from_message(message: Any) -> Shape:
    """Return the shape of a Shape message; raises RuntimeError for what is none."""
    for number, shape_class, dimensions in _PRIMITIVES:
        if message.type == number:
            if len(message.dimensions) != len(dimensions):
                names = ', '.join(dimensions) or 'none'
                raise ArgumentError(
                    f'shape.dimensions holds {len(message.dimensions)} numbers; '
                    f'{shape_class.__name__} takes: {names}'
                )
            return shape_class(*map(float, message.dimensions))
    if message.type in (_CONVEX, _MESH):
        return _mesh_from_message(message)
    raise ArgumentError(f'shape.type is {message.type}; it must be a constant of Shape, 1 to 8')


def _mesh_from_message(message: Any) -> Shape:
    """Return the Convex or Mesh of a Shape message that names a file."""
    if len(message.vertices) or len(message.triangles) or not message.mesh_uri:
        raise ArgumentError(
            'shape.mesh_uri must name the file of a CONVEX or MESH (file://, package:// or an '
            'absolute path); vertices inside the message are not taken yet'
        )
    if len(message.dimensions) > 1:
        raise ArgumentError(
            f'shape.dimensions holds {len(message.dimensions)} numbers; CONVEX and MESH take one '
            'scale, or none'
        )
    if '://' not in message.mesh_uri and not message.mesh_uri.startswith('/'):
        raise ArgumentError(f'shape.mesh_uri {message.mesh_uri!r} is not an absolute path')
    try:
        path = ResourceResolver().resolve(message.mesh_uri, Path('/'))
    except ValueError as error:
        raise ArgumentError(f'shape.mesh_uri: {error}') from None
    scale = float(message.dimensions[0]) if len(message.dimensions) else 1.0
    return (Convex if message.type == _CONVEX else Mesh)(str(path), scale)


def fill_shape(message: Any, shape: Shape) -> None:
    """Fill a Shape message."""
    for number, shape_class, dimensions in _PRIMITIVES:
        if isinstance(shape, shape_class):
            message.type = number
            message.dimensions = floats(np.array([getattr(shape, d)() for d in dimensions]))
            return
    message.type = _CONVEX if isinstance(shape, Convex) else _MESH
    assert isinstance(shape, (Convex, Mesh)), f'a shape without a number: {shape!r}'
    message.dimensions = floats(np.array([shape.scale()]))
    message.mesh_uri = shape.filename()


def role_from_number(number: int) -> Role:
    """Return the Role of a constant of the Role message."""
    for constant, role, _ in _ROLES:
        if number == constant:
            return role
    raise ArgumentError(
        f'role is {number}; it must be 1 (PROXIMITY), 2 (ILLUSTRATION) or 3 (PERCEPTION)'
    )


def properties_from_message(message: Any) -> GeometryProperties:
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
            value = list(value)
        properties.AddProperty(group, entry.name, value)
    return properties


def set_role(instance: GeometryInstance, message: Any) -> None:
    """Give an instance the role of a Role message; raises RuntimeError where it has it already."""
    properties = properties_from_message(message)
    name = role_from_number(message.role).name.removeprefix('k').lower()
    if getattr(instance, f'{name}_properties')() is not None:
        raise ArgumentError(f'roles names the role {message.role} ({name}) twice')
    getattr(instance, f'set_{name}_properties')(properties)


def _fill_value(message: Any, value: Any) -> None:
    """Fill a ParameterValue with a property of any type; a type it does not know as its text."""
    if isinstance(value, Rgba):
        value = [value.r(), value.g(), value.b(), value.a()]
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
                _fill_value(filled.value, value)
                entry.properties.append(filled)
        message.roles.append(entry)


def fill_scene(message: Any, inspector: SceneGraphInspector, types: Any) -> None:
    """Fill a Scene message; ``types`` holds the classes of the messages inside."""
    for source in sorted(inspector.GetAllSourceIds()):
        message.sources.append(
            types.SceneSource(id=source.get_value(), name=inspector.GetName(source))
        )
    world = inspector.world_frame_id()
    for frame in inspector.GetAllFrameIds():
        message.frames.append(_frame_message(inspector, frame, world, types))
    for geometry in sorted(inspector.GetAllGeometryIds()):
        entry = types.SceneGeometry(
            id=geometry.get_value(),
            name=inspector.GetName(geometry),
            source_id=inspector.GetOwningSourceId(geometry).get_value(),
            frame_id=inspector.GetFrameId(geometry).get_value(),
        )
        fill_pose(entry.pose, inspector.GetPoseInFrame(geometry))
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
        frame_group=inspector.GetFrameGroup(frame),
    )
