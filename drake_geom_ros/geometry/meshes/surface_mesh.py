"""Triangle meshes, with pydrake's names of today and of 2020, and readers of .obj files."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.meshes._facet_mesh import Facet, FacetMesh, positions, vertices_of
from drake_geom_ros.geometry.meshes._obj_file import read_obj
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.arrays import as_vector

_T = TypeVar('_T', bound='_TriangleMesh')


class SurfaceVertex:
    """A vertex of a SurfaceMesh: its position in the mesh's frame M."""

    __slots__ = ('_r_MV',)

    def __init__(self, r_MV: ArrayLike) -> None:
        self._r_MV = as_vector(r_MV, 'SurfaceVertex: r_MV')
        self._r_MV.flags.writeable = False

    def r_MV(self) -> Floats:
        """Return the position (3,) [m] from Mo, in M."""
        return self._r_MV

    def __repr__(self) -> str:
        return f'SurfaceVertex({self._r_MV.tolist()})'


class SurfaceTriangle(Facet):
    """A triangle of a mesh: the indices of its vertices, counter-clockwise from outside."""

    __slots__ = ()

    def __init__(self, v0: int, v1: int, v2: int) -> None:
        super().__init__((v0, v1, v2))


class SurfaceFace(SurfaceTriangle):
    """A triangle of a SurfaceMesh; the older name of SurfaceTriangle."""

    __slots__ = ()


class _TriangleMesh(FacetMesh):
    """Base of both kinds of triangle mesh."""

    __slots__ = ()
    _faces: Indices

    @classmethod
    def FromArrays(cls: type[_T], triangles: ArrayLike, p_MVs: ArrayLike) -> _T:
        """Return the mesh of vertex indices (m, 3) and vertex positions (n, 3) [m]."""
        indices, kind = np.array(triangles), cls.__name__
        if indices.ndim != 2 or indices.shape[1] != 3 or indices.dtype.kind not in 'iu':
            raise ArgumentError(f'{kind}: triangles {indices.shape} must be integers (m, 3)')
        mesh = cls.__new__(cls)
        mesh._set_triangles(indices.astype(np.int64), positions(p_MVs, f'{kind}: p_MVs'))
        return mesh

    def _set_triangles(self, triangles: Indices, p_MVs: Floats) -> None:
        self._set(triangles, p_MVs)
        triangles.flags.writeable = False

    def triangle_array(self) -> Indices:
        """Return the vertex indices (m, 3) of the triangles, read-only."""
        return self._faces


class TriangleSurfaceMesh(_TriangleMesh):
    """A triangulated surface in a frame M; ``vertices`` are positions (n, 3) [m].

    Raises RuntimeError for a triangle with an invalid vertex.

        >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        >>> TriangleSurfaceMesh([SurfaceTriangle(0, 1, 2)], corners).total_area()
        0.5
    """

    __slots__ = ()

    def __init__(self, triangles: Sequence[SurfaceTriangle], vertices: ArrayLike) -> None:
        for triangle in triangles:
            checked_type(triangle, SurfaceTriangle, 'TriangleSurfaceMesh: triangle')
        self._set_triangles(
            vertices_of(triangles),
            positions(vertices, 'TriangleSurfaceMesh: vertices'),
        )

    def triangles(self) -> list[SurfaceTriangle]:
        """Return the triangles."""
        return [SurfaceTriangle(*row) for row in self._faces.tolist()]

    def vertices(self) -> list[Floats]:
        """Return the positions (3,) [m] of the vertices, in M."""
        return [row.copy() for row in self._p_MVs]

    def num_triangles(self) -> int:
        """Return the number of triangles."""
        return self.num_elements()

    def element(self, e: int) -> SurfaceTriangle:
        """Return a triangle."""
        return SurfaceTriangle(*self._face(e).tolist())

    def area(self, t: int) -> float:
        """Return the area [m^2] of a triangle."""
        return self._area(t)

    def face_normal(self, t: int) -> Floats:
        """Return the unit normal (3,) of a triangle, in M; 0 for one without area."""
        return self._normal(t)

    def element_centroid(self, t: int) -> Floats:
        """Return the centroid (3,) [m] of a triangle, in M."""
        return self._middle(t)

    def CalcBarycentric(self, p_MQ: ArrayLike, t: int) -> Floats:
        """Return the barycentric coordinates (3,) of a point (3,) [m] in a triangle.

        A point off the plane is projected onto it.
        """
        a, b, c = self._p_MVs[self._face(t)]
        sides = np.column_stack((b - a, c - a))
        weights = np.linalg.lstsq(sides, as_vector(p_MQ, 'CalcBarycentric: p_MQ') - a, rcond=None)
        second, third = weights[0]
        return np.array([1.0 - second - third, second, third])

    def CalcCartesianFromBarycentric(self, element_index: int, b_Q: ArrayLike) -> Floats:
        """Return the point (3,) [m], in M, of barycentric coordinates (3,) in a triangle."""
        weights = as_vector(b_Q, 'CalcCartesianFromBarycentric: b_Q')
        point: Floats = weights @ self._p_MVs[self._face(element_index)]
        return point


