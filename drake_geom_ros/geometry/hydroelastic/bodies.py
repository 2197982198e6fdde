"""Hydroelastic bodies of shapes: tetrahedra with pressures, rigid surfaces, half spaces."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.geometry.errors import ArgumentError, GeometryError
from drake_geom_ros.geometry.hydroelastic._cells import CutBody
from drake_geom_ros.geometry.hydroelastic._counts import check_elements_of_mesh, check_hint
from drake_geom_ros.geometry.hydroelastic._meshing import (
    box_body,
    capsule_body,
    cylinder_body,
    ellipsoid_body,
    pyramids,
)
from drake_geom_ros.geometry.meshes._outward import turned_outward
from drake_geom_ros.geometry.meshes._surface_distances import distances_to_surface
from drake_geom_ros.geometry.meshes.surface_mesh import TriangleSurfaceMesh
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.geometry.meshes.volume_surface import (
    ConvertVolumeToSurfaceMesh,
    RefineVolumeMesh,
    check_elements,
    count_pieces,
    on_boundary,
)
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh
from drake_geom_ros.geometry.shapes.primitives import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.tolerances import LEAST_STIFF, MOST_STIFF
from drake_geom_ros.math.array_types import Floats


class HydroelasticType(enum.Enum):
    """Compliance type of a geometry in hydroelastic contact: undefined, rigid or compliant."""

    kUndefined = 0
    kRigid = 1
    kCompliant = 2


class HydroelasticMaterial(NamedTuple):
    """Hydroelastic properties of a geometry.

    ``resolution_hint`` [m], ``hydroelastic_modulus`` [Pa] and ``slab_thickness`` [m] are None
    without a property; an error is raised if the shape needs it.
    """

    compliance: HydroelasticType
    resolution_hint: float | None
    hydroelastic_modulus: float | None
    slab_thickness: float | None

    @property
    def is_compliant(self) -> bool:
        """True for a compliant material, False for a rigid one."""
        return self.compliance is HydroelasticType.kCompliant


@dataclass(frozen=True, eq=False)
class CompliantBody:
    """Tetrahedra in the geometry's frame, and the pressure (n,) [Pa] at their vertices."""

    mesh: VolumeMesh
    pressures: Floats


@dataclass(frozen=True, eq=False)
class RigidBody:
    """The surface in the geometry's frame; its closed pieces are oriented outward."""

    mesh: TriangleSurfaceMesh


@dataclass(frozen=True, eq=False)
class HalfSpaceBody:
    """A half space: its pressure grows by ``pressure_slope`` [Pa/m] with the depth; 0: rigid."""

    pressure_slope: float


HydroelasticBody = CompliantBody | RigidBody | HalfSpaceBody


def body_of(shape: Shape, material: HydroelasticMaterial, what: str) -> HydroelasticBody:
    """Return the hydroelastic body of a shape with a material.

    Raises GeometryError, which begins with ``what``, if the material lacks a property that the
    shape needs, or the shape has no such body: a point, a compliant mesh with the property
    ('mesh', 'solid'), a rigid mesh with neighbours of opposite orientation, a hint too fine.
    """
    try:
        if material.compliance is HydroelasticType.kRigid:
            return _rigid(shape, material)
        return _compliant(shape, material)
    except (GeometryError, ArgumentError) as problem:
        raise GeometryError(f'{what} has hydroelastic properties, and {problem}') from None


def _rigid(shape: Shape, material: HydroelasticMaterial) -> RigidBody | HalfSpaceBody:
    """Return a rigid body."""
    if isinstance(shape, HalfSpace):
        return HalfSpaceBody(0.0)
    if isinstance(shape, Mesh):
        check_elements_of_mesh(shape, len(shape.surface()[1]), 'triangles')
        vertices, triangles = turned_outward(*shape.surface(), 'its mesh')
        return RigidBody(TriangleSurfaceMesh.FromArrays(triangles, vertices))
    if isinstance(shape, Convex):
        vertices, triangles = _hull_of(shape)
        return RigidBody(TriangleSurfaceMesh.FromArrays(triangles, vertices))
    return RigidBody(ConvertVolumeToSurfaceMesh(_cut(shape, material).mesh))


def _compliant(shape: Shape, material: HydroelasticMaterial) -> CompliantBody | HalfSpaceBody:
    """Return a compliant body."""
    modulus = _moderate(material.hydroelastic_modulus, 'hydroelastic_modulus', shape)
    if isinstance(shape, HalfSpace):
        thickness = _moderate(material.slab_thickness, 'slab_thickness', shape)
        return HalfSpaceBody(modulus / thickness)
    cut = _cut(shape, material)
    return CompliantBody(cut.mesh, modulus * cut.extents)


