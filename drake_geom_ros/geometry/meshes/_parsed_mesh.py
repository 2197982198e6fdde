"""The result of mesh file readers, and the collection of a scene's pieces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.math.array_types import Floats, Indices


class ParsedMesh(NamedTuple):
    """Vertices (n, 3) [m] and triangles (m, 3) of them, after a file's own transforms.

    ``colours`` (m, 3) from 0 to 1 are those of the triangles, None if the file has none.
    ``remarks`` describe the conversions of the file's numbers, applied or not. ``volume`` are the
    tetrahedra with the triangles as boundary, None if the file has none.
    """

    vertices: Floats
    triangles: Indices
    colours: NDArray[np.float32] | None = None
    remarks: tuple[str, ...] = ()
    volume: VolumeMesh | None = None


class Pieces:
    """Collects the pieces of a scene, each transformed to its place."""

    def __init__(self) -> None:
        self._vertices: list[Floats] = [np.zeros((0, 3))]
        self._triangles: list[Indices] = [np.zeros((0, 3), dtype=np.int64)]
        self._count = 0

    def add(self, T: Floats, vertices: Floats, triangles: Indices) -> None:
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

    def all(self) -> tuple[Floats, Indices]:
        """Return the vertices and the triangles of all pieces."""
        return np.concatenate(self._vertices), np.concatenate(self._triangles)
