"""Conversion of poses, shapes and properties from and to plain YAML values.

``..._of`` converts plain values that fulfil the schema, ``plain_...`` converts back to them.
"""

import math
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    CoulombFriction,
    Cylinder,
    Ellipsoid,
    GeometryProperties,
    HalfSpace,
    HeightField,
    HydroelasticType,
    IllustrationProperties,
    Mesh,
    MeshData,
    OccupiedCells,
    PerceptionProperties,
    PointCloud,
    ProximityProperties,
    RenderLabel,
    Rgba,
    Role,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix
from drake_geom_ros.proximity_rules import SENSOR, SOLID, is_zone
from drake_geom_ros.scene_files import polygons, sensed_shapes
from drake_geom_ros.scene_files.hydroelastic import in_words, proximity_property
from drake_geom_ros.scene_files.sensed_shapes import numbers_of

Plain = Mapping[str, Any]
# Rows of a mesh written as lists; a YAML reader would take seconds for more.
_MOST_ROWS = 2000

ROLE_NAMES = {
    Role.kProximity: 'proximity',
    Role.kIllustration: 'illustration',
    Role.kPerception: 'perception',
}
_ZONE_COLOUR = (1.0, 0.7, 0.1, 0.25)
_PROPERTIES = {
    'proximity': (Role.kProximity, ProximityProperties),
    'illustration': (Role.kIllustration, IllustrationProperties),
    'perception': (Role.kPerception, PerceptionProperties),
}


def paddings_of_robot(plain: float | Plain) -> tuple[tuple[str, float], ...]:
    """Return the paddings of a robot: one for all links, or by name or pattern."""
    if not isinstance(plain, Mapping):
        return (('*', float(plain)),)
    return tuple((pattern, float(padding)) for pattern, padding in plain.items())


def pose_of(plain: Plain | None) -> RigidTransform:
    """Return a pose; a missing pose, position or orientation is the identity.

    Raises RuntimeError for a quaternion that is not unit, and for a matrix that is no rotation.
    """
    plain = plain or {}
    position = plain.get('position', (0.0, 0.0, 0.0))
    if 'rpy' in plain:
        return RigidTransform(RollPitchYaw(plain['rpy']), position)
    if 'rotation' in plain:
        return RigidTransform(RotationMatrix(plain['rotation']), position)
    return RigidTransform.FromArray([*position, *plain.get('quaternion', (0.0, 0.0, 0.0, 1.0))])


def plain_pose(X: RigidTransform) -> dict[str, Any]:
    """Return the plain form of a pose, which reads back as exactly the same numbers.

    Identity parts are omitted. The rotation is a quaternion if that converts back exactly, else
    the matrix. Zeros lose their sign.
    """
    plain: dict[str, Any] = {}
    if X.translation().any():
        plain['position'] = (X.translation() + 0.0).tolist()
    if X.rotation().IsExactlyIdentity():
        return plain
    with_quaternion = {**plain, 'quaternion': (X.ToArray()[3:] + 0.0).tolist()}
    if pose_of(with_quaternion).IsExactlyEqualTo(X):
        return with_quaternion
    return {**plain, 'rotation': (X.rotation().matrix() + 0.0).tolist()}


def shape_of(plain: Plain, find_file: Callable[[str], str], warn: Callable[[str], None]) -> Shape:
    """Return a shape from its plain form.

    ``find_file`` returns the path of a URI; ``warn`` is called with a text about skipped parts.
    Raises RuntimeError or ValueError for dimensions and files that the shape refuses.
    """
    kind = plain['type']
    if kind == 'sphere':
        return Sphere(plain['radius'])
    if kind == 'box':
        return Box(*plain['size'])
    if kind == 'capsule':
        return Capsule(plain['radius'], plain['length'])
    if kind == 'cylinder':
        return Cylinder(plain['radius'], plain['length'])
    if kind == 'ellipsoid':
        return Ellipsoid(*plain['semi_axes'])
    if kind == 'half_space':
        return HalfSpace()
    if kind == 'height_field':
        return _height_field_of(plain)
    if kind in sensed_shapes.KINDS:
        return sensed_shapes.map_of(plain, find_file, warn)
    if kind == 'polygon':
        return polygons.prism_of(plain['points'], plain['height'])
    make = Convex if kind == 'convex' else Mesh
    if 'vertices' in plain:
        data = MeshData(
            numbers_of(plain['vertices'], '<f8'), numbers_of(plain.get('triangles', ()), '<i4')
        )
        return make.FromMeshData(data, plain.get('scale', 1.0))
    return make(find_file(plain['uri']), plain.get('scale', 1.0))


