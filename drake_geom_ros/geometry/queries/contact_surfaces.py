"""Contact surfaces, on which the pressures of two bodies are equal: records over arrays."""

from __future__ import annotations

import enum
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    AREA,
    CENTROID,
    FACE_AREA,
    FIRST_MOMENT,
    FORCE,
    GRAD_M,
    GRAD_N,
    ID_M,
    ID_N,
    LAST,
    NORMAL,
    PRESSURE,
    PRESSURE_MOMENT,
    TORQUE,
    Surfaces,
)
from drake_geom_ros.geometry.errors import ArgumentError, GeometryError
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.meshes.polygon_mesh import PolygonSurfaceMesh
from drake_geom_ros.geometry.meshes.surface_fields import (
    PolygonSurfaceMeshFieldLinear,
    TriangleSurfaceMeshFieldLinear,
)
from drake_geom_ros.geometry.meshes.surface_mesh import TriangleSurfaceMesh
from drake_geom_ros.geometry.queries.result_sequence import NamedResults
from drake_geom_ros.math.array_types import Floats, Indices

if TYPE_CHECKING:  # with its kernels
    from drake_geom_ros.geometry._contact_surfaces.asking import Answer


class HydroelasticContactRepresentation(enum.Enum):
    """Kind of a surface's faces: triangles about each polygon's centroid, or the polygons."""

    kTriangle = 0
    kPolygon = 1


class _SurfaceTriangles(NamedTuple):
    """The mesh of triangles, the pressure at its vertices, and the polygon of each triangle."""

    mesh: TriangleSurfaceMesh
    pressures: Floats
    polygons: Indices


