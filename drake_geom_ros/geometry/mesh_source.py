"""Mesh files to the vertices of their convex hulls: the only room that knows trimesh."""

from __future__ import annotations

import functools
import os

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.tolerances import FLAT_HULL
from drake_geom_ros.geometry.errors import MeshFileError

Floats = NDArray[np.float64]


def hull_vertices(filename: str, scale3: Floats) -> Floats:
    """Return the vertices (n, 3) [m] of the convex hull of a mesh file, scaled along x, y, z.

    Any format that trimesh reads. Raises MeshFileError for a file that is missing, holds no
    mesh or numbers that are not finite, or whose hull has no volume.
    """
    try:
        status = os.stat(filename)
    except OSError as error:
        raise MeshFileError(f'{filename!r} cannot be read: {error.strerror}') from None
    vertices: Floats = _hull(filename, status.st_mtime_ns, status.st_size) * scale3
    return vertices


@functools.lru_cache(maxsize=256)
def _hull(filename: str, mtime_ns: int, size: int) -> Floats:
    """Return the unscaled hull of a file in the state that its stamp and size tell."""
    # Slow to import, and most scenes have no mesh.
    import trimesh

    try:
        mesh = trimesh.load_mesh(filename, process=False)
        points = np.asarray(mesh.vertices, dtype=np.float64)
    except Exception as error:
        # A reader of many formats raises errors of many kinds.
        raise MeshFileError(f'{filename!r} holds no mesh that can be read: {error}') from None
    if len(points) == 0 or not np.isfinite(points).all():
        raise MeshFileError(f'{filename!r}: {len(points)} vertices, and all must be finite')
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(extents) < 3 or extents[2] <= FLAT_HULL * extents[0]:
        raise MeshFileError(
            f'{filename!r}: its {len(points)} vertices lie in a plane, and a convex hull without '
            'a volume has no inside; give the mesh a thickness'
        )
    hull = np.asarray(trimesh.Trimesh(points, process=False).convex_hull.vertices, dtype=float)
    hull.flags.writeable = False
    return hull
