"""Sources of meshes, with pydrake's names: a file on disk, or files in memory."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentTypeError, GeometryError


@dataclass(frozen=True, kw_only=True, repr=False)
class InMemoryMesh:
    """A mesh file in memory, and the files that it refers to, by their names in it.

    ``supporting_files`` are for drawing; queries read ``mesh_file`` alone, and the buffers of glTF
    that are in memory too.
    """

    mesh_file: MemoryFile = field(default_factory=MemoryFile)
    supporting_files: Mapping[str, MemoryFile | Path] = field(default_factory=dict)

    def __post_init__(self) -> None:
        checked_type(self.mesh_file, MemoryFile, 'InMemoryMesh: mesh_file')
        object.__setattr__(self, 'supporting_files', dict(self.supporting_files))

    def __hash__(self) -> int:
        return hash(self.mesh_file)

    def __repr__(self) -> str:
        others = f', supporting_files={self.supporting_files!r}' if self.supporting_files else ''
        return f'InMemoryMesh(mesh_file={self.mesh_file!r}{others})'


class MeshSource:
    """The path of a mesh file, or an ``InMemoryMesh``, which is empty without arguments."""

    __slots__ = ('_source',)

    def __init__(
        self,
        path: str | os.PathLike[str] | InMemoryMesh | MeshSource | None = None,
        *,
        mesh: InMemoryMesh | None = None,
        other: MeshSource | None = None,
    ) -> None:
        sources = [value for value in (path, mesh, other) if value is not None]
        if len(sources) > 1:
            raise ArgumentTypeError('MeshSource: give one of path, mesh, other')
        source = sources[0] if sources else InMemoryMesh()
        if isinstance(source, MeshSource):
            source = source._source
        elif isinstance(source, (str, os.PathLike)):
            source = Path(source)
        elif not isinstance(source, InMemoryMesh):
            raise ArgumentTypeError(f'MeshSource: {source!r} is neither a path nor a mesh')
        self._source: Path | InMemoryMesh = source

    def is_path(self) -> bool:
        """Return whether the mesh is a file on disk."""
        return isinstance(self._source, Path)

    def is_in_memory(self) -> bool:
        """Return whether the mesh is in memory."""
        return isinstance(self._source, InMemoryMesh)

    def path(self) -> Path:
        """Return the path of the file; raises RuntimeError without one."""
        if isinstance(self._source, Path):
            return self._source
        raise GeometryError(f'MeshSource.path: {self!r} is in memory; see in_memory()')

    def in_memory(self) -> InMemoryMesh:
        """Return the mesh in memory; raises RuntimeError without one."""
        if isinstance(self._source, InMemoryMesh):
            return self._source
        raise GeometryError(f'MeshSource.in_memory: {self!r} is a file; see path()')

    def description(self) -> str:
        """Return the path, or the name of the file in memory, for messages."""
        if isinstance(self._source, Path):
            return str(self._source)
        return self._source.mesh_file.filename_hint()

    def extension(self) -> str:
        """Return the extension of the file's name in lower case, such as ``.obj``."""
        if isinstance(self._source, Path):
            return self._source.suffix.lower()
        return self._source.mesh_file.extension()

    def __eq__(self, other: object) -> bool:
        return self._source == other._source if isinstance(other, MeshSource) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._source)

    def __repr__(self) -> str:
        if isinstance(self._source, Path):
            return f'MeshSource(path={str(self._source)!r})'
        return f'MeshSource(mesh={self._source!r})'
