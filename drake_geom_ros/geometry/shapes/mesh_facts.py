"""Facts of a mesh: its size, whether it is closed, and remarks on its file."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry.errors import MeshFileError
from drake_geom_ros.geometry.meshes._solids import have_area
from drake_geom_ros.geometry.meshes._welding import closed_surface
from drake_geom_ros.geometry.meshes.source import remarks_on, surface
from drake_geom_ros.geometry.shapes.from_meshes import Convex, Mesh, mesh_of
from drake_geom_ros.math.array_types import Floats


class MeshFacts(NamedTuple):
    """Facts of a mesh as scaled: the corners (3,) [m] of the box around it, and more.

    It is closed if its triangles meet along every edge; ``remarks`` are those of its file,
    what was welded to close it, and how many of its triangles have no area.
    """

    low: Floats
    high: Floats
    num_triangles: int
    is_closed: bool
    remarks: tuple[str, ...]


def mesh_facts(shape: Convex | Mesh) -> MeshFacts:
    """Return the facts of the mesh that a shape was made of, not of its hull.

    Raises MeshFileError for a file that cannot be read.
    """
    vertices, triangles = surface(mesh_of(shape), shape.scale3())
    remarks = remarks_on(mesh_of(shape))
    is_closed = True
    try:
        remarks += closed_surface(vertices, triangles, '').remarks()
    except MeshFileError:
        is_closed = False
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    flat = int((~have_area(vertices[triangles])).sum()) if len(triangles) else 0
    if flat:
        remarks += (f'{flat} of its triangles have no area: they belong to no surface',)
    return MeshFacts(low, high, len(triangles), is_closed, remarks)
