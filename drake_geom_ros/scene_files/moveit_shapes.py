"""Shapes as MoveIt's messages and files have them: cones, planes, triangles of bodies."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry import (
    ArgumentError,
    Convex,
    HalfSpace,
    Mesh,
    MeshData,
    MeshFileError,
    Shape,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
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