class ContactSurface:
    """Contact surface of two geometries M and N, on which the pressures of both are equal.

    ``id_M() < id_N()``; normals point out of N into M. All is in World. If one of them is rigid
    the surface is part of its own, and it has no pressure gradient.
    """

    def __init__(
        self,
        ids: tuple[int, int],
        is_compliant: tuple[bool, bool],
        representation: HydroelasticContactRepresentation,
        surfaces: Surfaces,
        faces: slice,
        sums: Floats,
    ) -> None:
        self._ids, self._is_compliant, self._representation = ids, is_compliant, representation
        first = int(surfaces.ends[faces.start - 1]) if faces.start else 0
        self._ends = surfaces.ends[faces] - first
        self._points = surfaces.points[first : first + int(self._ends[-1])]
        self._pressures = surfaces.pressures[first : first + int(self._ends[-1])]
        self._faces, self._sums = surfaces.faces[faces], sums

    def id_M(self) -> GeometryId:
        """Return the id of M."""
        return GeometryId(self._ids[0])

    def id_N(self) -> GeometryId:
        """Return the id of N."""
        return GeometryId(self._ids[1])

    def representation(self) -> HydroelasticContactRepresentation:
        """Return the kind of the faces."""
        return self._representation

    def is_triangle(self) -> bool:
        """Return whether the faces are triangles."""
        return self._representation is HydroelasticContactRepresentation.kTriangle

    def num_faces(self) -> int:
        """Return the number of faces."""
        return int(self._ends[-1]) if self.is_triangle() else len(self._ends)

    def num_vertices(self) -> int:
        """Return the number of vertices; each polygon has its own."""
        return len(self._points) + (len(self._ends) if self.is_triangle() else 0)

    def area(self, face_index: int) -> float:
        """Return the area [m^2] of a face."""
        k = self._checked(face_index)
        return self._triangles.mesh.area(k) if self.is_triangle() else float(self._areas[k])

    def total_area(self) -> float:
        """Return the area [m^2] of all faces."""
        return float(self._sums[AREA])

    def face_normal(self, face_index: int) -> Floats:
        """Return the unit normal (3,) of a face, out of N into M."""
        k = self._polygon_of(face_index)
        return self._faces[k, NORMAL : NORMAL + 3].copy()

    def centroid(self, face_index: int | None = None) -> Floats:
        """Return the centroid (3,) [m] of a face, or of the whole surface."""
        if face_index is None:
            return _over(self._sums, FIRST_MOMENT, AREA)
        k = self._checked(face_index)
        if self.is_triangle():
            return self._triangles.mesh.element_centroid(k)
        return self._faces[k, CENTROID : CENTROID + 3].copy()

    def HasGradE_M(self) -> bool:
        """Return whether M is compliant, so that its pressure has a gradient."""
        return self._is_compliant[0]

    def HasGradE_N(self) -> bool:
        """Return whether N is compliant, so that its pressure has a gradient."""
        return self._is_compliant[1]

    def EvaluateGradE_M_W(self, index: int) -> Floats:
        """Return the gradient (3,) [Pa/m] of M's pressure on a face; raises where M is rigid."""
        return self._gradient(index, 0)

    def EvaluateGradE_N_W(self, index: int) -> Floats:
        """Return the gradient (3,) [Pa/m] of N's pressure on a face; raises where N is rigid."""
        return self._gradient(index, 1)

    def tri_mesh_W(self) -> TriangleSurfaceMesh:
        """Return the mesh of triangles; raises RuntimeError where faces are polygons."""
        self._check_is(HydroelasticContactRepresentation.kTriangle)
        return self._triangles.mesh

    def tri_e_MN(self) -> TriangleSurfaceMeshFieldLinear:
        """Return the pressure [Pa] on triangles; raises RuntimeError where faces are polygons."""
        self._check_is(HydroelasticContactRepresentation.kTriangle)
        mesh, pressures, polygons = self._triangles
        return TriangleSurfaceMeshFieldLinear(mesh, pressures, self._slopes[polygons])

    def poly_mesh_W(self) -> PolygonSurfaceMesh:
        """Return the mesh of polygons; raises RuntimeError where faces are triangles."""
        self._check_is(HydroelasticContactRepresentation.kPolygon)
        return self._polygons

    def poly_e_MN(self) -> PolygonSurfaceMeshFieldLinear:
        """Return the pressure [Pa] on polygons; raises RuntimeError where faces are triangles."""
        self._check_is(HydroelasticContactRepresentation.kPolygon)
        return PolygonSurfaceMeshFieldLinear(self._polygons, self._pressures, self._slopes)

    def Equal(self, surface: ContactSurface) -> bool:
        """Return whether a surface has the same ids, faces and pressures, to the bit."""
        return (
            self._ids == surface._ids
            and self._representation is surface._representation
            and np.array_equal(self._ends, surface._ends)
            and np.array_equal(self._points, surface._points)
            and np.array_equal(self._pressures, surface._pressures)
            and np.array_equal(self._faces, surface._faces)
        )

    # Additions to pydrake.

    def force_on_M_W(self) -> Floats:
        """Return the force (3,) [N] that the pressure exerts on M; on N it is the opposite."""
        return self._sums[FORCE : FORCE + 3].copy()

    def torque_on_M_Wo_W(self) -> Floats:
        """Return the torque (3,) [N m] about World's origin that the pressure exerts on M."""
        return self._sums[TORQUE : TORQUE + 3].copy()

    def centre_of_pressure(self) -> Floats:
        """Return the mean (3,) [m] of the surface's points, weighted by pressure.

        The centroid, where the pressure is 0 all over.
        """
        if self._sums[PRESSURE] == 0.0:
            return self.centroid()
        return _over(self._sums, PRESSURE_MOMENT, PRESSURE)

    def polygon_arrays(self) -> tuple[Floats, Floats, Indices]:
        """Return corners (n, 3) [m], pressures (n,) [Pa], and where each polygon ends (f,)."""
        return self._points, self._pressures, self._ends

    def __repr__(self) -> str:
        return (
            f'<ContactSurface of {self._ids[0]} and {self._ids[1]}: {self.num_faces()} faces, '
            f'{self.total_area():g} m^2>'
        )

    @property
    def _areas(self) -> Floats:
        """The areas (f,) of the polygons."""
        return self._faces[:, FACE_AREA]

    @property
    def _slopes(self) -> Floats:
        """The gradient (f, 3) of the pressure on each polygon, that of a compliant body."""
        column = GRAD_M if self._is_compliant[0] else GRAD_N
        return self._faces[:, column : column + 3]

    @cached_property
    def _polygons(self) -> PolygonSurfaceMesh:
        """The mesh of polygons."""
        starts = [0, *self._ends[:-1].tolist()]
        rows = zip(starts, self._ends.tolist(), strict=True)
        return PolygonSurfaceMesh.FromPolygons([range(a, b) for a, b in rows], self._points)

    @cached_property
    def _triangles(self) -> _SurfaceTriangles:
        """The triangles about the centroids: each side of a polygon, and then the centroid."""
        count, corners = len(self._ends), int(self._ends[-1])
        sizes = np.diff(self._ends, prepend=0)
        polygons = np.repeat(np.arange(count), sizes)
        before = np.arange(corners) - 1
        starts = self._ends - sizes
        before[starts] = self._ends - 1
        rows = np.column_stack((before, np.arange(corners), corners + polygons))
        centroids = self._faces[:, CENTROID : CENTROID + 3]
        rises = (self._slopes * (centroids - self._points[starts])).sum(axis=1)
        mesh = TriangleSurfaceMesh.FromArrays(rows, np.vstack((self._points, centroids)))
        pressures = np.concatenate((self._pressures, self._pressures[starts] + rises))
        return _SurfaceTriangles(mesh, pressures, polygons)

    def _checked(self, face_index: int) -> int:
        """Return a valid face index; raises ArgumentError for others."""
        if not 0 <= face_index < self.num_faces():
            raise ArgumentError(f'face {face_index} was asked for; there are {self.num_faces()}')
        return face_index

    def _polygon_of(self, face_index: int) -> int:
        """Return the polygon that a face is, or belongs to."""
        k = self._checked(face_index)
        return int(np.searchsorted(self._ends, k, 'right')) if self.is_triangle() else k

    def _gradient(self, index: int, of: int) -> Floats:
        """Return the gradient of M's (0) or N's (1) pressure on a face."""
        if not self._is_compliant[of]:
            raise GeometryError(f'{self!r}: {"MN"[of]} is rigid, and has no pressure gradient')
        column = (GRAD_M, GRAD_N)[of]
        return self._faces[self._polygon_of(index), column : column + 3].copy()

    def _check_is(self, representation: HydroelasticContactRepresentation) -> None:
        """Raise GeometryError if the surface has the other representation."""
        if self._representation is not representation:
            raise GeometryError(
                f'{self!r} was made with {self._representation.name}; its mesh and field are '
                f'those of {"triangles" if self.is_triangle() else "polygons"}'
            )


