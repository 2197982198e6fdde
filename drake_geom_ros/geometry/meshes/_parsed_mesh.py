"""The result of mesh file readers, and the collection of a scene's pieces."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.math.array_types import Floats, Indices

_NO_PARTS: Mapping[str, Indices] = MappingProxyType({})


class ParsedMesh(NamedTuple):
    """Vertices (n, 3) [m] and triangles (m, 3) of them, after a file's own transforms.

    ``colours`` (m, 3) from 0 to 1 are those of the triangles, None if the file has none.
    ``remarks`` describe the conversions of the file's numbers, applied or not. ``volume`` are the
    tetrahedra with the triangles as boundary, None if the file has none. ``parts`` are the rows of
    triangles by the names that the file gives them: objects and groups of OBJ, nodes of glTF and
    Collada.
    """

    vertices: Floats
    triangles: Indices
    colours: NDArray[np.float32] | None = None
    remarks: tuple[str, ...] = ()
    volume: VolumeMesh | None = None
    parts: Mapping[str, Indices] = _NO_PARTS


class Pieces:
    """Collects the pieces of a scene, each transformed to its place."""

    def __init__(self) -> None:
        self._vertices: list[Floats] = [np.zeros((0, 3))]
        self._triangles: list[Indices] = [np.zeros((0, 3), dtype=np.int64)]
        self._count = self._rows = 0
        self._parts: dict[str, list[Indices]] = {}

    def add(self, T: Floats, vertices: Floats, triangles: Indices, name: str = '') -> None:
        """Add a piece with a transform (4, 4); raises ValueError for an invalid index."""
        if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
            raise ValueError(
                f'a triangle has the vertex {triangles.max()}; there are {len(vertices)}'
            )
        # A reflection reverses the orientation of triangles.
        turned = triangles[:, ::-1] if np.linalg.det(T[:3, :3]) < 0.0 else triangles
        self._vertices.append(vertices @ T[:3, :3].T + T[:3, 3])
        self._triangles.append(turned + self._count)
        self._count += len(vertices)
        if name and len(triangles):
            rows = np.arange(self._rows, self._rows + len(triangles))
            self._parts.setdefault(name, []).append(rows)
        self._rows += len(triangles)

    def all(self) -> tuple[Floats, Indices]:
        """Return the vertices and the triangles of all pieces."""
        return np.concatenate(self._vertices), np.concatenate(self._triangles)

    def parts(self) -> dict[str, Indices]:
        """Return the rows of the triangles of pieces, by their names."""
        return {name: np.concatenate(rows) for name, rows in self._parts.items()}
