"""Shapes as scaled copies of a few surfaces, so that thousands are drawn as a few batches."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field

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
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.viewing.looks import mesh_surface

Floats = NDArray[np.float64]
_AROUND, _ALONG = 32, 12  # facets of a round surface
# A half space has no end; this much of its plane is shown.
PLANE_SIZE, _PLANE_THICKNESS = 6.0, 0.01  # [m]


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles (m, 3) of vertices (n, 3) [m], counter-clockwise from outside.

    ``smooth`` ones are shaded as the round surface that they stand for; ``two_sided`` ones, which
    may have holes or faces the wrong way round, are drawn from behind, too.
    """

    key: str
    vertices: Floats
    triangles: NDArray[np.int64]
    smooth: bool = False
    two_sided: bool = False


@dataclass(frozen=True)
class Part:
    """A surface in a geometry's frame: scaled by ``scale`` (3,) first, then posed by X_GS."""

    surface: Surface
    scale: tuple[float, float, float]
    X_GS: RigidTransform = field(default_factory=RigidTransform)


def _revolved(key: str, r: Floats, z: Floats) -> Surface:
    """Return the surface of a profile (k,) (r, z) [m] revolved about z, z increasing."""
    angles = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    rings = np.empty((len(r), _AROUND, 3))
    rings[..., 0] = r[:, None] * np.cos(angles)
    rings[..., 1] = r[:, None] * np.sin(angles)
    rings[..., 2] = z[:, None]
    row, column = np.divmod(np.arange((len(r) - 1) * _AROUND), _AROUND)
    a, b = row * _AROUND + column, row * _AROUND + (column + 1) % _AROUND
    c, d = a + _AROUND, b + _AROUND
    triangles = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return Surface(key, rings.reshape(-1, 3), triangles, smooth=True)


def _disc() -> Surface:
    """Return the unit disc, seen from above."""
    angles = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(_AROUND)], axis=1)
    k = np.arange(_AROUND)
    triangles = np.stack([np.full(_AROUND, _AROUND), k, (k + 1) % _AROUND], axis=1)
    return Surface('disc', np.vstack([rim, np.zeros(3)]), triangles)


def _cube() -> Surface:
    """Return the cube of edge 1 about the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    return Surface('cube', corners, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def _arc(start: float, end: float) -> tuple[Floats, Floats]:
    angles = np.linspace(start, end, _ALONG + 1)
    return np.cos(angles), np.sin(angles)


CUBE = _cube()
BALL = _revolved('ball', *_arc(-np.pi / 2, np.pi / 2))
DOME = _revolved('dome', *_arc(0.0, np.pi / 2))
TUBE = _revolved('tube', np.ones(2), np.array([-0.5, 0.5]))
CONE = _revolved('cone', np.array([0.0, 1.0]), np.array([0.0, 1.0]))
DISC = _disc()
_UPSIDE_DOWN = RotationMatrix.MakeXRotation(np.pi)


def _at(z: float, *, down: bool = False) -> RigidTransform:
    """Return the pose of what looks up, or down, at a height [m]."""
    return RigidTransform(_UPSIDE_DOWN if down else RotationMatrix(), [0.0, 0.0, z])


def parts_of(shape: Shape, solid: bool = False) -> list[Part]:
    """Return the parts that draw a shape as queries see it, a mesh as a solid if it is one.

    Raises MeshFileError for a file that is no mesh.
    """
    if isinstance(shape, Sphere):
        return [Part(BALL, (shape.radius(),) * 3)]
    if isinstance(shape, Ellipsoid):
        return [Part(BALL, (shape.a(), shape.b(), shape.c()))]
    if isinstance(shape, Box):
        return [Part(CUBE, (shape.width(), shape.depth(), shape.height()))]
    if isinstance(shape, (Cylinder, Capsule)):
        r, half = shape.radius(), shape.length() / 2
        end = DISC if isinstance(shape, Cylinder) else DOME
        ends = [Part(end, (r, r, r), _at(half)), Part(end, (r, r, r), _at(-half, down=True))]
        return [Part(TUBE, (r, r, shape.length())), *ends]
    if isinstance(shape, MeshcatCone):
        a, b, height = shape.a(), shape.b(), shape.height()
        return [Part(CONE, (a, b, height)), Part(DISC, (a, b, 1.0), _at(height))]
    if isinstance(shape, HalfSpace):
        size = (PLANE_SIZE, PLANE_SIZE, _PLANE_THICKNESS)
        return [Part(CUBE, size, _at(-_PLANE_THICKNESS / 2))]
    assert isinstance(shape, (Convex, Mesh)), f'a shape that cannot be drawn: {shape!r}'
    vertices, triangles = mesh_surface(shape, solid)
    key = hashlib.sha256(vertices.tobytes() + triangles.tobytes()).hexdigest()
    return [Part(Surface(key, vertices, triangles, two_sided=True), (1.0, 1.0, 1.0))]
