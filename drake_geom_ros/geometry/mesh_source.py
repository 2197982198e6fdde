"""Meshes, from files or from numbers, to convex hulls: the only room that knows trimesh."""

from __future__ import annotations

import functools
import math
import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.tolerances import FLAT_HULL
from drake_geom_ros.geometry.errors import ArgumentError, MeshFileError

# A file is read whole, and trimesh needs some ten times its size; a scan of 2 million triangles as
# binary STL has 100 MB.
MAX_MESH_BYTES = 200_000_000
HULL_EXPONENT = 24  # hulls are made of points brought to about 2^24

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class MeshData:
    """A mesh that came as numbers, not as a file: compared and hashed by its content.

    ``vertices`` (n, 3) [m] and ``triangles`` (m, 3), indices of vertices, are not to be written
    to. Raises ArgumentError for other shapes, numbers that are not finite and wrong indices.
    """

    __slots__ = ('_key', 'triangles', 'vertices')

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike = ()) -> None:
        points = np.array(vertices, dtype=np.float64)
        faces = np.array(triangles, dtype=np.int64)
        faces = faces.reshape(-1, 3) if faces.size == 0 else faces
        for name, array in (('vertices', points), ('triangles', faces)):
            if array.ndim != 2 or array.shape[1] != 3:
                raise ArgumentError(f'MeshData: {name} {array.shape} must be (n, 3)')
        if not np.isfinite(points).all():
            raise ArgumentError('MeshData: all vertices must be finite')
        bad = np.flatnonzero(((faces < 0) | (faces >= len(points))).any(axis=1))
        if bad.size:
            raise ArgumentError(
                f'MeshData: triangles[{bad[0]}] is {faces[bad[0]].tolist()}; there are '
                f'{len(points)} vertices, counted from 0'
            )
        points.flags.writeable = faces.flags.writeable = False
        self.vertices: Floats = points
        self.triangles: Indices = faces
        self._key = points.tobytes(), faces.tobytes()

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, MeshData) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def __repr__(self) -> str:
        return f'<MeshData of {len(self.vertices)} vertices, {len(self.triangles)} triangles>'


def hull_vertices(source: str | MeshData, scale3: Floats) -> Floats:
    """Return the vertices (n, 3) [m] of the convex hull of a mesh, scaled along x, y, z.

    ``source`` is numbers or a file of any format that trimesh reads. Raises MeshFileError for a
    file that is missing, holds no mesh or numbers that are not finite, or where the hull has no
    volume.
    """
    return hull_surface(source, scale3)[0]


def hull_surface(source: str | MeshData, scale3: Floats) -> tuple[Floats, Indices]:
    """Return ``hull_vertices`` and the hull's triangles (m, 3), counter-clockwise from outside."""
    if isinstance(source, MeshData):
        vertices, triangles = _hull_of_data(source)
    else:
        try:
            status = os.stat(source)
        except OSError as error:
            raise MeshFileError(f'{source!r} cannot be read: {error.strerror}') from None
        if status.st_size > MAX_MESH_BYTES:
            raise MeshFileError(
                f'{source!r} has {status.st_size} bytes; at most {MAX_MESH_BYTES} are read: '
                'collision geometry needs a simpler mesh'
            )
        vertices, triangles = _hull_of_file(source, status.st_mtime_ns, status.st_size)
    # A mirror image turns every triangle around.
    mirrored = np.prod(np.sign(scale3)) < 0.0
    return vertices * scale3, triangles[:, ::-1] if mirrored else triangles


@functools.lru_cache(maxsize=256)
def _hull_of_data(data: MeshData) -> tuple[Floats, Indices]:
    return _hull(data.vertices, 'a mesh given as numbers')


@functools.lru_cache(maxsize=256)
def _hull_of_file(filename: str, mtime_ns: int, size: int) -> tuple[Floats, Indices]:
    """Return the unscaled hull of a file in the state that its stamp and size tell."""
    # Slow to import, and most scenes have no mesh.
    import trimesh

    try:
        mesh = trimesh.load_mesh(filename, process=False)
        points = np.asarray(mesh.vertices, dtype=np.float64)
    except Exception as error:
        # A reader of many formats raises errors of many kinds.
        raise MeshFileError(f'{filename!r} holds no mesh that can be read: {error}') from None
    return _hull(points, repr(filename))


def _hull(points: Floats, name: str) -> tuple[Floats, Indices]:
    """Return vertices and triangles of the convex hull of points; ``name`` is for the error."""
    import trimesh

    if len(points) == 0 or not np.isfinite(points).all():
        raise MeshFileError(f'{name}: {len(points)} vertices, and all must be finite')
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(extents) < 3 or extents[2] <= FLAT_HULL * extents[0]:
        raise MeshFileError(
            f'{name}: its {len(points)} vertices lie in a plane, and a convex hull without '
            'a volume has no inside; give the mesh a thickness'
        )
    # trimesh merges vertices within 1e-8 and drops triangles below 1e-14: at this size that is
    # rounding. A power of two, so that the points stay what they are.
    exponent = HULL_EXPONENT - math.frexp(float(np.abs(points).max()))[1]
    hull = trimesh.Trimesh(np.ldexp(points, exponent), process=False).convex_hull
    vertices = np.ldexp(np.array(hull.vertices, dtype=np.float64), -exponent)
    triangles = np.array(hull.faces, dtype=np.int64)
    vertices.flags.writeable = triangles.flags.writeable = False
    return vertices, triangles
