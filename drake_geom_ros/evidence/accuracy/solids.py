"""Shapes as the measurement sees them: a public name and numbers, for us, the truth and peers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from drake_geom_ros import geometry
from drake_geom_ros.evidence.truth import supports
from drake_geom_ros.evidence.truth.supports import Floats

_NUMBERS = {
    'Point': supports.SPHERE,
    'Sphere': supports.SPHERE,
    'Box': supports.BOX,
    'Capsule': supports.CAPSULE,
    'Cylinder': supports.CYLINDER,
    'Ellipsoid': supports.ELLIPSOID,
    'HalfSpace': supports.HALF_SPACE,
    'Convex': supports.CONVEX,
    'Mesh': supports.CONVEX,
}
_SIZES = {'Sphere': 1, 'Box': 3, 'Capsule': 2, 'Cylinder': 2, 'Ellipsoid': 3}
_HALVES = {'Box': (0.5, 0.5, 0.5), 'Capsule': (1.0, 0.5), 'Cylinder': (1.0, 0.5)}


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape by its public name and the arguments [m] of its constructor.

    A Convex and a Mesh have ``vertices`` (n, 3) [m] instead, which are those of a hull; a Point
    is what the point query asks about, a sphere of radius 0 for everybody else.
    """

    kind: str
    sizes: tuple[float, ...] = ()
    vertices: Floats | None = None

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle what the solid was made from, not the shape that was made of it."""
        return Solid, (self.kind, self.sizes, self.vertices)

    @cached_property
    def shape(self) -> geometry.Shape:
        """The public shape."""
        if self.kind == 'Point':
            return geometry.Sphere(0.0)
        if self.vertices is None:
            shape: geometry.Shape = getattr(geometry, self.kind)(*self.sizes)
            return shape
        data = geometry.MeshData(self.vertices, outward_triangles(self.vertices))
        made: geometry.Shape = getattr(geometry, self.kind).FromMeshData(data)
        return made

    def properties(self) -> geometry.ProximityProperties:
        """Return the properties of the proximity role."""
        return geometry.ProximityProperties()

    def support(self) -> supports.Shape:
        """Return the shape as ``truth`` takes it: type number, half sizes or vertices."""
        number = _NUMBERS[self.kind]
        if self.vertices is not None:
            return number, np.append(len(self.vertices), self.vertices.ravel())
        if self.kind == 'Point':
            return number, np.zeros(1)
        return number, np.multiply(self.sizes, _HALVES.get(self.kind, 1.0))

    def reach(self) -> float:
        """Return the radius [m] of a ball about the origin that holds the shape."""
        return 0.0 if self.kind == 'HalfSpace' else supports.posed(
            self.support(), np.eye(3), np.zeros(3)
        ).size  # fmt: skip


def random_solid(rng: np.random.Generator, kind: str, corners: int = 0) -> Solid:
    """Return a shape of a kind, some 0.2 m wide; a hull has as many corners as asked for."""
    if kind in ('Convex', 'Mesh'):
        directions = rng.normal(size=(corners, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        # All on an ellipsoid: each is a vertex of the hull.
        return Solid(kind, vertices=directions * rng.uniform(0.08, 0.2, 3))
    sizes = rng.uniform(0.05, 0.2, _SIZES.get(kind, 0)) / np.array(_HALVES.get(kind, 1.0))
    return Solid(kind, tuple(np.atleast_1d(sizes)[: _SIZES.get(kind, 0)].tolist()))


def random_rotation(rng: np.random.Generator) -> Floats:
    """Return a random rotation matrix (3, 3)."""
    matrix: Floats = Rotation.random(rng=rng).as_matrix()
    return matrix


def outward_triangles(vertices: Floats) -> Floats:
    """Return the triangles (k, 3) of the hull of vertices (n, 3), counter-clockwise outside."""
    hull = ConvexHull(vertices)
    a, b, c = (vertices[hull.simplices[:, k]] for k in range(3))
    inward = np.einsum('ij,ij->i', np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles = hull.simplices.copy()
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles
