"""Shapes of shape_msgs, as MoveIt's objects have them, to shapes of the core."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    Convex,
    Cylinder,
    HalfSpace,
    Mesh,
    MeshData,
    MeshFileError,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.tolerances import UNIT_NORM

_CONE_SIDES = 64
_PRISM = 5


class PlacedShape(NamedTuple):
    """A shape S of an object O; ``is_solid`` is the property ('mesh', 'solid') of a mesh.

    ``note`` says in words how it differs from what the message says, empty where it does not.
    """

    kind: str
    shape: Shape
    X_OS: RigidTransform
    is_solid: bool = False
    note: str = ''


class _Primitive(NamedTuple):
    """A type of SolidPrimitive: its dimensions in the order of the message, and its shape."""

    kind: str
    dimensions: tuple[str, ...]
    make: Callable[..., Shape]


def _cone(height: float, radius: float) -> Shape:
    """Return the pyramid around a cone, whose bounding box is centred at the origin.

    Its sides touch the cone, so that the pyramid holds the whole cone.
    """
    if not (0.0 < height < math.inf and 0.0 < radius < math.inf):
        raise ArgumentError(
            f'a cone has a height of {height} and a radius of {radius}; both must be > 0 [m]'
        )
    angles = np.arange(_CONE_SIDES) * (2.0 * math.pi / _CONE_SIDES)
    outer = radius / math.cos(math.pi / _CONE_SIDES)
    base = [outer * np.cos(angles), outer * np.sin(angles), np.full(_CONE_SIDES, -0.5 * height)]
    return Convex(points=np.column_stack([np.array(base), [0.0, 0.0, 0.5 * height]]), label='cone')


_PRIMITIVES = {
    1: _Primitive('box', ('x', 'y', 'z'), Box),
    2: _Primitive('sphere', ('radius',), Sphere),
    3: _Primitive('cylinder', ('height', 'radius'), lambda height, r: Cylinder(r, height)),
    4: _Primitive('cone', ('height', 'radius'), _cone),
}
_CONE_NOTE = (
    f'counts as the pyramid of {_CONE_SIDES} sides around it, whose radius is larger by up to '
    f'{100.0 * (1.0 / math.cos(math.pi / _CONE_SIDES) - 1.0):.2g} %'
)


def placed_primitive(message: Any, X_OS: RigidTransform) -> PlacedShape:
    """Return the shape of a SolidPrimitive; raises RuntimeError for what is none."""
    primitive = _PRIMITIVES.get(message.type)
    if primitive is None:
        names = ', '.join(f'{number} ({each.kind})' for number, each in _PRIMITIVES.items())
        prism = ' (a prism, which MoveIt does not take either)' if message.type == _PRISM else ''
        raise ArgumentError(f'its type is {message.type}{prism}; it must be one of {names}')
    kind, names_of_dimensions, make = primitive
    dimensions = list(map(float, message.dimensions))
    count = len(names_of_dimensions)
    if len(dimensions) < count:
        raise ArgumentError(
            f'dimensions holds {len(dimensions)} numbers; a {kind} takes: '
            f'{", ".join(names_of_dimensions)}'
        )
    notes = [_CONE_NOTE] if kind == 'cone' else []
    if len(dimensions) > count:
        notes.append(f'has {len(dimensions)} dimensions, of which {count} count')
    return PlacedShape(kind, make(*dimensions[:count]), X_OS, note='; '.join(notes))


def placed_plane(message: Any, X_OS: RigidTransform) -> PlacedShape:
    """Return the half space behind a Plane a x + b y + c z + d = 0 with the normal (a, b, c).

    Raises RuntimeError for coefficients that are no plane.
    """
    coefficients = np.asarray(message.coef, dtype=np.float64)
    if coefficients.shape != (4,) or not np.isfinite(coefficients).all():
        raise ArgumentError(f'coef is {coefficients.tolist()}; it must be four finite numbers')
    normal, offset = coefficients[:3], float(coefficients[3])
    length = float(np.linalg.norm(normal))
    if not 0.0 < length < math.inf:
        raise ArgumentError(f'coef is {coefficients.tolist()}; its normal must not be 0')
    nhat = normal / length
    R_SH = RotationMatrix.MakeFromOneVector(nhat, 2)
    X_SH = RigidTransform(R_SH, -offset / length * nhat)
    note = 'counts as the half space behind it'
    if abs(length - 1.0) > UNIT_NORM:
        note += f'; its normal is {length:g} long'
    return PlacedShape('plane', HalfSpace(), X_OS @ X_SH, note=note)


def placed_mesh(message: Any, X_OS: RigidTransform) -> PlacedShape:
    """Return the solid that the triangles of a shape_msgs/Mesh enclose, or their convex hull.

    Raises RuntimeError for triangles without a volume.
    """
    vertices = np.array([(p.x, p.y, p.z) for p in message.vertices], dtype=np.float64)
    triangles = np.array([t.vertex_indices for t in message.triangles], dtype=np.int64)
    if not vertices.size or not triangles.size:
        raise ArgumentError(
            f'it holds {len(vertices)} vertices and {len(triangles)} triangles; it must have both'
        )
    if not np.isfinite(vertices).all():
        raise ArgumentError('a vertex is not finite')
    data = MeshData(vertices, triangles.reshape(-1, 3))
    solid = Mesh.FromMeshData(data)
    try:
        solid.weldings()
    except MeshFileError as open_surface:
        hull = Convex.FromMeshData(data)
        hull.hull_surface()
        note = f'counts as its convex hull, for its triangles enclose no body: {open_surface}'
        return PlacedShape('mesh', hull, X_OS, note=note)
    return PlacedShape('mesh', solid, X_OS, is_solid=True)


Converter = Callable[[Any, RigidTransform], PlacedShape]
KINDS: Sequence[tuple[str, str, Converter]] = (
    ('primitives', 'primitive_poses', placed_primitive),
    ('meshes', 'mesh_poses', placed_mesh),
    ('planes', 'plane_poses', placed_plane),
)
