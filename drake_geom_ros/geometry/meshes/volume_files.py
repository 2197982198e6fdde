"""Refinement of files of tetrahedra for pressure fields."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry.checks import checked_type
from drake_geom_ros.geometry.errors import MeshFileError
from drake_geom_ros.geometry.meshes._vtk_file import vtk_text
from drake_geom_ros.geometry.meshes.in_memory import MeshSource
from drake_geom_ros.geometry.meshes.source import volume
from drake_geom_ros.geometry.meshes.volume_surface import RefineVolumeMesh


def RefineVolumeMeshIntoVtkFileContents(mesh_source: MeshSource) -> str:
    """Return the content of a legacy ASCII .vtk file, with a file's tetrahedra after refinement.

    See ``RefineVolumeMesh``. Coordinates [m] are written with all their digits, so that the file
    is read as the same mesh. Raises RuntimeError for a file that is missing, is no .vtk file of
    tetrahedra, or has one that has no volume or is inside out.

        >>> from drake_geom_ros.common import MemoryFile
        >>> from drake_geom_ros.geometry import InMemoryMesh, MeshSource
        >>> text = '''# vtk DataFile Version 3.0
        ... one tetrahedron, all corners on the boundary
        ... ASCII
        ... DATASET UNSTRUCTURED_GRID
        ... POINTS 4 double
        ... 0 0 0  4 0 0  0 4 0  0 0 4
        ... CELLS 1 5
        ... 4 0 1 2 3
        ... CELL_TYPES 1
        ... 10
        ... '''
        >>> source = MeshSource(InMemoryMesh(mesh_file=MemoryFile(text, '.vtk', 'one')))
        >>> print(RefineVolumeMeshIntoVtkFileContents(source).splitlines()[9])
        1.0 1.0 1.0
    """
    checked_type(mesh_source, MeshSource, 'RefineVolumeMeshIntoVtkFileContents: mesh_source')
    is_path = mesh_source.is_path()
    source = str(mesh_source.path()) if is_path else mesh_source.in_memory()
    mesh = volume(source, np.ones(3))
    if mesh is None:
        raise MeshFileError(
            f'RefineVolumeMeshIntoVtkFileContents was given {mesh_source!r}, which is no .vtk '
            'file: only these have tetrahedra'
        )
    return vtk_text(RefineVolumeMesh(mesh))
