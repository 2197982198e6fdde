"""Shapes that a mesh describes: ``Convex`` and ``Mesh``."""

from __future__ import annotations

import functools
import os
import warnings
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import hull_parameters
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SOLID
from drake_geom_ros.geometry._proximity.tolerances import SMALLEST_SCALE
from drake_geom_ros.geometry.errors import (
    ArgumentError,
    ArgumentTypeError,
    GeometryError,
    MeshFileError,
)
from drake_geom_ros.geometry.meshes._obj_file import obj_text
from drake_geom_ros.geometry.meshes.in_memory import InMemoryMesh, MeshSource
from drake_geom_ros.geometry.meshes.polygon_mesh import PolygonSurfaceMesh
from drake_geom_ros.geometry.meshes.source import (
    MeshData,
    MeshGiven,
    MeshKey,
    check_extension,
    coarse_hull_of,
    hull_polygons,
    hull_surface,
    mesh_source,
    name_of,
    numbers_of,
    surface,
    triangles_of,
    volume,
)
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.geometry.shapes.primitives import PackedShape, QueriedShape, Shape
from drake_geom_ros.math.array_types import Floats

_M = TypeVar('_M', bound='_FromMesh')


class _FromMesh(Shape):
    """A shape that a mesh describes: a file, a file in memory, or numbers (``FromMeshData``)."""

    __slots__ = ()
    _NAMES = ('filename', 'scale3')

    def __init__(
        self,
        filename: str | os.PathLike[str] | InMemoryMesh | MeshSource | None = None,
        scale: ArrayLike = 1.0,
        *,
        scale3: ArrayLike | None = None,
        mesh_data: InMemoryMesh | None = None,
        source: MeshSource | None = None,
        absolute_filename: str | os.PathLike[str] | None = None,
    ) -> None:
        kind = type(self).__name__
        values = (filename, mesh_data, source, absolute_filename)
        present = [value for value in values if value is not None]
        if len(present) != 1:
            raise ArgumentTypeError(f'{kind}: give one of filename, mesh_data, source')
        mesh = _mesh_of(kind, present[0])
        self._measures = mesh, _scales(kind, scale if scale3 is None else scale3)

    @classmethod
    def FromMeshData(cls: type[_M], data: MeshData, scale: ArrayLike = 1.0) -> _M:
        """Return the shape of a mesh in arrays."""
        shape = cls.__new__(cls)
        shape._measures = data, _scales(cls.__name__, scale)
        return shape

    def __repr__(self) -> str:
        mesh, scales = self._measures
        if isinstance(mesh, MeshData):
            return f'{type(self).__name__}.FromMeshData({mesh!r}, {list(scales)})'
        name = 'filename' if isinstance(mesh, str) else 'mesh_data'
        return f'{type(self).__name__}({name}={mesh!r}, scale3={list(scales)})'

    @property
    def _mesh(self) -> MeshGiven:
        """The path or the mesh that the shape was made from."""
        mesh: MeshGiven = self._measures[0]
        return mesh

    @property
    def _scales(self) -> tuple[float, ...]:
        """The scale [-] along x, y and z."""
        scales: tuple[float, ...] = self._measures[1]
        return scales

    def source(self) -> MeshSource:
        """Return the source of the mesh; arrays are an .obj file in memory."""
        mesh = self._mesh
        if isinstance(mesh, MeshData):
            text = obj_text(mesh.vertices, mesh.triangles)
            mesh = InMemoryMesh(mesh_file=MemoryFile(text, '.obj', ''))
        return MeshSource(mesh)

    def mesh_data(self) -> MeshData | None:
        """Return the unscaled arrays of a mesh in memory; None for a file."""
        mesh = self._mesh
        return None if isinstance(mesh, str) else numbers_of(mesh)

    def filename(self) -> str:
        """Return the absolute path of the file; raises RuntimeError without one."""
        mesh = self._mesh
        if not isinstance(mesh, str):
            raise GeometryError(f'{type(self).__name__}: not made of a file; see mesh_data()')
        return mesh

    def extension(self) -> str:
        """Return the extension of the file's name in lower case, such as ``.obj``."""
        return self.source().extension()

    def scale(self) -> float:
        """Return the scale [-]; raises RuntimeError when it differs between the axes."""
        if len(set(self._scales)) > 1:
            raise GeometryError(
                f'{type(self).__name__}: scale() of {list(self._scales)}, which is not '
                'uniform; see scale3()'
            )
        return float(self._scales[0])

    def scale3(self) -> Floats:
        """Return the scale (3,) [-] along x, y and z."""
        return np.array(self._scales)

    def hull_surface(self) -> tuple[Floats, NDArray[np.int64]]:
        """Return vertices (n, 3) [m] and triangles (m, 3) of the convex hull, as queries use it.

        Triangles are indices of vertices, counter-clockwise from outside. Raises MeshFileError
        for a file that is not a mesh with a volume.
        """
        return hull_surface(self._mesh, self.scale3())

    def GetConvexHull(self) -> PolygonSurfaceMesh:
        """Return the scaled convex hull as polygons: triangles in one plane are merged.

        Raises MeshFileError for a file that is not a mesh with a volume.
        """
        check_extension(self.extension(), self.source().description())
        vertices, polygons = hull_polygons(self._mesh, self.scale3())
        return PolygonSurfaceMesh.FromPolygons(polygons, vertices)

    def _for_queries(self, is_solid: bool = False, margin: float = 0.0) -> QueriedShape:
        coarse = coarse_hull_of(self._mesh, self.scale3())
        return QueriedShape(PackedShape(CONVEX, hull_parameters(*self.hull_surface(), coarse)))


