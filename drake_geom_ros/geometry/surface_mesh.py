"""Triangle meshes, and reading them from files."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._obj_file import read_obj
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.instances import checked_type
from drake_geom_ros.math.arrays import as_vector

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class SurfaceVertex:
    """A vertex of a SurfaceMesh: where it is in the mesh's frame M."""

    __slots__ = ('_r_MV',)

    def __init__(self, r_MV: ArrayLike) -> None:
        self._r_MV = as_vector(r_MV, 'SurfaceVertex: r_MV')
        self._r_MV.flags.writeable = False

    def r_MV(self) -> Floats:
        """Return the position (3,) [m] from Mo, in M."""
        return self._r_MV

    def __repr__(self) -> str:
        return f'SurfaceVertex({self._r_MV.tolist()})'


class SurfaceFace:
    """A triangle of a SurfaceMesh: the indices of its vertices, counter-clockwise from outside."""

    __slots__ = ('_vertices',)

    def __init__(self, v0: int, v1: int, v2: int) -> None:
        self._vertices = int(v0), int(v1), int(v2)
        if min(self._vertices) < 0:
            raise ArgumentError(f'SurfaceFace: vertex indices {self._vertices} must be >= 0')

    def num_vertices(self) -> int:
        """Return 3."""
        return len(self._vertices)

    def vertex(self, i: int) -> int:
        """Return the index of vertex ``i``, which is 0, 1 or 2."""
        if i not in (0, 1, 2):
            raise ArgumentError(f'SurfaceFace.vertex: i = {i} must be 0, 1 or 2')
        return self._vertices[i]

    def __repr__(self) -> str:
        return f'SurfaceFace{self._vertices}'


class SurfaceMesh:
    """A triangulated surface in a frame M.

    Raises RuntimeError for a face with an index of no vertex.

        >>> corners = [SurfaceVertex(p) for p in ([0, 0, 0], [1, 0, 0], [0, 1, 0])]
        >>> SurfaceMesh([SurfaceFace(0, 1, 2)], corners).num_faces()
        1
    """

    __slots__ = ('_p_MVs', '_triangles')

    def __init__(self, faces: Sequence[SurfaceFace], vertices: Sequence[SurfaceVertex]) -> None:
        for face in faces:
            checked_type(face, SurfaceFace, 'SurfaceMesh: face')
        for vertex in vertices:
            checked_type(vertex, SurfaceVertex, 'SurfaceMesh: vertex')
        self._set(
            np.array([face._vertices for face in faces], dtype=np.int64).reshape(-1, 3),
            np.array([vertex.r_MV() for vertex in vertices]).reshape(-1, 3),
        )

    @classmethod
    def FromArrays(cls, triangles: ArrayLike, p_MVs: ArrayLike) -> SurfaceMesh:
        """Return the mesh of vertex indices (m, 3) and vertex positions (n, 3) [m]."""
        indices, positions = np.array(triangles), np.array(p_MVs, dtype=np.float64)
        if indices.ndim != 2 or indices.shape[1] != 3 or indices.dtype.kind not in 'iu':
            raise ArgumentError(f'SurfaceMesh: triangles {indices.shape} must be integers (m, 3)')
        if positions.ndim != 2 or positions.shape[1] != 3 or not np.isfinite(positions).all():
            raise ArgumentError(f'SurfaceMesh: p_MVs {positions.shape} must be finite, (n, 3)')
        mesh = cls.__new__(cls)
        mesh._set(indices.astype(np.int64), positions)
        return mesh

    def _set(self, triangles: Indices, p_MVs: Floats) -> None:
        """Take arrays that are ours, once the indices are checked."""
        bad = np.flatnonzero(((triangles < 0) | (triangles >= len(p_MVs))).any(axis=1))
        if bad.size:
            raise ArgumentError(
                f'SurfaceMesh: face {bad[0]} has vertices {triangles[bad[0]].tolist()}, allowed '
                f'are 0 to {len(p_MVs) - 1}'
            )
        triangles.flags.writeable = p_MVs.flags.writeable = False
        self._triangles, self._p_MVs = triangles, p_MVs

    def faces(self) -> list[SurfaceFace]:
        """Return the triangles."""
        return [SurfaceFace(*row) for row in self._triangles.tolist()]

    def vertices(self) -> list[SurfaceVertex]:
        """Return the vertices."""
        return [SurfaceVertex(row) for row in self._p_MVs]

    def num_faces(self) -> int:
        """Return how many triangles there are."""
        return len(self._triangles)

    def num_vertices(self) -> int:
        """Return how many vertices there are."""
        return len(self._p_MVs)

    def triangle_array(self) -> Indices:
        """Return the vertex indices (m, 3) of the triangles, not to be written to."""
        return self._triangles

    def vertex_array(self) -> Floats:
        """Return the positions (n, 3) [m] of the vertices, not to be written to."""
        return self._p_MVs


def ReadObjToSurfaceMesh(filename: str | os.PathLike[str], scale: float = 1.0) -> SurfaceMesh:
    """Return the mesh in a Wavefront .obj file, coordinates multiplied by ``scale``.

    Polygons are cut into triangles, the objects of the file are merged. Raises RuntimeError,
    naming file and line, for a file that cannot be read, has no faces, or has a face of a vertex
    that does not exist; and for a scale that is 0 or not finite.
    """
    if not math.isfinite(scale) or scale == 0.0:
        raise ArgumentError(f'ReadObjToSurfaceMesh: scale = {scale} must be finite and not 0')
    p_MVs, triangles = read_obj(filename)
    return SurfaceMesh.FromArrays(triangles, scale * p_MVs)
