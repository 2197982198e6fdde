"""Bodies for measurements: a shape, by its public name and numbers, at its pose.

A body converts itself to the forms that this package, the truth and the peers use. Two bodies are
a ``Pair``; a pair with its true distance is a case of ``hard_cases``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros import geometry
from drake_geom_ros.cross_check.answers import ACCESSORS, HALVES, SolidMesh
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats

# Type number as in the Shape message; half sizes, or the number of vertices and their x, y, z.
Form = tuple[int, Floats]
Pose = tuple[Any, Any]  # R (3, 3), p (3,) [m]

COUNTS = {kind: len(names) for kind, names in ACCESSORS.items()}  # of numbers, by kind
PRIMITIVES = tuple(COUNTS)
BOUNDED = tuple(kind for kind in PRIMITIVES if kind != 'HalfSpace')
FROM_VERTICES = ('Convex', 'Mesh', 'Solid')
NUMBERS = {
    'Point': 1,
    **{kind: number for number, kind in enumerate(PRIMITIVES, 1)},
    **dict.fromkeys(FROM_VERTICES, 7),
}


@dataclass(frozen=True, eq=False)
class Body:
    """A shape at its pose X_WG, by default the identity.

    ``size`` [m] are the constructor's arguments of its kind; for Convex, Mesh and Solid the
    vertices (n, 3), for OccupiedCells the edge and the centres. A Solid is a mesh that stands for
    the solid inside its surface: it also has ``triangles`` (m, 3), and, if known, ``parts``,
    convex bodies in its own frame whose union it is. A Point is a sphere of radius 0, except in
    point queries.
    """

    kind: str
    size: Sequence[Any] | Floats = ()
    R: Floats = field(default_factory=lambda: np.eye(3))
    p: Floats = field(default_factory=lambda: np.zeros(3))
    triangles: Sequence[Any] | NDArray[np.int64] = ()
    parts: tuple[Body, ...] = ()

    @classmethod
    def of_halves(cls, kind: str, halves: Any) -> Body:
        """Return a primitive, or a Point, from half sizes, of which the first ones are used."""
        sizes = np.asarray(halves, dtype=float)[: COUNTS.get(kind, 0)] / HALVES.get(kind, 1.0)
        return cls(kind, tuple(sizes.tolist()))

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the fields without cached values such as the shape."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @cached_property
    def shape(self) -> geometry.Shape:
        """The public shape; of a Solid a ``SolidMesh``, which peers with triangles recognise."""
        if self.kind == 'Point':
            return geometry.Sphere(0.0)
        if self.kind in FROM_VERTICES:
            kind = SolidMesh if self.kind == 'Solid' else getattr(geometry, self.kind)
            shape = kind.FromMeshData(geometry.MeshData(self.size, self.triangles))
        else:
            shape = getattr(geometry, self.kind)(*self.size)
        assert isinstance(shape, geometry.Shape)
        return shape

    @property
    def properties(self) -> geometry.ProximityProperties:
        """Proximity properties, which make a Solid one."""
        properties = geometry.ProximityProperties()
        if self.kind == 'Solid':
            properties.AddProperty('mesh', 'solid', True)
        return properties

    @cached_property
    def form(self) -> Form:
        """The shape in the form of ``truth``, where a Solid is its hull."""
        size = np.asarray(self.size, dtype=float)
        if self.kind in FROM_VERTICES:
            return NUMBERS[self.kind], np.append(len(size), size.T.ravel())
        if self.kind == 'Point':
            size = np.zeros(1)
        return NUMBERS[self.kind], size * HALVES.get(self.kind, 1.0)

    @cached_property
    def corners(self) -> Floats:
        """Corners (m, 3, 3) [m] of a Solid's triangles, without those that have no area."""
        corners = np.asarray(self.size, dtype=float)[np.asarray(self.triangles)]
        sides = corners[:, 1:] - corners[:, :1]
        with_area: Floats = corners[np.cross(sides[:, 0], sides[:, 1]).any(axis=1)]
        return with_area

    @cached_property
    def radius(self) -> float:
        """Radius [m] of the bounding ball about the shape's origin; a half space has 0."""
        if self.kind == 'OccupiedCells':
            edge, centres = self.size
            farthest = math.sqrt(float((np.asarray(centres) ** 2).sum(axis=1).max()))
            return farthest + 0.5 * math.sqrt(3.0) * float(edge)
        s = np.asarray(self.size, dtype=float)
        if self.kind in FROM_VERTICES:
            return float(np.hypot.reduce(s, axis=1).max())
        if self.kind == 'Box':
            return math.hypot(*(0.5 * s))
        if self.kind == 'Capsule':
            return float(s[0] + 0.5 * s[1])
        if self.kind == 'Cylinder':
            return math.hypot(s[0], 0.5 * s[1])
        return float(s.max()) if s.size else 0.0

    @property
    def skew(self) -> float:
        """Greatest deviation [-] of R R^T from the identity."""
        return float(np.abs(self.R @ self.R.T - np.eye(3)).max())

    @property
    def pose(self) -> RigidTransform:
        """X_WG, with the rotation matrix unchanged."""
        return RigidTransform(RotationMatrix(self.R), self.p)

    @property
    def X_WG(self) -> Pose:
        """The pose in the form of ``truth``."""
        return self.R, self.p

    def placed(self, R: Any, p: Any) -> Body:
        """Return the body at another pose, with shared cached values of its shape."""
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__, R=np.asarray(R, float), p=np.asarray(p, float))
        return made

    def posed(self, pose: Any) -> Body:
        """Return the body at a pose (7,), x y z [m] qx qy qz qw."""
        X_WG = RigidTransform.FromArray(pose)
        return self.placed(X_WG.rotation().matrix(), X_WG.translation())

    def at(self, p: Any) -> Body:
        """Return the body at another position."""
        return self.placed(self.R, p)

    def moved(self, R: Floats, p: Floats) -> Body:
        """Return the body after a rigid motion of World."""
        return self.placed(R @ self.R, R @ self.p + p)

    def scaled(self, s: float) -> Body:
        """Return the body with all lengths multiplied."""
        if self.kind in FROM_VERTICES:
            size: Any = as_tuples(s * np.asarray(self.size))
        else:
            size = tuple(s * x for x in self.size)
        parts = tuple(part.scaled(s) for part in self.parts)
        return replace(self, size=size, p=s * self.p, parts=parts)