class Convex(_FromMesh):
    """The convex hull of a mesh, scaled by ``scale``: one number, or one for each axis.

    The mesh is a file, or one in memory (``mesh_data``), or either as a ``source``. ``points``
    (3, n) [m] become a file in memory, with a ``label`` of one line for messages.
    """

    __slots__ = ()
    _TYPE = CONVEX

    def __init__(
        self,
        filename: str | os.PathLike[str] | InMemoryMesh | MeshSource | None = None,
        scale: ArrayLike = 1.0,
        *,
        scale3: ArrayLike | None = None,
        mesh_data: InMemoryMesh | None = None,
        source: MeshSource | None = None,
        absolute_filename: str | os.PathLike[str] | None = None,
        points: ArrayLike | None = None,
        label: str | None = None,
    ) -> None:
        if points is not None:
            if mesh_data is not None:
                raise ArgumentTypeError('Convex: give one of points, mesh_data')
            mesh_data = _of_points(points, label)
        super().__init__(
            filename,
            scale,
            scale3=scale3,
            mesh_data=mesh_data,
            source=source,
            absolute_filename=absolute_filename,
        )


class Mesh(_FromMesh):
    """The triangle mesh in a file, scaled by ``scale``: one number, or one for each axis.

    The mesh is a file, or one in memory (``mesh_data``), or either as a ``source``. For a .vtk
    file it is the boundary of the tetrahedra, and contact surfaces use the tetrahedra.

    In pairs it counts as its convex hull, or, with the property ('mesh', 'solid'), as the body
    that its surface encloses. Points always measure to that body, if the surface encloses one. If
    not, they measure to the hull, and registration warns of this.
    """

    __slots__ = ()
    _TYPE = SOLID

    def surface(self) -> tuple[Floats, NDArray[np.int64]]:
        """Return vertices (n, 3) [m] and triangles (m, 3) of the mesh itself, scaled.

        Triangles are indices of vertices, with the orientation of the file. Raises MeshFileError
        for a file that is not a mesh.
        """
        return surface(self._mesh, self.scale3())

    def volume_mesh(self) -> VolumeMesh | None:
        """Return the scaled tetrahedra of a .vtk file; None for a surface mesh.

        Raises MeshFileError for a file that is not a mesh.
        """
        return volume(self._mesh, self.scale3())

    def _for_queries(self, is_solid: bool = False, margin: float = 0.0) -> QueriedShape:
        if is_solid:
            return QueriedShape(self._as_solid())
        hull = super()._for_queries().in_pairs
        return QueriedShape(hull, functools.partial(self._to_points, hull))

    def _as_solid(self) -> PackedShape:
        return _packed_solid(mesh_source(self._mesh), self._mesh, self._scales)

    def weldings(self) -> tuple[str, ...]:
        """Return descriptions of the welds that close the surface, mostly none.

        Raises MeshFileError for a mesh that bounds no solid, or is no mesh.
        """
        from drake_geom_ros.geometry.meshes._solids import weldings_of

        return weldings_of(self._mesh, self._scales)

    def _to_points(self, hull: PackedShape) -> PackedShape:
        """Return the solid that the surface bounds; otherwise warn and return the hull."""
        try:
            return self._as_solid()
        except MeshFileError as problem:
            _warn_of_points(problem)
            return hull


