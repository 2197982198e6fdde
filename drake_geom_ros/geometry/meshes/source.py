"""Meshes from files, memory or arrays, identified by content; their surfaces and hulls."""

from __future__ import annotations

import functools
import hashlib
import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import CoarseHull
from drake_geom_ros.geometry.errors import ArgumentError, MeshFileError
from drake_geom_ros.geometry.meshes._coarse_hulls import chosen_vertices, coarse_hull
from drake_geom_ros.geometry.meshes._companions import companions_of
from drake_geom_ros.geometry.meshes._formats import FORMATS, VOLUME_FORMATS, parse_mesh
from drake_geom_ros.geometry.meshes._hull_polygons import united
from drake_geom_ros.geometry.meshes._library import convex_hull
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh
from drake_geom_ros.geometry.meshes.in_memory import InMemoryMesh
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.tolerances import FARTHEST

# A file is read at once, and its numbers need some ten times its size; a scan of 2 million
# triangles as binary STL has 100 MB.
MAX_MESH_BYTES = 200_000_000


class MeshData:
    """A mesh in arrays; it compares and hashes by its content.

    ``vertices`` (n, 3) [m] and ``triangles`` (m, 3), indices of vertices, are read-only. Raises
    ArgumentError for other shapes, numbers that are not finite and invalid indices.
    """

    __slots__ = ('_key', 'triangles', 'vertices')

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike = ()) -> None:
        points = np.array(vertices, dtype=np.float64, order='C')
        faces = np.array(triangles, dtype=np.int64, order='C')
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
        # A digest, for the bytes themselves would be the whole mesh once more.
        digest = hashlib.blake2b(points.data, digest_size=32)
        digest.update(faces.data)
        self._key = len(points), digest.digest()

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, MeshData) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def __repr__(self) -> str:
        return f'<MeshData of {len(self.vertices)} vertices, {len(self.triangles)} triangles>'


class MeshFile:
    """A mesh file with its state at a time; it compares and hashes by its content.

    Two paths with the same bytes and the same format by suffix are the same mesh; so are the
    bytes of the files that it names for its numbers. Raises MeshFileError for a file that is
    missing or too large.
    """

    __slots__ = ('_key', 'filename')

    def __init__(self, filename: str) -> None:
        self.filename = filename
        digest, names = _facts_of(filename)
        digests = [_facts_of(_beside(filename, name)).digest for name in names]
        self._key = digest, self.kind, tuple(zip(names, digests, strict=True))

    @property
    def kind(self) -> str:
        """The format, by the suffix: lower case, without the dot."""
        return os.path.splitext(self.filename)[1].lower().lstrip('.')

    def content(self) -> bytes:
        """Return the bytes; raises MeshFileError if they have changed."""
        return _unchanged(self.filename, self._key[0])

    def companions(self) -> dict[str, bytes]:
        """Return the bytes of the files that it names, by name; errors as ``content``."""
        return {
            name: _unchanged(_beside(self.filename, name), digest) for name, digest in self._key[2]
        }

    def __eq__(self, other: object) -> bool:
        return self._key == other._key if isinstance(other, MeshFile) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key)

    def __repr__(self) -> str:
        return repr(self.filename)


# The mesh of a shape, and the key that identifies its content.
MeshGiven = str | MeshData | InMemoryMesh
MeshKey = MeshData | MeshFile | InMemoryMesh


class _FileFacts(NamedTuple):
    """The digest of a file, and the files that it names for its numbers."""

    digest: bytes
    companions: tuple[str, ...]


@functools.lru_cache(maxsize=1024)
def _file_facts(filename: str, mtime_ns: int, size: int) -> _FileFacts:
    """Return the facts of a file; its time stamp and size are part of the cache key."""
    data = Path(filename).read_bytes()
    kind = os.path.splitext(filename)[1].lower().lstrip('.')
    return _FileFacts(hashlib.sha256(data).digest(), companions_of(data, kind, filename))


def _facts_of(filename: str) -> _FileFacts:
    """Return the facts of a file; MeshFileError if it is missing or too large."""
    try:
        status = os.stat(filename)
        if status.st_size > MAX_MESH_BYTES:
            raise MeshFileError(
                f'{filename!r} has {status.st_size} bytes; at most {MAX_MESH_BYTES} are read: '
                'collision geometry needs a simpler mesh'
            )
        return _file_facts(filename, status.st_mtime_ns, status.st_size)
    except OSError as error:
        raise MeshFileError(f'{filename!r} cannot be read: {error.strerror}') from None


