"""What a reader of mesh files returns, and what all of them share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class ParsedMesh(NamedTuple):
    """Vertices (n, 3) [m] and triangles (m, 3) of them, as a file's own rules place them.

    ``colours`` (m, 3) from 0 to 1 of the triangles, None where the file has none; ``remarks`` say
    in words what was done to the numbers of the file, and what was not. ``volume`` are the
    tetrahedra that the triangles are the boundary of, None where the file has none.
    """

    vertices: Floats
    triangles: Indices
    colours: NDArray[np.float32] | None = None
    remarks: tuple[str, ...] = ()
    volume: VolumeMesh | None = None


class Pieces:
    """Collects the pieces of a scene, each moved to its place."""

    def __init__(self) -> None:
        self._vertices: list[Floats] = [np.zeros((0, 3))]
        self._triangles: list[Indices] = [np.zeros((0, 3), dtype=np.int64)]
        self._count = 0

    def add(self, T: Floats, vertices: Floats, triangles: Indices) -> None:
        """Add a piece by its transform (4, 4); raises ValueError for an index of no vertex."""
        if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(vertices):
            raise ValueError(
                f'a triangle has the vertex {triangles.max()}; there are {len(vertices)}'
            )
        # A mirror image turns every triangle around.
        turned = triangles[:, ::-1] if np.linalg.det(T[:3, :3]) < 0.0 else triangles
        self._vertices.append(vertices @ T[:3, :3].T + T[:3, 3])
        self._triangles.append(turned + self._count)
        self._count += len(vertices)

    def all(self) -> tuple[Floats, Indices]:
        """Return the vertices and the triangles of all pieces."""
        return np.concatenate(self._vertices), np.concatenate(self._triangles)
