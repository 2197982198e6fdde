"""Meshes that count as solids: two bodies with dents, their surfaces in several resolutions.

``L``
    Two boxes that share a corner. However finely its faces are cut, it is the same body, so that
    boxes tell the truth about it.
``Ball``
    An icosphere with six bumps and dents between them; every resolution is a body of its own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from drake_geom_ros import geometry
from drake_geom_ros.evidence.accuracy.solids import Solid
from drake_geom_ros.evidence.peers import SolidMesh
from drake_geom_ros.evidence.truth.supports import Floats

Indices = NDArray[np.int64]

UNIT = 0.1  # [m] the width of the L's arms
RADIUS = 0.12  # [m] of the ball
DENTS = 0.5  # [-] a ball with less than 0.25 is convex
# About so many triangles -> how often each side of the L is cut, each triangle of the ball halved.
CUTS = {100: (2, 1), 1300: (7, 3), 20000: (27, 5)}


@dataclass(frozen=True, eq=False)
class MeshBody(Solid):
    """A mesh as a solid, by its name and about how many triangles it has.

    ``kind`` is Mesh, ``vertices`` are those of the hull, ``corners`` (n, 3, 3) [m] those of the
    triangles, counter-clockwise from outside.
    """

    name: str = ''
    resolution: int = 0
    corners: Floats | None = None

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle what the body was made from: a process makes each surface once."""
        return mesh_body, (self.name, self.resolution)

    @cached_property
    def shape(self) -> geometry.Shape:
        """The mesh; to peers that take triangles the solid too."""
        assert self.corners is not None
        triangles = np.arange(3 * len(self.corners)).reshape(-1, 3)
        return SolidMesh.FromMeshData(geometry.MeshData(self.corners.reshape(-1, 3), triangles))

    def properties(self) -> geometry.ProximityProperties:
        """Return properties that make the mesh a solid."""
        properties = geometry.ProximityProperties()
        properties.AddProperty('mesh', 'solid', True)
        return properties

    def boxes(self) -> list[tuple[Solid, Floats]]:
        """Return the boxes that the body is made of, each with its middle [m]; [] of a ball."""
        if self.name != 'L':
            return []
        long, half = 2 * UNIT, 0.5 * UNIT
        return [
            (Solid('Box', (long, UNIT, UNIT)), np.array([0.0, -half, 0.0])),
            (Solid('Box', (UNIT, long, UNIT)), np.array([-half, 0.0, 0.0])),
        ]


@functools.cache
def mesh_body(name: str, resolution: int) -> MeshBody:
    """Return a body by its name and resolution, of ``SURFACES`` and ``CUTS``."""
    corners = SURFACES[name](resolution)
    points = np.unique(corners.reshape(-1, 3), axis=0)
    hull = points[ConvexHull(points).vertices]
    return MeshBody('Mesh', vertices=hull, name=name, resolution=resolution, corners=corners)


def l_surface(resolution: int) -> Floats:
    """Return the triangles (n, 3, 3) [m] of an L about its inner edge."""
    cuts = CUTS[resolution][0]
    below, above = np.linspace(-UNIT, 0.0, cuts + 1), np.linspace(0.0, UNIT, cuts + 1)
    lines = [(below, above), (below, above), (np.linspace(-0.5, 0.5, cuts + 1) * UNIT,)]
    cells = {(0, 0, 0), (1, 0, 0), (0, 1, 0)}
    faces = []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                beside = list(cell)
                beside[axis] += 2 * side - 1
                if tuple(beside) not in cells:
                    across = [lines[k][cell[k]] for k in range(3)]
                    faces.append(_square(across, axis, side))
    return np.concatenate(faces)


def _square(lines: list[Floats], axis: int, side: int) -> Floats:
    """Return the triangles of a cell's face, whose outward normal is along an axis."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    cuts = len(lines[0]) - 1
    points = np.empty((cuts + 1, cuts + 1, 3))
    points[..., axis] = lines[axis][-side]
    points[..., u], points[..., v] = np.meshgrid(lines[u], lines[v], indexing='ij')
    a, b = points[:-1, :-1], points[1:, :-1]
    c, d = points[1:, 1:], points[:-1, 1:]
    triangles = np.stack([np.stack(t, axis=-2) for t in ((a, b, c), (a, c, d))]).reshape(-1, 3, 3)
    return triangles if side else triangles[:, ::-1]


def ball_surface(resolution: int) -> Floats:
    """Return the triangles (n, 3, 3) [m] of an icosphere with dents."""
    golden = (1.0 + 5.0**0.5) / 2.0
    points = np.array(
        [np.roll([0.0, s, t * golden], k) for s in (1, -1) for t in (1, -1) for k in range(3)]
    )
    points /= np.linalg.norm(points[0])
    hull = ConvexHull(points)
    outward = np.linalg.det(points[hull.simplices]) > 0.0
    corners = points[np.where(outward[:, None], hull.simplices, hull.simplices[:, ::-1])]
    for _ in range(CUTS[resolution][1]):
        corners = _quartered(corners)
    radii = RADIUS * (1.0 + DENTS * ((corners**4).sum(axis=2, keepdims=True) - 0.6))
    dented: Floats = radii * corners
    return dented


def _quartered(corners: Floats) -> Floats:
    """Return four triangles for each, with the middles of its sides brought to radius 1."""
    middles = corners + np.roll(corners, -1, axis=1)
    middles /= np.linalg.norm(middles, axis=2, keepdims=True)
    (a, b, c), (ab, bc, ca) = np.swapaxes(corners, 0, 1), np.swapaxes(middles, 0, 1)
    parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate([np.stack(part, axis=1) for part in parts])


SURFACES: dict[str, Callable[[int], Floats]] = {'L': l_surface, 'Ball': ball_surface}