def _beside(filename: str, name: str) -> str:
    """Return the path of a file that a mesh file names."""
    return os.path.join(os.path.dirname(filename), name)


def _unchanged(filename: str, digest: bytes) -> bytes:
    """Return the bytes of a file; raises MeshFileError if they have changed."""
    data = Path(filename).read_bytes()
    if hashlib.sha256(data).digest() != digest:
        raise MeshFileError(f'{filename!r} changed while it was read')
    return data


def mesh_source(mesh: MeshGiven) -> MeshKey:
    """Return the key of a mesh: arrays, a file in memory, or a file on disk as it is now."""
    return MeshFile(mesh) if isinstance(mesh, str) else mesh


def name_of(source: MeshKey) -> str:
    """Return the name of a mesh for messages."""
    if isinstance(source, InMemoryMesh):
        return f'the mesh in memory {source.mesh_file.filename_hint()!r}'
    return 'a mesh given as numbers' if isinstance(source, MeshData) else repr(source)


def numbers_of(mesh: MeshData | InMemoryMesh) -> MeshData:
    """Return a mesh in memory as unscaled arrays."""
    return mesh if isinstance(mesh, MeshData) else MeshData(*triangles_of(mesh))


def check_extension(extension: str, name: str) -> None:
    """Raise MeshFileError for an extension of no supported format."""
    if extension.lstrip('.') not in FORMATS:
        raise MeshFileError(
            f'GetConvexHull: MakeConvexHull only applies to {", ".join(FORMATS)} files; '
            f'{name!r} has the extension {extension!r}'
        )


def hull_vertices(mesh: MeshGiven, scale3: Floats) -> Floats:
    """Return the vertices (n, 3) [m] of the convex hull of a mesh, scaled along x, y, z.

    ``mesh`` is that of a shape. Raises MeshFileError for a file that is missing, has no mesh or
    numbers that are not finite, or if the hull has no volume.
    """
    source = mesh_source(mesh)
    return _scaled(hull_of(source).vertices, scale3, source)


def coarse_hull_of(mesh: MeshGiven, scale3: Floats) -> CoarseHull | None:
    """Return the coarse hull of a scaled mesh, or None where its hull has few vertices."""
    source = mesh_source(mesh)
    chosen = _chosen_vertices(source)
    if chosen is None:
        return None
    few, triangles = chosen
    return coarse_hull(hull_vertices(mesh, scale3), few, turned(triangles, scale3))


@functools.lru_cache(maxsize=256)
def _chosen_vertices(source: MeshKey) -> tuple[Indices, Indices] | None:
    """Return the numbers of the vertices of a source's coarse hull and its triangles."""
    return chosen_vertices(hull_of(source).vertices)


def hull_surface(mesh: MeshGiven, scale3: Floats) -> tuple[Floats, Indices]:
    """Return ``hull_vertices`` and the hull's triangles (m, 3), counter-clockwise from outside."""
    source = mesh_source(mesh)
    vertices, triangles = hull_of(source)
    return _scaled(vertices, scale3, source), turned(triangles, scale3)


def surface(mesh: MeshGiven, scale3: Floats) -> tuple[Floats, Indices]:
    """Return vertices (n, 3) [m] and triangles (m, 3) of a mesh itself, scaled along x, y, z."""
    source = mesh_source(mesh)
    vertices, triangles = triangles_of(source)
    return _scaled(vertices, scale3, source), turned(triangles, scale3)


def volume(mesh: MeshGiven, scale3: Floats) -> VolumeMesh | None:
    """Return the tetrahedra of a mesh, scaled along x, y, z; None for a surface mesh."""
    source = mesh_source(mesh)
    if _kind_of(source) not in VOLUME_FORMATS:
        return None  # without reading a file
    assert not isinstance(source, MeshData)
    tetrahedra = _parsed(source).volume
    assert tetrahedra is not None
    elements = tetrahedra.element_array()
    if np.prod(np.sign(scale3)) < 0.0:  # a reflection turns every one inside out
        elements = elements[:, [1, 0, 2, 3]]
    return VolumeMesh.FromArrays(elements, _scaled(tetrahedra.vertex_array(), scale3, source))


def _scaled(vertices: Floats, scale3: Floats, source: MeshKey) -> Floats:
    """Return the vertices of a scaled mesh; raises MeshFileError for one beyond FARTHEST."""
    with np.errstate(over='ignore'):
        points = vertices * scale3
    if (np.abs(points) > FARTHEST).any():
        raise MeshFileError(
            f'{name_of(source)}: scaled by {scale3.tolist()}, it reaches to '
            f'{np.abs(points).max():g} m; no coordinate may be beyond {FARTHEST:.3g} m'
        )
    return points


