"""Base of surfaces with flat faces: areas, normals, centroids."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.math.array_types import Floats, Indices

_F = TypeVar('_F', bound='FacetMesh')


class _Measures(NamedTuple):
    """Area times normal (k, 3) [m^2] and centroid (k, 3) [m] of faces."""

    area_vectors: Floats
    centroids: Floats


class FacetMesh:
    """A surface in a frame M: vertices, and faces that are counter-clockwise from outside.

    Raises RuntimeError for an invalid index of a vertex or face.
    """

    __slots__ = ('_faces', '_p_MVs')

    def _set(self, faces: Sequence[Indices] | Indices, p_MVs: Floats) -> None:
        """Store arrays, without a copy, after a check of the indices."""
        used = np.concatenate(faces) if len(faces) else np.zeros(0, dtype=np.int64)
        if used.size and not 0 <= used.min() <= used.max() < len(p_MVs):
            astray = (not 0 <= f.min() <= f.max() < len(p_MVs) for f in faces)
            bad = list(astray).index(True)
            raise ArgumentError(
                f'{type(self).__name__}: face {bad} has vertices {faces[bad].tolist()}, allowed '
                f'are 0 to {len(p_MVs) - 1}'
            )
        p_MVs.flags.writeable = False
        self._faces, self._p_MVs = faces, p_MVs

    def num_vertices(self) -> int:
        """Return the number of vertices."""
        return len(self._p_MVs)

    def num_elements(self) -> int:
        """Return the number of faces."""
        return len(self._faces)

    def vertex(self, v: int) -> Floats:
        """Return the position (3,) [m] of a vertex, in M."""
        if not 0 <= v < len(self._p_MVs):
            raise ArgumentError(f'vertex {v} was asked for; there are {len(self._p_MVs)}')
        position: Floats = self._p_MVs[v].copy()
        return position

    def vertex_array(self) -> Floats:
        """Return the positions (n, 3) [m] of the vertices, read-only."""
        return self._p_MVs

    def total_area(self) -> float:
        """Return the area [m^2] of all faces."""
        return float(np.linalg.norm(self._measures(self._faces).area_vectors, axis=1).sum())

    def centroid(self) -> Floats:
        """Return the centroid (3,) [m] of the surface, in M; 0 for one without area."""
        vectors, middles = self._measures(self._faces)
        areas = np.linalg.norm(vectors, axis=1)
        if areas.sum() == 0.0:
            return np.zeros(3)
        centroid: Floats = areas @ middles / areas.sum()
        return centroid

    def CalcBoundingBox(self) -> tuple[Floats, Floats]:
        """Return centre and size (3,) [m] of the box along M's axes around the vertices."""
        low, high = self._p_MVs.min(axis=0), self._p_MVs.max(axis=0)
        return 0.5 * (low + high), high - low

    def Equal(self: _F, mesh: _F) -> bool:
        """Return whether the other mesh has the same vertices and faces in the same order."""
        return (
            type(mesh) is type(self)
            and len(mesh._faces) == len(self._faces)
            and np.array_equal(mesh._p_MVs, self._p_MVs)
            and all(map(np.array_equal, mesh._faces, self._faces))
        )

    def _face(self, k: int) -> Indices:
        """Return the vertices of a face."""
        if not 0 <= k < len(self._faces):
            raise ArgumentError(f'face {k} was asked for; there are {len(self._faces)}')
        return self._faces[k]

    def _area(self, k: int) -> float:
        """Return the area [m^2] of a face."""
        return float(np.linalg.norm(self._measures([self._face(k)]).area_vectors))

    def _normal(self, k: int) -> Floats:
        """Return the unit normal (3,) of a face, in M; 0 for one without area."""
        vector: Floats = self._measures([self._face(k)]).area_vectors[0]
        return vector / (float(np.linalg.norm(vector)) or 1.0)

    def _middle(self, k: int) -> Floats:
        """Return the centroid (3,) [m] of a face, in M."""
        middle: Floats = self._measures([self._face(k)]).centroids[0]
        return middle

    def _measures(self, faces: Sequence[Indices] | Indices) -> _Measures:
        """Return the measures of faces.

        They are sums over the fan of triangles about the first corner, by signed area. A face
        without area has the mean of its corners as centroid.
        """
        fans, owners = _fans(faces)
        a, b, c = (self._p_MVs[fans[:, i]] for i in range(3))
        parts = 0.5 * np.cross(b - a, c - a)
        vectors = np.zeros((len(faces), 3))
        np.add.at(vectors, owners, parts)
        signed = (parts * vectors[owners]).sum(axis=1)
        weights = np.bincount(owners, signed, len(faces))
        flat = weights == 0.0
        signed[flat[owners]] = 1.0
        weights = np.bincount(owners, signed, len(faces))
        middles = np.zeros((len(faces), 3))
        np.add.at(middles, owners, signed[:, None] * (a + b + c) / 3.0)
        return _Measures(vectors, middles / weights[:, None])


def _fans(faces: Sequence[Indices] | Indices) -> tuple[Indices, Indices]:
    """Return the triangles (t, 3) of all faces' fans, and the face (t,) of each."""
    if isinstance(faces, np.ndarray):
        return faces, np.arange(len(faces))
    fans = [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]
    owners = [k for k, face in enumerate(faces) for _ in range(len(face) - 2)]
    return np.array(fans, dtype=np.int64).reshape(-1, 3), np.array(owners, dtype=np.int64)


class Facet:
    """A face of a mesh: the indices of its vertices, counter-clockwise from outside."""

    __slots__ = ('_vertices',)

    def __init__(self, vertices: Sequence[int]) -> None:
        self._vertices = tuple(int(vertex) for vertex in vertices)
        if min(self._vertices) < 0:
            raise ArgumentError(
                f'{type(self).__name__}: vertex indices {self._vertices} must be >= 0'
            )

    def num_vertices(self) -> int:
        """Return the number of vertices of the face."""
        return len(self._vertices)

    def vertex(self, i: int) -> int:
        """Return the index of vertex ``i`` of the face, counted from 0."""
        if not 0 <= i < len(self._vertices):
            raise ArgumentError(
                f'{type(self).__name__}.vertex: i = {i} must be from 0 to '
                f'{len(self._vertices) - 1}'
            )
        return self._vertices[i]

    def __repr__(self) -> str:
        return f'{type(self).__name__}{self._vertices}'


def vertices_of(triangles: Sequence[Facet]) -> Indices:
    """Return the indices (n, 3) of the vertices of triangles."""
    return np.array([each._vertices for each in triangles], dtype=np.int64).reshape(-1, 3)


def positions(vertices: ArrayLike, what: str) -> Floats:
    """Return a copy of positions (n, 3) [m]; raises ArgumentError for invalid ones."""
    p_MVs = np.array(vertices, dtype=np.float64)
    if p_MVs.size == 0:
        p_MVs = p_MVs.reshape(-1, 3)
    if p_MVs.ndim != 2 or p_MVs.shape[1] != 3 or not np.isfinite(p_MVs).all():
        raise ArgumentError(f'{what} {p_MVs.shape} must be finite, (n, 3)')
    return p_MVs
