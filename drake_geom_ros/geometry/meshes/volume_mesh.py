"""``VolumeMesh``: meshes of tetrahedra."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.meshes._facet_mesh import Facet, positions
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.arrays import as_vector

# The corners of the face opposite to each corner of a tetrahedron, counter-clockwise from outside.
OUTER_FACES = np.array([(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)])


class VolumeElement(Facet):
    """A tetrahedron of a VolumeMesh: the indices of its four vertices.

    The first three are counter-clockwise when seen from the fourth.
    """

    __slots__ = ()

    def __init__(self, v0: int, v1: int, v2: int, v3: int) -> None:
        super().__init__((v0, v1, v2, v3))


class VolumeMesh:
    """A body of tetrahedra in a frame M; ``vertices`` are positions (n, 3) [m].

    Raises RuntimeError for an element with an invalid vertex, and for a method called with an
    invalid index of an element or vertex.

        >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        >>> round(VolumeMesh([VolumeElement(0, 1, 2, 3)], corners).CalcVolume(), 6)
        0.166667
    """

    __slots__ = ('_elements', '_p_MVs')

    def __init__(self, elements: Sequence[VolumeElement], vertices: ArrayLike) -> None:
        for element in elements:
            checked_type(element, VolumeElement, 'VolumeMesh: element')
        rows = [[element.vertex(i) for i in range(4)] for element in elements]
        self._set(np.array(rows, dtype=np.int64).reshape(-1, 4), vertices)

    @classmethod
    def FromArrays(cls, elements: ArrayLike, p_MVs: ArrayLike) -> VolumeMesh:
        """Return the mesh of vertex indices (m, 4) and vertex positions (n, 3) [m]."""
        indices = np.array(elements)
        if indices.ndim != 2 or indices.shape[1] != 4 or indices.dtype.kind not in 'iu':
            raise ArgumentError(f'VolumeMesh: elements {indices.shape} must be integers (m, 4)')
        mesh = cls.__new__(cls)
        mesh._set(indices.astype(np.int64), p_MVs)
        return mesh

    def _set(self, elements: Indices, vertices: ArrayLike) -> None:
        p_MVs = positions(vertices, 'VolumeMesh: vertices')
        astray = ((elements < 0) | (elements >= len(p_MVs))).any(axis=1)
        if astray.any():
            bad = int(np.argmax(astray))
            raise ArgumentError(
                f'VolumeMesh: element {bad} has vertices {elements[bad].tolist()}, allowed are 0 '
                f'to {len(p_MVs) - 1}'
            )
        elements.flags.writeable = p_MVs.flags.writeable = False
        self._elements, self._p_MVs = elements, p_MVs

    def element_array(self) -> Indices:
        """Return the vertex indices (m, 4) of the elements, read-only."""
        return self._elements

    def vertex_array(self) -> Floats:
        """Return the positions (n, 3) [m] of the vertices, read-only."""
        return self._p_MVs

    def num_elements(self) -> int:
        """Return the number of tetrahedra."""
        return len(self._elements)

    def num_vertices(self) -> int:
        """Return the number of vertices."""
        return len(self._p_MVs)

    def element(self, e: int) -> VolumeElement:
        """Return a tetrahedron."""
        return VolumeElement(*self._corners(e).tolist())

    def tetrahedra(self) -> list[VolumeElement]:
        """Return the tetrahedra."""
        return [VolumeElement(*row) for row in self._elements.tolist()]

    def vertex(self, v: int) -> Floats:
        """Return the position (3,) [m] of a vertex, in M."""
        if not 0 <= v < len(self._p_MVs):
            raise ArgumentError(f'vertex {v} was asked for; there are {len(self._p_MVs)}')
        position: Floats = self._p_MVs[v].copy()
        return position

    def vertices(self) -> list[Floats]:
        """Return the positions (3,) [m] of the vertices, in M."""
        return [row.copy() for row in self._p_MVs]

    def edge_vector(self, e: int, a: int, b: int) -> Floats:
        """Return the vector (3,) [m] from corner ``a`` to corner ``b`` of an element, in M."""
        corners = self._corners(e)
        vector: Floats = self._p_MVs[corners[_local(b)]] - self._p_MVs[corners[_local(a)]]
        return vector

    def inward_normal(self, e: int, f: int) -> Floats:
        """Return the inward unit normal (3,) of the face opposite corner ``f`` of an element."""
        a, b, c = self._p_MVs[self._corners(e)[OUTER_FACES[_local(f)]]]
        normal: Floats = np.cross(c - a, b - a)
        return normal / (float(np.linalg.norm(normal)) or 1.0)

    def CalcTetrahedronVolume(self, e: int) -> float:
        """Return the volume [m^3] of an element, negative for one that is inside out."""
        return float(signed_volumes(self._corners(e)[None], self._p_MVs)[0])

    def CalcVolume(self) -> float:
        """Return the volume [m^3] of all elements, those inside out counted as negative."""
        return float(signed_volumes(self._elements, self._p_MVs).sum())

    def CalcBarycentric(self, p_MQ: ArrayLike, e: int) -> Floats:
        """Return the barycentric coordinates (4,) in an element of a point (3,) [m] in M.

        Raises RuntimeError for an element without volume.
        """
        corners = self._p_MVs[self._corners(e)]
        sides = (corners[1:] - corners[0]).T
        offset = as_vector(p_MQ, 'CalcBarycentric: p_MQ') - corners[0]
        try:
            weights = np.linalg.solve(sides, offset)
        except np.linalg.LinAlgError:
            raise ArgumentError(f'CalcBarycentric: element {e} has no volume') from None
        return np.concatenate(([1.0 - weights.sum()], weights))

    def Equal(self, mesh: VolumeMesh, vertex_tolerance: float = 0.0) -> bool:
        """Return whether a mesh has the same elements, and vertices within a tolerance [m]."""
        if not np.array_equal(mesh._elements, self._elements):
            return False
        if mesh._p_MVs.shape != self._p_MVs.shape:
            return False
        apart = np.linalg.norm(mesh._p_MVs - self._p_MVs, axis=1)
        return bool((apart <= vertex_tolerance).all())

    def _corners(self, e: int) -> Indices:
        """Return the vertices (4,) of an element."""
        if not 0 <= e < len(self._elements):
            raise ArgumentError(f'element {e} was asked for; there are {len(self._elements)}')
        corners: Indices = self._elements[e]
        return corners


def signed_volumes(elements: Indices, p_MVs: Floats) -> Floats:
    """Return the volumes (m,) [m^3] of tetrahedra, negative where they are inside out."""
    a, b, c, d = (p_MVs[elements[:, i]] for i in range(4))
    volumes: Floats = (np.cross(b - a, c - a) * (d - a)).sum(axis=1) / 6.0
    return volumes


def _local(corner: int) -> int:
    """Return the index of a tetrahedron's corner; raises an error for an invalid one."""
    if not 0 <= corner < 4:
        raise ArgumentError(f'a tetrahedron has the corners 0 to 3, not {corner}')
    return corner
