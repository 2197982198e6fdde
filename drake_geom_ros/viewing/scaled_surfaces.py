"""Surfaces of shapes as scaled copies of a few, so that few batches draw thousands."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    MeshcatCone,
    OccupiedCells,
    PointCloud,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.viewing.looks import mesh_surface

# Facets around a round surface, a multiple of 4 so that its width is exact.
FINEST, _COARSEST = 32, 8
_POINT = 0.01  # a ring of a smaller radius, relative to 1, is a point
_FEW = 100  # round shapes are drawn at the finest up to this number
# Shown part of a half space's plane.
PLANE_SIZE, _PLANE_THICKNESS = 6.0, 0.01  # [m]
ROUND = (Capsule, Cylinder, Ellipsoid, MeshcatCone, Sphere)


@dataclass(frozen=True, eq=False)
class DrawnSurface:
    """Triangles (m, 3) of vertices (n, 3) [m], counter-clockwise from outside.

    ``smooth`` surfaces are shaded as round. ``two_sided`` ones, which may have holes or inverted
    faces, are drawn from behind too.
    """

    key: str
    vertices: Floats
    triangles: NDArray[np.int64]
    smooth: bool = False
    two_sided: bool = False


@dataclass(frozen=True)
class Part:
    """A surface in a geometry's frame: scaled by ``scale`` (3,) first, then posed by X_GS."""

    surface: DrawnSurface
    scale: tuple[float, float, float]
    X_GS: RigidTransform = field(default_factory=RigidTransform)


def facets_around(count: int) -> int:
    """Return the number of facets around each of ``count`` round shapes.

    It decreases with ``count``, down to an octagon, so that the total of triangles, which grows
    with its square, stays about constant: they cost a browser without a GPU its time.
    """
    most = FINEST * np.sqrt(_FEW / max(count, _FEW))
    return max(_COARSEST, 4 * int(most / 4))


def _circle(around: int) -> Floats:
    """Return the corners (around, 2) of the regular polygon in the unit circle."""
    angles = 2.0 * np.pi * np.arange(around) / around
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _revolved(key: str, around: int, r: Floats, z: Floats) -> DrawnSurface:
    """Return the surface of a profile (k,) (r, z) [m] revolved about z, z increasing.

    A duplicate point is a sharp edge, with separate shading below and above it.
    """
    rings = np.empty((len(r), around, 3))
    rings[..., :2] = r[:, None, None] * _circle(around)
    rings[..., 2] = z[:, None]
    row, column = np.divmod(np.arange((len(r) - 1) * around), around)
    a, b = row * around + column, row * around + (column + 1) % around
    c, d = a + around, b + around
    # Rings that are points have no sides, and duplicate rings have no strip between them.
    strip = (np.diff(r) != 0.0) | (np.diff(z) != 0.0)
    exists = strip[row, None] & np.stack([r[row] > _POINT, r[row + 1] > _POINT], axis=1)
    triangles = np.stack([np.stack([a, b, d], 1), np.stack([a, d, c], 1)], axis=1)[exists]
    return DrawnSurface(f'{key} of {around}', rings.reshape(-1, 3), triangles, smooth=True)


def _arc(start: float, pieces: int) -> tuple[Floats, Floats]:
    """Return the profile of the unit circle from an angle to the pole."""
    angles = np.linspace(start, np.pi / 2, pieces + 1)
    return np.cos(angles), np.sin(angles)


@lru_cache
def _ball(around: int) -> DrawnSurface:
    """Return the unit ball."""
    return _revolved('ball', around, *_arc(-np.pi / 2, around // 2))


@lru_cache
def _dome(around: int) -> DrawnSurface:
    """Return the upper half of the unit ball, open below."""
    return _revolved('dome', around, *_arc(0.0, around // 4))


@lru_cache
def _tube(around: int) -> DrawnSurface:
    """Return the cylinder of radius 1 and height 1 about the origin, open at its ends."""
    return _revolved('tube', around, np.ones(2), np.array([-0.5, 0.5]))


@lru_cache
def _cylinder(around: int) -> DrawnSurface:
    """Return the cylinder of radius 1 and height 1 about the origin."""
    r, z = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 0.0]), np.array([-0.5, -0.5, -0.5, 0.5, 0.5, 0.5])
    return _revolved('cylinder', around, r, z)


@lru_cache
def _cone(around: int) -> DrawnSurface:
    """Return the cone from the origin up to the unit circle at height 1."""
    r, z = np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 1.0, 1.0, 1.0])
    return _revolved('cone', around, r, z)


def _cube() -> DrawnSurface:
    """Return the cube of edge 1 about the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    return DrawnSurface('cube', corners, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


CUBE = _cube()
_UPSIDE_DOWN = RotationMatrix.MakeXRotation(np.pi)


def _at(z: float, *, down: bool = False) -> RigidTransform:
    """Return the pose of a part at a height [m], upside down if ``down``."""
    return RigidTransform(_UPSIDE_DOWN if down else RotationMatrix(), [0.0, 0.0, z])


def parts_of(shape: Shape, solid: bool = False, around: int = FINEST) -> list[Part]:
    """Return the parts that draw a shape as queries treat it, a mesh as its hull or a solid.

    Round surfaces have ``around`` facets, a multiple of 4. Raises MeshFileError for a file that
    is no mesh.
    """
    if isinstance(shape, Sphere):
        return [Part(_ball(around), (shape.radius(),) * 3)]
    if isinstance(shape, Ellipsoid):
        return [Part(_ball(around), (shape.a(), shape.b(), shape.c()))]
    if isinstance(shape, Box):
        return [Part(CUBE, (shape.width(), shape.depth(), shape.height()))]
    if isinstance(shape, Cylinder):
        r = shape.radius()
        return [Part(_cylinder(around), (r, r, shape.length()))]
    if isinstance(shape, Capsule):
        r, half = shape.radius(), shape.length() / 2
        domes = [Part(_dome(around), (r, r, r), _at(z, down=z < 0.0)) for z in (half, -half)]
        return [Part(_tube(around), (r, r, shape.length())), *domes]
    if isinstance(shape, MeshcatCone):
        return [Part(_cone(around), (shape.a(), shape.b(), shape.height()))]
    if isinstance(shape, HalfSpace):
        size = (PLANE_SIZE, PLANE_SIZE, _PLANE_THICKNESS)
        return [Part(CUBE, size, _at(-_PLANE_THICKNESS / 2))]
    if isinstance(shape, (OccupiedCells, PointCloud)):
        vertices, triangles = shape.surface()
    else:
        assert isinstance(shape, (Convex, Mesh)), f'a shape that cannot be drawn: {shape!r}'
        vertices, triangles = mesh_surface(shape, solid)
    key = hashlib.sha256(vertices.tobytes() + triangles.tobytes()).hexdigest()
    return [Part(DrawnSurface(key, vertices, triangles, two_sided=True), (1.0, 1.0, 1.0))]