def plain_shape(shape: Shape) -> dict[str, Any]:
    """Return the plain form of a shape; TypeError for a kind that the format lacks."""
    if isinstance(shape, Sphere):
        return {'type': 'sphere', 'radius': shape.radius()}
    if isinstance(shape, Box):
        return {'type': 'box', 'size': [shape.width(), shape.depth(), shape.height()]}
    if isinstance(shape, Capsule):
        return {'type': 'capsule', 'radius': shape.radius(), 'length': shape.length()}
    if isinstance(shape, Cylinder):
        return {'type': 'cylinder', 'radius': shape.radius(), 'length': shape.length()}
    if isinstance(shape, Ellipsoid):
        return {'type': 'ellipsoid', 'semi_axes': [shape.a(), shape.b(), shape.c()]}
    if isinstance(shape, HalfSpace):
        return {'type': 'half_space'}
    if isinstance(shape, HeightField):
        return _plain_height_field(shape)
    if isinstance(shape, Convex | Mesh):
        kind = 'convex' if isinstance(shape, Convex) else 'mesh'
        scales = shape.scale3().tolist()
        data = shape.mesh_data()
        if data is None:
            return {'type': kind, 'uri': shape.filename(), 'scale': scales}
        return {'type': kind, **_plain_mesh(data), 'scale': scales}
    if isinstance(shape, OccupiedCells | PointCloud):
        return sensed_shapes.plain_map(shape)
    raise TypeError(f'{type(shape).__name__} cannot be written to a scene file')


def _height_field_of(plain: Plain) -> HeightField:
    xs, ys, heights = plain['xs'], plain['ys'], plain['heights']
    if isinstance(heights, str):
        try:
            heights = np.frombuffer(b64decode(heights, validate=True), '<f8').reshape(len(xs), -1)
        except ValueError as error:
            raise ValueError(f'heights are packed as base64 of float64: {error}') from None
    elif len({len(row) for row in heights}) > 1:
        raise ValueError('heights has rows of several lengths; each has a number for each of ys')
    return HeightField(xs, ys, heights, plain['base'])


def _plain_height_field(shape: HeightField) -> dict[str, Any]:
    """Return the keys of a height field, with long heights packed."""
    heights: Any = shape.heights().tolist()
    if shape.heights().size > _MOST_ROWS:
        heights = b64encode(shape.heights().astype('<f8').tobytes()).decode()
    grid = {'xs': shape.xs().tolist(), 'ys': shape.ys().tolist()}
    return {'type': 'height_field', **grid, 'heights': heights, 'base': shape.base()}


def _plain_mesh(data: MeshData) -> dict[str, Any]:
    """Return vertices and triangles as lists, or packed if these would be long."""
    if len(data.vertices) + len(data.triangles) <= _MOST_ROWS:
        return {'vertices': data.vertices.tolist(), 'triangles': data.triangles.tolist()}
    packed = {'vertices': data.vertices.astype('<f8'), 'triangles': data.triangles.astype('<i4')}
    return {key: b64encode(values.tobytes()).decode() for key, values in packed.items()}


