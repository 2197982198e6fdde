"""Support functions of posed shapes, for the truth: in floats to search, in 40 digits to tell.

Every shape here is the sum of a polytope (its ``vertices``), a ball, and an ellipsoid or a disc::

    h(n) = max over vertices of v . n  +  radius |n|  +  |flat n|

A sphere has one vertex, its centre; a capsule two and a ball; a cylinder two and a disc. The
signed distance of two is the maximum over unit n of f(n) = -h_A(n) - h_B(-n).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import mpf
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from drake_geom_ros.cross_check.bodies import Form
from drake_geom_ros.cross_check.surfaces import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    SPHERE,
)
from drake_geom_ros.math.array_types import Floats
from truth.bodies.random_bodies import box_corners
from truth.references.digits import columns, combine, dot, norm, vector
from truth.tolerances import TIE

DIGITS = 40


@dataclass(frozen=True)
class MinkowskiSum:
    """A bounded shape at a pose.

    ``vertices`` (k, 3) [m] in the geometry's frame, ``edges`` (m, 2) between them, ``flat``
    (j, 3) [m] from the geometry's frame, ``R`` and ``p`` [m] the pose, ``poles`` (i, 3) the
    directions in World at which ``|flat n|`` has no slope.
    """

    vertices: Floats
    edges: NDArray[np.int64]
    radius: float
    flat: Floats
    R: Floats
    p: Floats
    poles: Floats

    @property
    def size(self) -> float:
        """The radius [m] of a ball about the geometry's origin that holds the body."""
        reach = float(np.linalg.norm(self.vertices, axis=1).max())
        return reach + self.radius + float(np.abs(self.flat).max(initial=0.0)) * 2**0.5

    def points(self, n: Floats) -> Floats:
        """Return the points (m, 3) that are extreme along the unit directions n (m, 3)."""
        d = n @ self.R
        x = self.vertices[np.argmax(d @ self.vertices.T, axis=1)] + self.radius * d
        if len(self.flat):
            y = d @ self.flat.T
            length = np.linalg.norm(y, axis=1)
            x = x + (y @ self.flat) / np.where(length > 0, length, 1.0)[:, None]
        return self.p + x @ self.R.T

    def creases(self, n: Floats, angle: float) -> NDArray[np.int64]:
        """Return the edges (k, 2) that meet a cap of ``angle`` [rad] about n in the Gauss map."""
        heights = self.vertices @ (n @ self.R)
        low = heights.max() - 4 * angle * (np.linalg.norm(self.vertices, axis=1).max() + TIE)
        edges = self.edges[(heights[self.edges] >= low).all(axis=1)]
        along = self.vertices[edges[:, 0]] - self.vertices[edges[:, 1]]
        slope = np.abs(along @ (n @ self.R)) / np.linalg.norm(along, axis=1)
        near: NDArray[np.int64] = edges[slope <= 2 * angle]
        return near

    def exact_height(self, n: list[Any]) -> Any:
        """Return h(n), in full digits, from the position p."""
        d = [dot(n, column) for column in columns(self.R)]
        rough = self.vertices @ np.array([float(x) for x in d])
        tied = self.vertices[rough >= rough.max() - TIE * self.size]
        height = max(dot(d, vector(v)) for v in tied) + mpf(float(self.radius)) * norm(n)
        if len(self.flat):
            height += norm([dot(d, vector(row)) for row in self.flat])
        return height

    def exact_edge(self, edge: Floats) -> list[Any]:
        """Return the direction of an edge, a pair of vertices, in World, in full digits."""
        i, j = edge
        along = combine(vector(self.vertices[i]), -1, vector(self.vertices[j]))
        return [dot(along, vector(row)) for row in self.R]


def posed(shape: Form, R: Any, p: Any) -> MinkowskiSum:
    """Return a shape, any but a half space, at a pose."""
    kind, size = shape[0], np.asarray(shape[1], dtype=float)
    vertices, edges = np.zeros((1, 3)), np.zeros((0, 2), dtype=np.int64)
    radius, flat, poles = 0.0, np.zeros((0, 3)), np.zeros((0, 3))
    R, p = np.asarray(R, dtype=float), np.asarray(p, dtype=float)
    if kind == BOX:
        vertices = box_corners(2.0 * size)
        edges = np.array([(i, i + b) for b in (1, 2, 4) for i in range(8) if not i & b])
    elif kind == CONVEX:
        vertices = size[1:].reshape(3, -1).T
        triangles = ConvexHull(vertices).simplices
        pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges = np.unique(pairs, axis=0).astype(np.int64)
    elif kind == ELLIPSOID:
        flat = np.diag(size)
    elif kind != SPHERE:
        vertices = np.array([[0.0, 0.0, -size[1]], [0.0, 0.0, size[1]]])
        edges = np.array([[0, 1]])
    if kind in (SPHERE, CAPSULE):
        radius = float(size[0])
    elif kind == CYLINDER:
        flat = size[0] * np.eye(3)[:2]
        poles = np.vstack([R[:, 2], -R[:, 2]])
    return MinkowskiSum(vertices, edges, radius, flat, R, p, poles)


def offset_between(p_WA: Any, p_WB: Any) -> list[Any]:
    """Return p_AB in full digits."""
    return combine(vector(p_WB), -1, vector(p_WA))


class MinkowskiDifference:
    """B - A of two bounded bodies, and f."""

    def __init__(self, a: MinkowskiSum, b: MinkowskiSum) -> None:
        self.offset = offset_between(a.p, b.p)
        zero = np.zeros(3)
        p_AB = np.array([float(x) for x in self.offset])
        self.a = MinkowskiSum(a.vertices, a.edges, a.radius, a.flat, a.R, zero, a.poles)
        self.b = MinkowskiSum(b.vertices, b.edges, b.radius, b.flat, b.R, p_AB, b.poles)
        self.size = a.size + b.size + float(np.linalg.norm(p_AB))

    def gaps(self, n: Floats) -> Floats:
        """Return the points (m, 3) of B - A that are lowest along the unit directions n (m, 3)."""
        return self.b.points(-n) - self.a.points(n)

    def values(self, n: Floats) -> Floats:
        """Return f of unit directions (m, 3)."""
        return np.einsum('ij,ij->i', self.gaps(n), n)

    def exact(self, n: list[Any]) -> Any:
        """Return f of a direction of any length, in full digits."""
        heights = self.a.exact_height(n) + self.b.exact_height([-x for x in n])
        return (dot(self.offset, n) - heights) / norm(n)
