"""Thickness for meshes whose vertices lie in a plane, which have no inside as they are."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry.meshes._library import extent_axes
from drake_geom_ros.geometry.meshes.source import MeshData, mesh_source, surface, triangles_of
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh, mesh_of


def thickened(shape: Convex | Mesh, thickness: float) -> Convex | None:
    """Return the hull of a flat mesh with a thickness [m], half on each side; None if not flat.

    A mesh whose vertices lie in a line is that thick in both directions across it, one in a point
    in all three. Raises MeshFileError for a file that cannot be read.
    """
    mesh = mesh_of(shape)
    rank = len(extent_axes(triangles_of(mesh_source(mesh)).vertices)[1])
    if rank == 3:
        return None
    vertices, _ = surface(mesh, shape.scale3())
    for axis in extent_axes(vertices)[0][rank:]:
        offset = 0.5 * thickness * axis
        vertices = np.vstack((vertices - offset, vertices + offset))
    return Convex.FromMeshData(MeshData(vertices))