def roles_of_geometry(plain: Plain, shape: Shape) -> dict[Role, GeometryProperties]:
    """Return the roles of a geometry; a ``sensor`` becomes a zone, see ``proximity_rules``.

    A polygon that is not convex is a solid mesh.

    Raises ArgumentError for invalid hydroelastic properties, and ValueError for another role than
    illustration of a sensor.
    """
    is_sensor = plain.get('sensor', False)
    entries = plain.get('roles')
    roles = roles_of({'illustration': {}, **(entries or {})} if is_sensor else entries)
    if is_sensor and (others := [ROLE_NAMES[r] for r in roles if r is not Role.kIllustration]):
        raise ValueError(
            f'a sensor has the role {" and ".join(others)}; only rules see it, so it may have '
            'illustration alone'
        )
    if is_sensor:
        roles[Role.kIllustration].AddProperty(*SENSOR, True)
        if not roles[Role.kIllustration].HasProperty('phong', 'diffuse'):
            roles[Role.kIllustration].AddProperty('phong', 'diffuse', Rgba(*_ZONE_COLOUR))
    measured = roles.get(Role.kIllustration if is_sensor else Role.kProximity)
    is_polygon = plain['shape']['type'] == 'polygon' and isinstance(shape, Mesh)
    if is_polygon and measured is not None and not measured.HasProperty(*SOLID):
        measured.AddProperty(*SOLID, True)
    return roles


def roles_of(plain: Plain | None) -> dict[Role, GeometryProperties]:
    """Return roles with their properties; only the proximity role if ``plain`` is None.

    Raises ArgumentError for invalid hydroelastic properties.
    """
    roles: dict[Role, GeometryProperties] = {}
    for name, groups in ({'proximity': {}} if plain is None else plain).items():
        role, make = _PROPERTIES[name]
        roles[role] = make()
        for group, values in groups.items():
            for key, value in values.items():
                value = _property_of(value)
                if role is Role.kProximity:
                    value = proximity_property(group, key, value)
                roles[role].AddProperty(group, key, value)
    return roles


def _property_of(value: Any) -> Any:
    if isinstance(value, Mapping):
        if 'rgba' in value:
            return Rgba(*value['rgba'])
        return set(value['set']) if 'set' in value else np.array(value['array'], dtype=float)
    return value


def plain_roles(roles: Mapping[Role, GeometryProperties]) -> dict[str, Any] | None:
    """Return the plain form of roles; None for only the proximity role without properties.

    Raises TypeError for a property whose value cannot be written to a scene file.
    """
    plain = {
        ROLE_NAMES[role]: _plain_groups(properties)
        for role, properties in sorted(roles.items(), key=lambda item: int(item[0]))
    }
    if is_zone(roles):  # which the key sensor says
        group, name = SENSOR
        del plain['illustration'][group][name]
        plain['illustration'] = {
            g: values for g, values in plain['illustration'].items() if values
        }
    return None if plain == {'proximity': {}} else plain


def _plain_groups(properties: GeometryProperties) -> dict[str, dict[str, Any]]:
    groups = {}
    for group in sorted(properties.GetGroupNames()):
        values = properties.GetPropertiesInGroup(group)
        if values:
            groups[group] = {
                key: _plain_property(values[key].get_value(), key) for key in sorted(values)
            }
    return groups


def _plain_property(value: Any, key: str) -> Any:
    if isinstance(value, Rgba):
        return {'rgba': [value.r(), value.g(), value.b(), value.a()]}
    if _is_scalar(value) or (isinstance(value, list) and all(map(_is_scalar, value))):
        return value
    if isinstance(value, HydroelasticType):
        return in_words(value)
    if isinstance(value, CoulombFriction):
        return [value.static_friction(), value.dynamic_friction()]
    if isinstance(value, RenderLabel) and not value.is_reserved():
        return int(value)
    if isinstance(value, set) and all(isinstance(item, str) for item in value):
        return {'set': sorted(value)}
    if isinstance(value, np.ndarray) and value.dtype == float and value.ndim in (1, 2):
        plain = value.tolist()
        if np.isfinite(value).all():
            return {'array': plain}
    raise TypeError(
        f'property {key!r} = {value!r}; a scene file holds bool, int of 64 bits, finite float, '
        'str, lists of these, sets of str, Rgba, HydroelasticType, CoulombFriction, and finite '
        'float arrays of one or two dimensions'
    )


def _is_scalar(value: Any) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, int):
        return -(2**63) <= value < 2**63
    return isinstance(value, str)
