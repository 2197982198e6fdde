"""Scalar fields on surfaces: a number at each vertex, linear on each face."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.meshes.polygon_mesh import PolygonSurfaceMesh
from drake_geom_ros.geometry.meshes.surface_mesh import TriangleSurfaceMesh
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.arrays import as_vector


class _SurfaceField:
    """Base of both kinds: the values, and the gradient (f, 3) on each face."""

    __slots__ = ('_gradients', '_values')

    def __init__(self, values: Floats, gradients: Floats) -> None:
        self._values, self._gradients = values, gradients

    def EvaluateAtVertex(self, v: int) -> float:
        """Return the value at a vertex; raises RuntimeError for an invalid index."""
        if not 0 <= v < len(self._values):
            raise ArgumentError(f'vertex {v} was asked for; there are {len(self._values)}')
        return float(self._values[v])

    def _gradient(self, e: int) -> Floats:
        """Return the gradient of a face; raises an error for an invalid index."""
        if not 0 <= e < len(self._gradients):
            raise ArgumentError(f'face {e} was asked for; there are {len(self._gradients)}')
        gradient: Floats = self._gradients[e].copy()
        return gradient


class PolygonSurfaceMeshFieldLinear(_SurfaceField):
    """A linear field on the polygons of a mesh."""

    __slots__ = ('_mesh',)

    def __init__(self, mesh: PolygonSurfaceMesh, values: Floats, gradients: Floats) -> None:
        super().__init__(values, gradients)
        self._mesh = mesh

    def EvaluateCartesian(self, e: int, p_MQ: ArrayLike) -> float:
        """Return the value of face ``e``'s linear function at a point (3,) [m] in M."""
        gradient, corner = self._gradient(e), self._mesh.element(e).vertex(0)
        offset = as_vector(p_MQ, 'EvaluateCartesian: p_MQ') - self._mesh.vertex(corner)
        return float(self._values[corner] + gradient @ offset)

    def EvaluateGradient(self, e: int) -> Floats:
        """Return the gradient (3,) of face ``e``'s linear function, in M."""
        return self._gradient(e)


class TriangleSurfaceMeshFieldLinear(_SurfaceField):
    """A linear field on the triangles of a mesh."""

    __slots__ = ('_mesh',)

    def __init__(self, mesh: TriangleSurfaceMesh, values: Floats, gradients: Floats) -> None:
        super().__init__(values, gradients)
        self._mesh = mesh

    def Evaluate(self, e: int, b: ArrayLike) -> float:
        """Return the value at barycentric coordinates (3,) of triangle ``e``."""
        corners = [self._mesh.element(e).vertex(i) for i in range(3)]
        return float(as_vector(b, 'Evaluate: b') @ self._values[np.array(corners)])

    def EvaluateCartesian(self, e: int, p_MQ: ArrayLike) -> float:
        """Return the value on triangle ``e`` at a point (3,) [m] in M, or its projection."""
        return self.Evaluate(e, self._mesh.CalcBarycentric(p_MQ, e))
