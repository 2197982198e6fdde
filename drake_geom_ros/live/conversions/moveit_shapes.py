"""Shapes of shape_msgs, as MoveIt's objects have them, to shapes of the core."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError, Box, Cylinder, Shape, Sphere
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.moveit_shapes import (
    CONE_NOTE,
    PlacedShape,
    cone,
    placed_body,
    placed_half_space,
)

__all__ = ['KINDS', 'PlacedShape', 'placed_mesh', 'placed_plane', 'placed_primitive']

_PRISM = 5


class _Primitive(NamedTuple):
    """A type of SolidPrimitive: its dimensions in the order of the message, and its shape."""

    kind: str
    dimensions: tuple[str, ...]
    make: Callable[..., Shape]


_PRIMITIVES = {
    1: _Primitive('box', ('x', 'y', 'z'), Box),
    2: _Primitive('sphere', ('radius',), Sphere),
    3: _Primitive('cylinder', ('height', 'radius'), lambda height, r: Cylinder(r, height)),
    4: _Primitive('cone', ('height', 'radius'), cone),
}


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
    notes = [CONE_NOTE] if kind == 'cone' else []
    if len(dimensions) > count:
        notes.append(f'has {len(dimensions)} dimensions, of which {count} count')
    return PlacedShape(kind, make(*dimensions[:count]), X_OS, note='; '.join(notes))


def placed_plane(message: Any, X_OS: RigidTransform) -> PlacedShape:
    """Return the half space behind a Plane; raises RuntimeError for what is no plane."""
    return placed_half_space(message.coef, X_OS)


def placed_mesh(message: Any, X_OS: RigidTransform) -> PlacedShape:
    """Return the body of a shape_msgs/Mesh; raises RuntimeError for one without a volume."""
    vertices = np.array([(p.x, p.y, p.z) for p in message.vertices], dtype=np.float64)
    triangles = np.array([t.vertex_indices for t in message.triangles], dtype=np.int64)
    return placed_body(vertices, triangles, X_OS)


Converter = Callable[[Any, RigidTransform], PlacedShape]
KINDS: Sequence[tuple[str, str, Converter]] = (
    ('primitives', 'primitive_poses', placed_primitive),
    ('meshes', 'mesh_poses', placed_mesh),
    ('planes', 'plane_poses', placed_plane),
)