def turned(triangles: Indices, scale3: Floats) -> Indices:
    """Return the triangles of a scaled mesh, reversed if the scale is a reflection."""
    return triangles[:, ::-1] if np.prod(np.sign(scale3)) < 0.0 else triangles


def _kind_of(source: MeshKey) -> str:
    """Return the format of a file; empty for arrays."""
    if isinstance(source, InMemoryMesh):
        return source.mesh_file.extension().lstrip('.')
    return '' if isinstance(source, MeshData) else source.kind


def _content(source: MeshFile | InMemoryMesh) -> tuple[bytes, str, str, dict[str, bytes]]:
    """Return the bytes of a file, its format, its name for messages, and its companions."""
    if isinstance(source, MeshFile):
        return source.content(), source.kind, source.filename, source.companions()
    file, files = source.mesh_file, source.supporting_files.items()
    companions = {name: f.contents() for name, f in files if isinstance(f, MemoryFile)}
    return file.contents(), _kind_of(source), file.filename_hint(), companions


class Triangles(NamedTuple):
    """Vertices (n, 3) [m], and triangles (m, 3) of them."""

    vertices: Floats
    triangles: Indices


@functools.lru_cache(maxsize=8)
def _parsed(source: MeshFile | InMemoryMesh) -> ParsedMesh:
    """Return the parsed content of a file, read-only."""
    parsed = parse_mesh(*_content(source))
    count = len(parsed.vertices)
    if count == 0 or not np.isfinite(parsed.vertices).all():
        raise MeshFileError(f'{name_of(source)}: {count} vertices, and all must be finite')
    for array in parsed[:3]:
        if array is not None:
            array.flags.writeable = False
    return parsed


def triangles_of(source: MeshKey) -> Triangles:
    """Return vertices and triangles of a source, unscaled and read-only."""
    mesh = source if isinstance(source, MeshData) else _parsed(source)
    return Triangles(mesh.vertices, mesh.triangles)


@functools.lru_cache(maxsize=32)
def _colours_of(source: MeshKey) -> NDArray[np.float32] | None:
    """Return the colours of a source's triangles, read-only, or None."""
    return None if isinstance(source, MeshData) else _parsed(source).colours


def facet_colours(mesh: MeshGiven) -> NDArray[np.float32] | None:
    """Return the colours (m, 3) from 0 to 1 of a mesh's triangles, None if it has none.

    They are those of its faces, or means over its vertices; materials and textures are ignored.
    """
    return _colours_of(mesh_source(mesh))


def part_of(mesh: MeshGiven, name: str) -> MeshData:
    """Return the part of a mesh file that has a name in it, unscaled, with its own vertices.

    Raises MeshFileError as ``hull_vertices``, and for a name that the file does not have.
    """
    source = mesh_source(mesh)
    parts = {} if isinstance(source, MeshData) else _parsed(source).parts
    if name not in parts:
        part_names = ', '.join(map(repr, parts)) or 'none'
        raise MeshFileError(f'{name_of(source)} has no part {name!r}; its parts are {part_names}')
    vertices, triangles = triangles_of(source)
    used, corners = np.unique(triangles[parts[name]], return_inverse=True)
    return MeshData(vertices[used], corners.reshape(-1, 3))


def remarks_on(mesh: MeshGiven) -> tuple[str, ...]:
    """Return remarks on conversions of a mesh file's numbers, applied or not.

    An example is ``'turned from y up to z up'``. Raises MeshFileError as ``hull_vertices``.
    """
    source = mesh_source(mesh)
    return () if isinstance(source, MeshData) else _parsed(source).remarks


@functools.lru_cache(maxsize=256)
def hull_of(source: MeshKey) -> Triangles:
    """Return vertices and triangles of the convex hull of a source, unscaled."""
    return Triangles(*convex_hull(triangles_of(source).vertices, name_of(source)))


@functools.lru_cache(maxsize=32)
def _polygons_of(source: MeshKey) -> list[list[int]]:
    """Return the polygons that bound the convex hull of a source, by its vertices."""
    return united(*hull_of(source))


def hull_polygons(mesh: MeshGiven, scale3: Floats) -> tuple[Floats, list[list[int]]]:
    """Return vertices (n, 3) [m] and polygons, counter-clockwise, of the hull of a scaled mesh."""
    source = mesh_source(mesh)
    mirrored = np.prod(np.sign(scale3)) < 0.0
    polygons = [polygon[:: -1 if mirrored else 1] for polygon in _polygons_of(source)]
    return _scaled(hull_of(source).vertices, scale3, source), polygons
