"""Shapes as MoveIt's messages and files have them: cones, planes, triangles of bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

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
    MeshFileError,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.tolerances import UNIT_NORM

CONE_SIDES = 64


class PlacedShape(NamedTuple):
    """A shape S of an object O; ``is_solid`` is the property ('mesh', 'solid') of a mesh.

    ``note`` says in words how it differs from what the message says, empty where it does not.
    """

    kind: str
    shape: Shape
    X_OS: RigidTransform
    is_solid: bool = False
    note: str = ''


def cone(height: float, radius: float) -> Shape:
    """Return the pyramid around a cone, whose bounding box is centred at the origin.

    Its sides touch the cone, so that the pyramid holds the whole cone.
    """
    if not (0.0 < height < math.inf and 0.0 < radius < math.inf):
        raise ArgumentError(
            f'a cone has a height of {height} and a radius of {radius}; both must be > 0 [m]'
        )
    angles = np.arange(CONE_SIDES) * (2.0 * math.pi / CONE_SIDES)
    outer = radius / math.cos(math.pi / CONE_SIDES)
    base = [outer * np.cos(angles), outer * np.sin(angles), np.full(CONE_SIDES, -0.5 * height)]
    return Convex(points=np.column_stack([np.array(base), [0.0, 0.0, 0.5 * height]]), label='cone')


CONE_NOTE = (
    f'counts as the pyramid of {CONE_SIDES} sides around it, whose radius is larger by up to '
    f'{100.0 * (1.0 / math.cos(math.pi / CONE_SIDES) - 1.0):.2g} %'
)


def placed_half_space(coefficients: ArrayLike, X_OS: RigidTransform) -> PlacedShape:
    """Return the half space behind a plane a x + b y + c z + d = 0 with the normal (a, b, c).

    Raises RuntimeError for coefficients that are no plane.
    """
    coef = np.asarray(coefficients, dtype=np.float64)
    if coef.shape != (4,) or not np.isfinite(coef).all():
        raise ArgumentError(f'coef is {coef.tolist()}; it must be four finite numbers')
    normal, offset = coef[:3], float(coef[3])
    length = float(np.linalg.norm(normal))
    if not 0.0 < length < math.inf:
        raise ArgumentError(f'coef is {coef.tolist()}; its normal must not be 0')
    nhat = normal / length
    R_SH = RotationMatrix.MakeFromOneVector(nhat, 2)
    X_SH = RigidTransform(R_SH, -offset / length * nhat)
    note = 'counts as the half space behind it'
    if abs(length - 1.0) > UNIT_NORM:
        note += f'; its normal is {length:g} long'
    return PlacedShape('plane', HalfSpace(), X_OS @ X_SH, note=note)


def placed_body(vertices: ArrayLike, triangles: ArrayLike, X_OS: RigidTransform) -> PlacedShape:
    """Return the solid that triangles (m, 3) of vertices (n, 3) [m] enclose, or their hull.

    Raises RuntimeError for triangles without a volume.
    """
    points = np.asarray(vertices, dtype=np.float64)
    corners = np.asarray(triangles, dtype=np.int64)
    if not points.size or not corners.size:
        raise ArgumentError(
            f'it holds {len(points)} vertices and {len(corners)} triangles; it must have both'
        )
    if not np.isfinite(points).all():
        raise ArgumentError('a vertex is not finite')
    data = MeshData(points, corners.reshape(-1, 3))
    solid = Mesh.FromMeshData(data)
    try:
        solid.weldings()
    except MeshFileError as open_surface:
        hull = Convex.FromMeshData(data)
        hull.hull_surface()
        note = f'counts as its convex hull, for its triangles enclose no body: {open_surface}'
        return PlacedShape('mesh', hull, X_OS, note=note)
    return PlacedShape('mesh', solid, X_OS, is_solid=True)


class NoMoveItTypeError(ArgumentError):
    """A shape is one that MoveIt has no type for."""


class MoveItBody(NamedTuple):
    """A body S as MoveIt has it, on a geometry G.

    ``sizes`` are those of the text format [m]: box x y z, sphere radius, cylinder radius length,
    plane a b c d. A mesh has none, but vertices (n, 3) [m] and triangles (m, 3).
    """

    kind: str
    sizes: tuple[float, ...]
    X_GS: RigidTransform
    vertices: Floats = np.zeros((0, 3))
    triangles: Indices = np.zeros((0, 3), dtype=np.int64)


_BELOW = 0.0, 0.0, 1.0, 0.0  # the plane z = 0, whose normal points out
_BALL_POINTS = 642  # of the polyhedron around an ellipsoid


def moveit_bodies(shape: Shape, is_solid: bool) -> Iterator[MoveItBody]:
    """Yield the bodies that a shape is made of; ``is_solid`` is ('mesh', 'solid') of a mesh.

    A capsule is a cylinder and two spheres, an ellipsoid the polyhedron around it. Raises
    NoMoveItTypeError for a shape that MoveIt has no type for.
    """
    here = RigidTransform()
    if isinstance(shape, Box):
        yield MoveItBody('box', tuple(shape.size().tolist()), here)
    elif isinstance(shape, Sphere):
        yield MoveItBody('sphere', (shape.radius(),), here)
    elif isinstance(shape, Cylinder):
        yield MoveItBody('cylinder', (shape.radius(), shape.length()), here)
    elif isinstance(shape, Capsule):
        yield MoveItBody('cylinder', (shape.radius(), shape.length()), here)
        for z in (-0.5 * shape.length(), 0.5 * shape.length()):
            yield MoveItBody('sphere', (shape.radius(),), RigidTransform([0.0, 0.0, z]))
    elif isinstance(shape, HalfSpace):
        yield MoveItBody('plane', _BELOW, here)
    elif isinstance(shape, Ellipsoid):
        vertices, triangles = _around_unit_ball()
        yield MoveItBody('mesh', (), here, vertices * [shape.a(), shape.b(), shape.c()], triangles)
    elif isinstance(shape, Convex | Mesh):
        surface = shape.surface() if is_solid and isinstance(shape, Mesh) else shape.hull_surface()
        yield MoveItBody('mesh', (), here, *surface)
    else:
        raise NoMoveItTypeError(f'a {type(shape).__name__} has no type in MoveIt')


@lru_cache(1)
def _around_unit_ball() -> tuple[Floats, Indices]:
    """Return vertices and triangles of a polyhedron around the unit ball, which a face touches.

    Its vertices are those of a spiral (Vogel), moved out as far as the nearest face asks for.
    """
    k = np.arange(_BALL_POINTS) + 0.5
    z, angles = 1.0 - 2.0 * k / _BALL_POINTS, math.pi * (1.0 + math.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    points = np.array([r * np.cos(angles), r * np.sin(angles), z])
    hull = Convex(points=points, label='ball')
    vertices, triangles = hull.hull_surface()
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    nearest = float(np.einsum('ij,ij->i', normals, corners[:, 0]).min())
    return vertices / nearest, triangles
