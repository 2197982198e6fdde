"""Volumes and bounding boxes of shapes and meshes."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from drake_geom_ros.geometry._proximity.tolerances import EPS
from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.meshes._library import tight_box
from drake_geom_ros.geometry.meshes.surface_mesh import TriangleSurfaceMesh
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.geometry.shapes.bounding_boxes import Aabb, Obb
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh
from drake_geom_ros.geometry.shapes.primitives import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    MeshcatCone,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.shapes.sensed import SensedMap
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats


def CalcVolume(shape: Shape) -> float:
    """Return the volume [m^3] of a shape: infinite for a half space, the hull's for a Convex.

    For a Mesh, it is the volume that a closed surface encloses; an open one has none. Raises
    MeshFileError for a file that cannot be read, and ArgumentError for a sensed map.

        >>> CalcVolume(Box(1, 2, 3))
        6.0
    """
    checked_type(shape, Shape, 'CalcVolume: shape')
    if isinstance(shape, (Mesh, Convex)):
        from drake_geom_ros.geometry.meshes._solids import volume

        vertices, triangles = shape.surface() if isinstance(shape, Mesh) else shape.hull_surface()
        return volume(vertices[triangles])
    if isinstance(shape, HalfSpace):
        return math.inf
    if isinstance(shape, SensedMap):
        raise ArgumentError(
            f'CalcVolume: {shape!r} is a union of cells that may overlap, whose volume is not '
            'computed; of cells that do not it is count() times that of one'
        )
    ball = 4.0 / 3.0 * math.pi
    if isinstance(shape, Sphere):
        return ball * shape.radius() ** 3
    if isinstance(shape, Box):
        return float(shape.size().prod())
    if isinstance(shape, Ellipsoid):
        return ball * shape.a() * shape.b() * shape.c()
    if isinstance(shape, MeshcatCone):
        return math.pi / 3.0 * shape.a() * shape.b() * shape.height()
    assert isinstance(shape, (Cylinder, Capsule))
    caps = ball * shape.radius() ** 3 if isinstance(shape, Capsule) else 0.0
    return math.pi * shape.radius() ** 2 * shape.length() + caps


def CalcObb(shape: Shape) -> Obb | None:
    """Return the oriented box around a shape, in its frame.

    It is None for a half space, and for a sensed map without cells. For a Mesh or a Convex it is
    the smallest box with a side in a face of the hull; for a sensed map it is axis-aligned. Raises
    MeshFileError for a file that cannot be read.
    """
    checked_type(shape, Shape, 'CalcObb: shape')
    if isinstance(shape, HalfSpace):
        return None
    if isinstance(shape, (Mesh, Convex)):
        mesh = shape.surface() if isinstance(shape, Mesh) else shape.hull_surface()
        return _around(mesh[0])
    if isinstance(shape, SensedMap):
        if not shape.count():
            return None
        low, high = shape.box()
        return Obb(RigidTransform(0.5 * (low + high)), 0.5 * (high - low))
    centre = [0.0, 0.0, 0.0]
    if isinstance(shape, Sphere):
        half = np.full(3, shape.radius())
    elif isinstance(shape, Box):
        half = 0.5 * shape.size()
    elif isinstance(shape, Ellipsoid):
        half = np.array([shape.a(), shape.b(), shape.c()])
    elif isinstance(shape, MeshcatCone):
        half = np.array([shape.a(), shape.b(), 0.5 * shape.height()])
        centre[2] = half[2]
    else:
        assert isinstance(shape, (Cylinder, Capsule))
        radius = shape.radius()
        ends = radius if isinstance(shape, Capsule) else 0.0
        half = np.array([radius, radius, 0.5 * shape.length() + ends])
    return Obb(RigidTransform(centre), half)


def ComputeAabbForTriangleMesh(mesh_M: TriangleSurfaceMesh, vertices: Iterable[int]) -> Aabb:
    """Return the axis-aligned box, in M, of the vertices of a mesh with these indices."""
    return _box_along_axes(_some(mesh_M, vertices))


def ComputeObbForTriangleMesh(mesh_M: TriangleSurfaceMesh, vertices: Iterable[int]) -> Obb:
    """Return a smallest oriented box of the vertices of a mesh with these indices."""
    return _around(_some(mesh_M, vertices))


def ComputeAabbForVolumeMesh(mesh_M: VolumeMesh, vertices: Iterable[int]) -> Aabb:
    """Return the result of ``ComputeAabbForTriangleMesh`` for a mesh of tetrahedra."""
    return _box_along_axes(_some(mesh_M, vertices))


def ComputeObbForVolumeMesh(mesh_M: VolumeMesh, vertices: Iterable[int]) -> Obb:
    """Return the result of ``ComputeObbForTriangleMesh`` for a mesh of tetrahedra."""
    return _around(_some(mesh_M, vertices))


def _box_along_axes(p_MVs: Floats) -> Aabb:
    """Return the box along axes around points (n, 3) [m]."""
    low, high = p_MVs.min(axis=0), p_MVs.max(axis=0)
    return Aabb(0.5 * (low + high), 0.5 * (high - low))


def _some(mesh_M: TriangleSurfaceMesh | VolumeMesh, vertices: Iterable[int]) -> Floats:
    """Return the positions (n, 3) [m] of vertices; ArgumentError for none, or an unknown one."""
    indices = sorted(vertices)
    if not indices:
        raise ArgumentError('a box around vertices was asked for, and no vertex was given')
    return np.array([mesh_M.vertex(index) for index in indices])


def _around(p_GVs: Floats) -> Obb:
    """Return a smallest box around points (n, 3) [m], wide enough for rounding."""
    R_GB = RotationMatrix.ProjectToRotationMatrix(tight_box(p_GVs))
    p_BVs = p_GVs @ R_GB.matrix()
    low, high = p_BVs.min(axis=0), p_BVs.max(axis=0)
    # Three products and their sums, and the same again for the rotation back to G.
    rounding = 16.0 * EPS * float(np.abs(p_GVs).max())
    X_GB = RigidTransform(R_GB, R_GB @ (0.5 * (low + high)))
    return Obb(X_GB, 0.5 * (high - low) + rounding)
