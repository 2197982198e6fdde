"""Shape messages to shapes and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    MeshData,
    OccupiedCells,
    PointCloud,
    Shape,
    ShapeKind,
    Sphere,
)
from drake_geom_ros.live.conversions.fields import fill_floats, floats, uint32s
from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.conversions.message_types import ShapeMessage

# Shape.type, the class, and the names of its dimensions in the message's order.
_PRIMITIVES: tuple[tuple[int, type, tuple[str, ...]], ...] = (
    (ShapeKind.SPHERE, Sphere, ('radius',)),
    (ShapeKind.BOX, Box, ('width', 'depth', 'height')),
    (ShapeKind.CAPSULE, Capsule, ('radius', 'length')),
    (ShapeKind.CYLINDER, Cylinder, ('radius', 'length')),
    (ShapeKind.ELLIPSOID, Ellipsoid, ('a', 'b', 'c')),
    (ShapeKind.HALF_SPACE, HalfSpace, ()),
)
_CELLS, _POINTS = ShapeKind.OCCUPIED_CELLS, ShapeKind.POINT_CLOUD
_MAPS: dict[int, type[OccupiedCells] | type[PointCloud]] = {
    _CELLS: OccupiedCells,
    _POINTS: PointCloud,
}


def shape_from_message(message: ShapeMessage, files: FileAccess) -> Shape:
    """Return the shape of a Shape message; raises RuntimeError for what is none.

    A mesh comes as numbers, or as a file that ``files`` lets be opened.
    """
    for number, shape_class, dimensions in _PRIMITIVES:
        if message.type == number:
            if len(message.dimensions) != len(dimensions):
                names = ', '.join(dimensions) or 'none'
                raise ArgumentError(
                    f'shape.dimensions holds {len(message.dimensions)} numbers; '
                    f'{shape_class.__name__} takes: {names}'
                )
            shape: Shape = shape_class(*map(float, message.dimensions))
            return shape
    if message.type in _MAPS:
        make = _MAPS[message.type]
        if len(message.dimensions) != 1:
            raise ArgumentError(
                f'shape.dimensions holds {len(message.dimensions)} numbers; {make.__name__} takes '
                'one'
            )
        return make(float(message.dimensions[0]), _rows('vertices', message.vertices, np.float64))
    if message.type in (ShapeKind.CONVEX, ShapeKind.SOLID):
        return _mesh_from_message(message, files)
    raise ArgumentError(
        f'shape.type is {message.type}; it must be a constant of Shape, 1 to 8, 10 or 11'
    )


def _mesh_from_message(message: ShapeMessage, files: FileAccess) -> Shape:
    """Return the Convex or Mesh of a Shape message: of its file, or of its vertices."""
    make = Convex if message.type == ShapeKind.CONVEX else Mesh
    if len(message.dimensions) not in (0, 1, 3):
        raise ArgumentError(
            f'shape.dimensions holds {len(message.dimensions)} numbers; CONVEX and MESH take one '
            'scale, one for each of x, y, z, or none'
        )
    scales = list(map(float, message.dimensions)) or [1.0]
    scale = scales[0] if len(scales) == 1 else scales
    inline = len(message.vertices) > 0
    if inline == bool(message.mesh_uri):
        raise ArgumentError(
            'shape.mesh_uri and shape.vertices are both given or both empty; a CONVEX or MESH is '
            'one or the other'
        )
    if inline:
        vertices = _rows('vertices', message.vertices, np.float64)
        triangles = _rows('triangles', message.triangles, np.int64)
        if message.type == ShapeKind.SOLID and not len(triangles):
            raise ArgumentError('shape.triangles is empty; a MESH of vertices has triangles')
        return make.FromMeshData(MeshData(vertices, triangles), scale)
    if '://' not in message.mesh_uri and not message.mesh_uri.startswith('/'):
        raise ArgumentError(f'shape.mesh_uri {message.mesh_uri!r} is not an absolute path')
    return make(str(files.file(message.mesh_uri, 'shape.mesh_uri')), scale)


def _rows(name: str, flat: Any, kind: type) -> NDArray[Any]:
    """Return a flat array field as rows of three."""
    values: NDArray[Any] = np.asarray(flat, dtype=kind)
    if values.size % 3:
        raise ArgumentError(f'shape.{name} holds {values.size} numbers; it must hold 3 per row')
    return values.reshape(-1, 3)


def fill_shape(message: Any, shape: Shape) -> None:
    """Fill a Shape message."""
    for number, shape_class, dimensions in _PRIMITIVES:
        if isinstance(shape, shape_class):
            message.type = number
            message.dimensions = floats(np.array([getattr(shape, d)() for d in dimensions]))
            return
    if isinstance(shape, OccupiedCells | PointCloud):
        if isinstance(shape, OccupiedCells):
            message.type, size, places = _CELLS, shape.resolution(), shape.centres()
        else:
            message.type, size, places = _POINTS, shape.radius(), shape.positions()
        message.dimensions = floats(np.array([size]))
        fill_floats(message.vertices, places)
        return
    message.type = ShapeKind.CONVEX if isinstance(shape, Convex) else ShapeKind.SOLID
    assert isinstance(shape, (Convex, Mesh)), f'a shape without a number: {shape!r}'
    scales = shape.scale3()
    message.dimensions = floats(scales[:1] if (scales == scales[0]).all() else scales)
    data = shape.mesh_data()
    if data is None:
        message.mesh_uri = shape.filename()
    else:
        fill_floats(message.vertices, data.vertices)
        message.triangles = uint32s(data.triangles)
