"""Meshes of polygons, such as the convex hull of a Mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.meshes._facet_mesh import Facet, FacetMesh, positions
from drake_geom_ros.math.array_types import Floats, Indices


class SurfacePolygon(Facet):
    """A polygon of a PolygonSurfaceMesh: the indices of its vertices."""

    __slots__ = ()


class PolygonSurfaceMesh(FacetMesh):
    """A surface of plane polygons in a frame M; empty without arguments.

    ``face_data`` has, for each polygon, the number of its vertices and then their indices,
    counter-clockwise from outside; ``vertices`` are positions (n, 3) [m].

        >>> square = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]
        >>> PolygonSurfaceMesh(face_data=[4, 0, 1, 2, 3], vertices=square).total_area()
        2.0
    """

    __slots__ = ()

    def __init__(self, face_data: Sequence[int] = (), vertices: ArrayLike = ()) -> None:
        data = np.array(face_data, dtype=np.int64)
        faces: list[Indices] = []
        start = 0
        while start < len(data):
            count, start = int(data[start]), start + 1
            if not 3 <= count <= len(data) - start:
                raise ArgumentError(
                    f'PolygonSurfaceMesh: face {len(faces)} is said to have {count} vertices; it '
                    f'must have 3 or more, and {len(data) - start} numbers follow'
                )
            faces.append(data[start : start + count])
            start += count
        self._set(faces, positions(vertices, 'PolygonSurfaceMesh: vertices'))

    @classmethod
    def FromPolygons(
        cls, polygons: Sequence[Sequence[int]], vertices: ArrayLike
    ) -> PolygonSurfaceMesh:
        """Return the mesh of polygons, each as indices of vertices, and positions (n, 3) [m]."""
        return cls([n for polygon in polygons for n in (len(polygon), *polygon)], vertices)

    def element(self, e: int) -> SurfacePolygon:
        """Return a polygon."""
        return SurfacePolygon(self._face(e).tolist())

    def num_faces(self) -> int:
        """Return the number of polygons."""
        return self.num_elements()

    def area(self, f: int) -> float:
        """Return the area [m^2] of a polygon."""
        return self._area(f)

    def face_normal(self, f: int) -> Floats:
        """Return the unit normal (3,) of a polygon, in M; 0 for one without area."""
        return self._normal(f)

    def element_centroid(self, e: int) -> Floats:
        """Return the centroid (3,) [m] of a polygon, in M."""
        return self._middle(e)

    def face_data(self) -> list[int]:
        """Return, for each polygon, the number of its vertices and then their indices."""
        return [n for face in self._faces for n in (len(face), *face.tolist())]