def as_tuples(points: NDArray[Any]) -> tuple[tuple[Any, ...], ...]:
    """Return an array (n, 3) as a size that can be compared, hashed and written."""
    return tuple(map(tuple, points.tolist()))


@dataclass(frozen=True, eq=False)
class Pair:
    """Two bodies."""

    a: Body
    b: Body

    @property
    def has_solid(self) -> bool:
        """True if one of the bodies is a solid mesh, which may be concave."""
        return 'Solid' in (self.a.kind, self.b.kind)

    @property
    def has_map(self) -> bool:
        """True if one of the bodies is a sensed map, which has no supporting planes."""
        return 'OccupiedCells' in (self.a.kind, self.b.kind)

    @property
    def extent(self) -> float:
        """Size of the pair [m]: the sum of both radii and the distance of the origins."""
        return self.a.radius + self.b.radius + math.hypot(*(self.b.p - self.a.p))

    @property
    def away(self) -> float:
        """Greatest coordinate [m] of the pair's origins."""
        return float(max(np.abs(self.a.p).max(), np.abs(self.b.p).max()))

    @property
    def smaller(self) -> float:
        """Radius [m] of the smaller body, ignoring half spaces and points; 0 without others."""
        return min((body.radius for body in (self.a, self.b) if body.radius > 0.0), default=0.0)

    def swapped(self) -> Pair:
        """Return the pair with A and B exchanged."""
        return replace(self, a=self.b, b=self.a)

    def moved(self, R: Floats, p: Floats) -> Pair:
        """Return the pair after a rigid motion of World."""
        return replace(self, a=self.a.moved(R, p), b=self.b.moved(R, p))

    def scaled(self, s: float) -> Pair:
        """Return the pair with all lengths multiplied."""
        return replace(self, a=self.a.scaled(s), b=self.b.scaled(s))