class SurfaceMesh(_TriangleMesh):
    """A triangulated surface in a frame M, with the names of 2020; see TriangleSurfaceMesh.

    Raises RuntimeError for a face with an invalid vertex.

        >>> corners = [SurfaceVertex(p) for p in ([0, 0, 0], [1, 0, 0], [0, 1, 0])]
        >>> SurfaceMesh([SurfaceFace(0, 1, 2)], corners).num_faces()
        1
    """

    __slots__ = ()

    def __init__(self, faces: Sequence[SurfaceFace], vertices: Sequence[SurfaceVertex]) -> None:
        for face in faces:
            checked_type(face, SurfaceFace, 'SurfaceMesh: face')
        for vertex in vertices:
            checked_type(vertex, SurfaceVertex, 'SurfaceMesh: vertex')
        self._set_triangles(
            vertices_of(faces),
            np.array([vertex.r_MV() for vertex in vertices]).reshape(-1, 3),
        )

    def faces(self) -> list[SurfaceFace]:
        """Return the triangles."""
        return [SurfaceFace(*row) for row in self._faces.tolist()]

    def vertices(self) -> list[SurfaceVertex]:
        """Return the vertices."""
        return [SurfaceVertex(row) for row in self._p_MVs]

    def num_faces(self) -> int:
        """Return the number of triangles."""
        return self.num_elements()


def ReadObjToTriangleSurfaceMesh(
    filename: str | os.PathLike[str], scale: float = 1.0, *, scale3: ArrayLike | None = None
) -> TriangleSurfaceMesh:
    """Return the mesh in a Wavefront .obj file; ``scale`` is one factor or one for each axis.

    Polygons are cut into triangles, the objects of the file are merged. Raises RuntimeError, with
    file and line, for a file that cannot be read, has no faces, or has an invalid vertex; and for
    a scale that is 0 or not finite.
    """
    factors = np.broadcast_to(np.asarray(scale if scale3 is None else scale3, np.float64), 3)
    if not np.isfinite(factors).all() or not factors.all():
        raise ArgumentError(
            f'ReadObjToTriangleSurfaceMesh: scale = {factors.tolist()} must be finite and not 0'
        )
    p_MVs, triangles = read_obj(filename)
    return TriangleSurfaceMesh.FromArrays(triangles, factors * p_MVs)


def ReadObjToSurfaceMesh(filename: str | os.PathLike[str], scale: float = 1.0) -> SurfaceMesh:
    """Return the result of ReadObjToTriangleSurfaceMesh as a SurfaceMesh."""
    if not math.isfinite(scale) or scale == 0.0:
        raise ArgumentError(f'ReadObjToSurfaceMesh: scale = {scale} must be finite and not 0')
    mesh = ReadObjToTriangleSurfaceMesh(filename, scale)
    return SurfaceMesh.FromArrays(mesh.triangle_array(), mesh.vertex_array())