# Columns of tables with a row for each surface, and the arrays that they are.
SURFACE_COLUMNS = {
    'id_M': 'id_M',
    'id_N': 'id_N',
    'area': 'areas',
    'centroid': 'centroids',
    'centre_of_pressure': 'centres_of_pressure',
    'force_on_M_W': 'forces_on_M_W',
    'torque_on_M_Wo_W': 'torques_on_M_Wo_W',
    'max_pressure': 'max_pressures',
}


class ContactSurfaceResults(NamedResults, Sequence[ContactSurface]):
    """Contact surfaces, sorted by (id_M, id_N), as arrays; indexing makes records.

    ``id_M``, ``id_N`` (k,) are values of ids; ``areas`` (k,) [m^2], ``centroids`` (k, 3) [m],
    ``forces_on_M_W`` (k, 3) [N], ``torques_on_M_Wo_W`` (k, 3) [N m], ``centres_of_pressure``
    (k, 3) [m]; ``face_offsets`` (k + 1,) of each surface's polygons. All are in World and
    read-only.
    """

    _listed = tuple(SURFACE_COLUMNS)

    def __init__(self, answer: Answer, representation: HydroelasticContactRepresentation) -> None:
        self._answer, self._representation = answer, representation

    @cached_property
    def _surfaces(self) -> Surfaces:
        """The arrays, made on first use: many callers need one surface or the count alone."""
        return self._answer.surfaces()

    @property
    def _sums(self) -> Floats:
        return self._surfaces.sums

    @property
    def areas(self) -> Floats:
        """The areas (k,) [m^2]."""
        return self._sums[:, AREA]

    @property
    def forces_on_M_W(self) -> Floats:
        """The forces (k, 3) [N] that the pressures exert on M."""
        return self._sums[:, FORCE : FORCE + 3]

    @property
    def torques_on_M_Wo_W(self) -> Floats:
        """The torques (k, 3) [N m] about World's origin that the pressures exert on M."""
        return self._sums[:, TORQUE : TORQUE + 3]

    @property
    def id_M(self) -> Indices:
        """The values (k,) of the lower ids."""
        return self._surfaces.found[:, ID_M]

    @property
    def id_N(self) -> Indices:
        """The values (k,) of the higher ids."""
        return self._surfaces.found[:, ID_N]

    @cached_property
    def face_offsets(self) -> Indices:
        """First polygon of each surface, and the end of the last one (k + 1,)."""
        offsets = np.concatenate(([0], self._surfaces.found[:, LAST]))
        offsets.setflags(write=False)
        return offsets

    @cached_property
    def centroids(self) -> Floats:
        """The centroids (k, 3) [m]."""
        return _means(self._sums, FIRST_MOMENT, self.areas)

    @cached_property
    def centres_of_pressure(self) -> Floats:
        """The centres of pressure (k, 3) [m]: the centroids where there is no pressure."""
        pressures = self._sums[:, PRESSURE]
        pressed = (pressures > 0.0)[:, None]
        means = _means(self._sums, PRESSURE_MOMENT, np.where(pressed[:, 0], pressures, 1.0))
        centres = np.where(pressed, means, self.centroids)
        centres.flags.writeable = False
        return centres

    @cached_property
    def max_pressures(self) -> Floats:
        """The largest pressure (k,) [Pa] of each surface."""
        if not len(self):
            return np.zeros(0)
        ends = self._surfaces.ends
        starts = np.concatenate(([0], ends[self.face_offsets[1:-1] - 1]))
        largest: Floats = np.maximum.reduceat(self._surfaces.pressures, starts)
        largest.flags.writeable = False
        return largest

    def polygon_arrays(self) -> tuple[Floats, Floats, Indices]:
        """Return corners (n, 3) [m], pressures (n,) [Pa], and where each polygon ends (f,).

        Those of all surfaces, one after another: see ``face_offsets``.
        """
        return self._surfaces.points, self._surfaces.pressures, self._surfaces.ends

    def _column(self, name: str) -> NDArray[Any]:
        return super()._column(SURFACE_COLUMNS[name])

    def __len__(self) -> int:
        return self._answer.counts.surfaces

    @overload
    def __getitem__(self, index: int) -> ContactSurface: ...
    @overload
    def __getitem__(self, index: slice) -> list[ContactSurface]: ...
    def __getitem__(self, index: int | slice) -> ContactSurface | list[ContactSurface]:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        if not -len(self) <= index < len(self):
            raise IndexError(f'surface {index} of {len(self)} was asked for')
        k = index % len(self)
        id_M, id_N, m, n, last = self._surfaces.found[k].tolist()
        first = int(self._surfaces.found[k - 1, LAST]) if k else 0
        faces = slice(first, last)
        return ContactSurface(
            (id_M, id_N),
            (bool(m), bool(n)),
            self._representation,
            self._surfaces,
            faces,
            self._sums[k],
        )

    def __iter__(self) -> Iterator[ContactSurface]:
        return (self[k] for k in range(len(self)))

    def __repr__(self) -> str:
        return f'<ContactSurfaceResults of {len(self)} surfaces>'


def _means(sums: Floats, moment: int, weights: Floats) -> Floats:
    """Return the moments (k, 3) divided by their weights (k,), read-only."""
    means: Floats = sums[:, moment : moment + 3] / weights[:, None]
    means.flags.writeable = False
    return means


def _over(sums: Floats, moment: int, weight: int) -> Floats:
    """Return a moment (3,) divided by its weight."""
    mean: Floats = sums[moment : moment + 3] / sums[weight]
    return mean