def _cut(shape: Shape, material: HydroelasticMaterial) -> CutBody:
    """Return the tetrahedra of a shape."""
    if isinstance(shape, Mesh) and (mesh := shape.volume_mesh()) is not None:
        check_elements_of_mesh(shape, mesh.num_elements(), 'tetrahedra')
        return _by_distance(mesh, shape)
    if isinstance(shape, (Mesh, Convex)):
        return _hull_body(*_hull_of(shape))
    if isinstance(shape, Box):
        return box_body(0.5 * shape.size())
    if not isinstance(shape, (Sphere, Ellipsoid, Cylinder, Capsule)):
        raise GeometryError(f'a {type(shape).__name__} has no hydroelastic body')
    hint = _needed(material.resolution_hint, 'resolution_hint', shape)
    if isinstance(shape, Sphere) and shape.radius() == 0.0:
        raise GeometryError('a Sphere of radius 0 has no volume')
    check_hint(shape, hint)
    if isinstance(shape, Sphere):
        return ellipsoid_body(np.full(3, shape.radius()), hint)
    if isinstance(shape, Ellipsoid):
        return ellipsoid_body(np.array([shape.a(), shape.b(), shape.c()]), hint)
    if isinstance(shape, Cylinder):
        return cylinder_body(shape.radius(), 0.5 * shape.length(), hint)
    return capsule_body(shape.radius(), 0.5 * shape.length(), hint)


def _by_distance(mesh: VolumeMesh, shape: Mesh) -> CutBody:
    """Return tetrahedra with extents that grow with the distance to their boundary.

    The extent is 1 at the largest distance, as in Drake's MakeVolumeMeshPressureField. Unlike
    there, no overlap may remain unnoticed. A tetrahedron with all corners on the boundary would
    have no pressure and so no contact surface: it is cut first. Meshes of several pieces are
    refused, because one piece may be inside another body while others are not.
    """
    check_elements(mesh, 'its tetrahedra as scaled')
    if on_boundary(mesh)[mesh.element_array()].all(axis=1).any():
        mesh = RefineVolumeMesh(mesh)
        check_elements_of_mesh(shape, mesh.num_elements(), 'tetrahedra as refined')
    points, boundary = mesh.vertex_array(), ConvertVolumeToSurfaceMesh(mesh)
    inner = ~on_boundary(mesh)
    if (pieces := count_pieces(mesh)) > 1:
        raise GeometryError(
            f'its tetrahedra are in {pieces} pieces, which share no face: make each a Mesh'
        )
    distances = np.zeros(len(points))
    distances[inner] = distances_to_surface(
        points[inner], boundary.vertex_array(), boundary.triangle_array()
    )
    return CutBody(mesh, distances / distances.max())


def _hull_of(shape: Mesh | Convex) -> tuple[Floats, NDArray[np.int64]]:
    """Return vertices and triangles of a hull, which has few enough."""
    vertices, triangles = shape.hull_surface()
    check_elements_of_mesh(shape, len(triangles), 'triangles of its hull')
    return vertices, triangles


def _hull_body(vertices: Floats, triangles: NDArray[np.int64]) -> CutBody:
    """Return the pyramids of a hull over its centre of volume."""
    origin = vertices.mean(axis=0)
    a, b, c = (vertices[triangles[:, i]] - origin for i in range(3))
    volumes = (np.cross(a, b) * c).sum(axis=1)
    centre = origin + volumes @ (a + b + c) / (4.0 * volumes.sum())
    return pyramids(vertices, triangles, centre)


def _moderate(value: float | None, name: str, shape: Shape) -> float:
    """Return a property of pressures, in a range where products of a few stay within float64."""
    number = _needed(value, name, shape)
    if not LEAST_STIFF <= number <= MOST_STIFF:
        raise GeometryError(
            f"the property 'hydroelastic/{name}' is {number}; it must be {LEAST_STIFF:g} to "
            f'{MOST_STIFF:g}'
        )
    return number


def _needed(value: float | None, name: str, shape: Shape) -> float:
    """Return a property that the shape needs, which must be positive and finite."""
    if value is None:
        raise GeometryError(f"a {type(shape).__name__} needs the property 'hydroelastic/{name}'")
    number = as_number(value)
    if number is None:
        raise GeometryError(f"the property 'hydroelastic/{name}' is {value!r}; give a number")
    if not 0.0 < number < math.inf:
        raise GeometryError(
            f"the property 'hydroelastic/{name}' is {value}; it must be > 0 and finite"
        )
    return number
