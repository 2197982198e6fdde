"""Messages of Drake's visualiser: a scene to load, and the poses of its frames.

The layout is that of Drake's ``lcmt_viewer_*``; names of types are not transmitted.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model.links import Link, links_of
from drake_geom_ros.geometry.model.properties import GeometryProperties, Role
from drake_geom_ros.geometry.model.rgba import Rgba
from drake_geom_ros.geometry.model.scene_graph_inspector import SceneGraphInspector
from drake_geom_ros.geometry.queries.query_object import QueryObject
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh
from drake_geom_ros.geometry.shapes.measures import CalcObb
from drake_geom_ros.geometry.shapes.primitives import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.shapes.sensed import SensedMap
from drake_geom_ros.geometry.visualizer._lcm_types import LcmType, TypeMember
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats

Fields = dict[str, Any]

GEOMETRY_DATA = LcmType(
    'viewer_geometry_data',
    (
        TypeMember('type', 'int8_t'),
        TypeMember('position', 'float', (3,)),
        TypeMember('quaternion', 'float', (4,)),
        TypeMember('color', 'float', (4,)),
        TypeMember('string_data', 'string'),
        TypeMember('num_float_data', 'int32_t'),
        TypeMember('float_data', 'float', ('num_float_data',)),
    ),
)
LINK_DATA = LcmType(
    'viewer_link_data',
    (
        TypeMember('name', 'string'),
        TypeMember('robot_num', 'int32_t'),
        TypeMember('num_geom', 'int32_t'),
        TypeMember('geom', GEOMETRY_DATA, ('num_geom',)),
    ),
)
LOAD_ROBOT = LcmType(
    'viewer_load_robot',
    (TypeMember('num_links', 'int32_t'), TypeMember('link', LINK_DATA, ('num_links',))),
)
DRAW = LcmType(
    'viewer_draw',
    (
        TypeMember('timestamp', 'int64_t'),
        TypeMember('num_links', 'int32_t'),
        TypeMember('link_name', 'string', ('num_links',)),
        TypeMember('robot_num', 'int32_t', ('num_links',)),
        TypeMember('position', 'float', ('num_links', 3)),
        TypeMember('quaternion', 'float', ('num_links', 4)),
    ),
)

# Larger ones do not fit the receive buffer that Linux has by default, and are lost.
MOST_BYTES = 180_000
_MILLISECONDS = 1000.0  # in a second
_BOX, _SPHERE, _CYLINDER, _MESH, _CAPSULE, _ELLIPSOID = 1, 2, 3, 4, 5, 6
_GREY = (0.9, 0.9, 0.9, 1.0)
# A box represents a half space, as in Drake; its top is the plane.
_WIDE, _THICK = 50.0, 1.0  # [m]
_FILES = ('.obj', '.gltf')  # that the visualiser reads itself


def load_message(inspector: SceneGraphInspector, role: Role) -> tuple[bytes, list[str]]:
    """Return the message that loads a scene, and warnings for geometries that it changes.

    A mesh is sent as its file if the visualiser can read that, else as triangles. If the message
    would be lost because of its size, the meshes with the most triangles become bounding boxes.
    """
    messages: list[str] = []
    world = Link(inspector.world_frame_id(), 'world', 0)
    links: list[Fields] = []
    geometries: list[tuple[GeometryId, Fields]] = []
    for link in (world, *links_of(inspector, role)):
        own = []
        for geometry in inspector.GetGeometries(link.frame, role):
            try:
                own.append((geometry, _geometry_data(inspector, geometry, role)))
            except (GeometryError, OSError) as error:
                messages.append(f'{inspector.GetName(geometry)} is not drawn: {error}')
        geometries += own
        data = [fields for _, fields in own]
        links.append(
            {'name': link.name, 'robot_num': link.group, 'num_geom': len(data), 'geom': data}
        )
    messages += _made_smaller(inspector, role, geometries, _size(links))
    message = LOAD_ROBOT.encoded({'num_links': len(links), 'link': links})
    if len(message) > MOST_BYTES:
        messages.append(
            f'the load message has {len(message)} bytes; above {MOST_BYTES} it is lost unless '
            'the listener has a larger receive buffer (sysctl net.core.rmem_default)'
        )
    return message, messages


def _size(links: list[Fields]) -> int:
    return len(LOAD_ROBOT.encoded({'num_links': len(links), 'link': links}))


def _made_smaller(
    inspector: SceneGraphInspector,
    role: Role,
    geometries: list[tuple[GeometryId, Fields]],
    size: int,
) -> list[str]:
    """Replace the largest meshes by boxes until the message is small enough; return warnings."""
    messages = []
    meshes = [(g, fields) for g, fields in geometries if fields['type'] == _MESH]
    for geometry, fields in sorted(meshes, key=lambda each: -each[1]['num_float_data']):
        if size <= MOST_BYTES:
            break
        before = fields['num_float_data']
        obb = CalcObb(inspector.GetShape(geometry))
        assert obb is not None  # a mesh has an end
        numbers = 2.0 * obb.half_width()
        X_FG = inspector.GetPoseInFrame(geometry) @ obb.pose()
        fields.update(_data(_BOX, numbers, X_FG, fields['color']))
        size -= 4 * (before - len(numbers))
        messages.append(f'{inspector.GetName(geometry)} is drawn as a box: too many triangles')
    return messages


def _geometry_data(inspector: SceneGraphInspector, geometry: GeometryId, role: Role) -> Fields:
    shape, X_FG = inspector.GetShape(geometry), inspector.GetPoseInFrame(geometry)
    properties = inspector.GetProperties(geometry, role)
    assert properties is not None  # it has the role
    colour = _colour(properties)
    if isinstance(shape, HalfSpace):
        X_FB = X_FG @ RigidTransform([0.0, 0.0, -_THICK / 2.0])
        return _data(_BOX, [_WIDE, _WIDE, _THICK], X_FB, colour)
    if isinstance(shape, (Convex, Mesh)):
        solid = role is not Role.kProximity or properties.GetPropertyOrDefault(
            'mesh', 'solid', False
        )
        return _mesh_data(shape, bool(solid), X_FG, colour)
    if isinstance(shape, SensedMap):
        return _triangle_data(shape.surface(), X_FG, colour)
    return _data(*_numbers(shape), X_FG, colour)


def _colour(properties: GeometryProperties) -> tuple[float, ...]:
    if not properties.HasProperty('phong', 'diffuse'):
        return _GREY
    value = properties.GetProperty('phong', 'diffuse')
    if isinstance(value, Rgba):
        return value.r(), value.g(), value.b(), value.a()
    return tuple(float(part) for part in value) if np.shape(value) == (4,) else _GREY


def _numbers(shape: Shape) -> tuple[int, list[float]]:
    """Return the type and the numbers of a shape."""
    if isinstance(shape, Box):
        return _BOX, [shape.width(), shape.depth(), shape.height()]
    if isinstance(shape, Sphere):
        return _SPHERE, [shape.radius()]
    if isinstance(shape, Ellipsoid):
        return _ELLIPSOID, [shape.a(), shape.b(), shape.c()]
    if isinstance(shape, (Cylinder, Capsule)):
        kind = _CYLINDER if isinstance(shape, Cylinder) else _CAPSULE
        return kind, [shape.radius(), shape.length()]
    raise GeometryError(f"Drake's visualiser has no shape for {shape!r}")


def _mesh_data(shape: Convex | Mesh, whole: bool, X_FG: RigidTransform, colour: Any) -> Fields:
    """Return a mesh: its own surface if ``whole``, else its hull as in queries."""
    own = whole and isinstance(shape, Mesh)
    if own and shape.mesh_data() is None:
        path = Path(shape.filename())
        if path.suffix.lower() in _FILES and path.is_file():
            return _data(_MESH, shape.scale3(), X_FG, colour, str(path))
    surface = shape.surface() if own else shape.hull_surface()  # type: ignore[union-attr]
    return _triangle_data(surface, X_FG, colour)


def _triangle_data(surface: tuple[Any, Any], X_FG: RigidTransform, colour: Any) -> Fields:
    vertices, triangles = surface
    numbers = [[len(vertices), len(triangles)], vertices.ravel(), triangles.ravel()]
    return _data(_MESH, np.concatenate(numbers), X_FG, colour)


def _data(kind: int, numbers: Any, X_FG: RigidTransform, colour: Any, text: str = '') -> Fields:
    position, wxyz = _position_and_wxyz(X_FG)
    return {
        'type': kind,
        'position': position,
        'quaternion': wxyz,
        'color': colour,
        'string_data': text,
        'num_float_data': len(numbers),
        'float_data': numbers,
    }


def _position_and_wxyz(X: RigidTransform) -> tuple[Floats, Floats]:
    pose = X.ToArray()
    return pose[:3], np.roll(pose[3:], 1)


def draw_messages(query: QueryObject, links: list[Link], time: float) -> list[bytes]:
    """Return the messages with the poses of links at a time [s], without those that have none."""
    placed = [link for link in links if query.is_placed(link.frame)]
    if not placed:
        return [_draw([], [], time)]
    poses = [_position_and_wxyz(query.X_WF(link.frame)) for link in placed]
    # A message may have some of the links only, so large scenes need several.
    bytes_each = max(1, len(_draw(placed, poses, time)) // len(placed))
    count = max(1, MOST_BYTES // (2 * bytes_each))
    return [
        _draw(placed[k : k + count], poses[k : k + count], time)
        for k in range(0, len(placed), count)
    ]


def _draw(links: list[Link], poses: list[tuple[Floats, Floats]], time: float) -> bytes:
    return DRAW.encoded(
        {
            'timestamp': round(_MILLISECONDS * time),
            'num_links': len(links),
            'link_name': [link.name for link in links],
            'robot_num': [link.group for link in links],
            'position': [position for position, _ in poses],
            'quaternion': [wxyz for _, wxyz in poses],
        }
    )