@functools.lru_cache(maxsize=32)
def _packed_solid(source: MeshKey, mesh: MeshGiven, scales: tuple[float, ...]) -> PackedShape:
    """Return a mesh as a solid, packed once for all shapes of one source; raises MeshFileError."""
    # Imported here: only solids, and queries about points near meshes, need it.
    from drake_geom_ros.geometry.meshes._solids import solid_of

    return PackedShape(*solid_of(mesh, scales))


def mesh_of(shape: Convex | Mesh) -> MeshGiven:
    """Return the path or the mesh that a shape was made from."""
    return shape._mesh


def warn_if_open(shape: Mesh) -> None:
    """Warn if a mesh is not closed, since points then measure to its hull."""
    from drake_geom_ros.geometry.meshes._welding import closed_surface

    source = mesh_source(shape._mesh)
    try:
        closed_surface(*triangles_of(source), name_of(source))
    except MeshFileError as problem:
        _warn_of_points(problem)


def _warn_of_points(problem: MeshFileError) -> None:
    warnings.warn(
        f'distances from points to this mesh are those to its convex hull, since {problem}',
        stacklevel=3,
    )


def _mesh_of(kind: str, source: object) -> MeshGiven:
    """Return the absolute path or the mesh in memory of a shape's source."""
    if isinstance(source, MeshSource):
        source = source.path() if source.is_path() else source.in_memory()
    if isinstance(source, InMemoryMesh):
        return source
    if not isinstance(source, (str, os.PathLike)) or not source:
        raise ArgumentTypeError(f'{kind}: filename = {source!r} is not the path of a file')
    return os.path.abspath(source)


def _of_points(points: ArrayLike, label: str | None) -> InMemoryMesh:
    """Return points (3, n) as an .obj file in memory, named by a label."""
    if not isinstance(label, str) or '\n' in label:
        raise ArgumentTypeError(f'Convex: label = {label!r} must be text of one line')
    p_GVs = np.asarray(points, dtype=np.float64)
    if p_GVs.ndim != 2 or len(p_GVs) != 3 or not np.isfinite(p_GVs).all():
        raise ArgumentError(f'Convex: points {p_GVs.shape} must be finite, (3, n)')
    return InMemoryMesh(mesh_file=MemoryFile(obj_text(p_GVs.T), '.obj', label))


def _scales(kind: str, scale: ArrayLike) -> tuple[float, ...]:
    """Return the scale along x, y and z, or raise an error that names it."""
    factors = np.broadcast_to(np.asarray(scale, float), 3)
    if not (np.abs(factors) >= SMALLEST_SCALE).all() or not np.isfinite(factors).all():
        raise ArgumentError(
            f'{kind}: |scale| must be finite and >= {SMALLEST_SCALE:g} on every axis, '
            f'given {factors.tolist()}'
        )
    return tuple(factors.tolist())
