"""Shapes as polygons, for pictures."""

import itertools

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ShapeKind

SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID, HALF_SPACE, *_ = ShapeKind
# A half space and the top of a table are cut into tiles so that depth sorting works on them.
_TILE = 0.1  # [m]
_AROUND = 20
_ALONG = 6

Faces = list[NDArray[np.float64]]


def faces_of(shape_type: int, dimensions: tuple[float, ...]) -> Faces:
    """Return the surface as polygons (k, 3) [m] in the geometry's frame, wound outwards.

    ``dimensions`` are those of the Shape message. A half space has no extent to show, and convex
    hulls and meshes are not drawn: their list is empty.
    """
    if shape_type == SPHERE:
        return _revolved(*_arc(dimensions[0]))
    if shape_type == ELLIPSOID:
        return [face * np.array(dimensions) for face in _revolved(*_arc(1.0))]
    if shape_type == CAPSULE:
        return _revolved(*_arc(dimensions[0], dimensions[1] / 2))
    if shape_type == CYLINDER:
        radius, half = dimensions[0], dimensions[1] / 2
        return _revolved([0.0, radius, radius, 0.0], [-half, -half, half, half])
    if shape_type == BOX:
        return _box(np.array(dimensions) / 2)
    return []


def _arc(radius: float, half_length: float = 0.0) -> tuple[list[float], list[float]]:
    """Return the profile (r, z) of a ball that is parted at its equator by a length."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 2 * _ALONG + 1)
    r, z = radius * np.cos(angles), radius * np.sin(angles)
    if half_length == 0.0:
        return list(r), list(z)
    lower, upper = slice(None, _ALONG + 1), slice(_ALONG, None)
    return [*r[lower], *r[upper]], [*(z[lower] - half_length), *(z[upper] + half_length)]


def _revolved(r: list[float], z: list[float]) -> Faces:
    """Return the quadrilaterals of a profile (r, z) revolved about z, z increasing."""
    angles = np.linspace(0.0, 2.0 * np.pi, _AROUND + 1)
    profile = np.stack([np.array(r), np.array(r), np.array(z)])
    rings = [profile * np.array([[np.cos(a)], [np.sin(a)], [1.0]]) for a in angles]
    return [
        np.stack([a[:, k], b[:, k], b[:, k + 1], a[:, k + 1]])
        for a, b in itertools.pairwise(rings)
        for k in range(len(r) - 1)
    ]


def _box(half: NDArray[np.float64]) -> Faces:
    """Return the tiles of a box's six sides."""
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        cuts = [np.linspace(-1, 1, int(np.ceil(2 * half[k] / _TILE)) + 1) for k in (u, v)]
        for side in (-1.0, 1.0):
            for s0, s1 in itertools.pairwise(cuts[0]):
                for t0, t1 in itertools.pairwise(cuts[1]):
                    corners = [(s0, t0), (s1, t0), (s1, t1), (s0, t1)][:: int(side)]
                    face = np.zeros((4, 3))
                    face[:, axis] = side
                    face[:, u], face[:, v] = np.transpose(corners)
                    faces.append(face * half)
    return faces
