"""Legacy .vtk files of tetrahedra, parsed by meshio, which only this file imports.

Supported is an ASCII UNSTRUCTURED_GRID whose cells are all tetrahedra (type 10); data of points
and cells are skipped. There is no unit: numbers are metres, as in Drake.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh
from drake_geom_ros.geometry.meshes.volume_surface import (
    ConvertVolumeToSurfaceMesh,
    check_elements,
)

_MISSING = (
    'meshio is not installed, and .vtk files take it: pip install meshio, or this package with '
    "its extra 'volume_meshes'"
)
_TETRAHEDRA = 'its cells must be tetrahedra, of type 10'
_LAYOUT = (
    'CELLS must be rows of 4 and four vertices, or in version 5.1, and no other, OFFSETS and '
    'CONNECTIVITY'
)
_HEAD = 2000  # [bytes] the lines that identify the format are within these
_ANNOUNCED = re.compile(rb'^\s*CELL_TYPES\s+(\d+)', re.IGNORECASE | re.MULTILINE)


def parse_vtk(data: bytes) -> ParsedMesh:
    """Return the boundary of a file's tetrahedra, and these as ``ParsedMesh.volume``.

    Unused vertices are left out. Raises ValueError, or an error of meshio, for other content, and
    for tetrahedra that have no volume, are inside out, or overlap at a face.
    """
    _check_kind(data)
    read = _read(data)
    head = data[:_HEAD].splitlines(keepends=True)[:2]  # the title may be anything
    declared = _ANNOUNCED.search(data, sum(map(len, head)))
    kinds = {block.type for block in read.cells}
    if others := kinds - {'tetra'}:
        raise ValueError(f'it has cells of the kind {", ".join(sorted(others))}; {_TETRAHEDRA}')
    if not kinds:
        raise ValueError(f'it has no cells; {_TETRAHEDRA}')
    elements = np.concatenate([np.asarray(block.data, dtype=np.int64) for block in read.cells])
    # meshio drops the cells after the last type of a truncated file.
    if declared is None or len(elements) != int(declared[1]):
        raise ValueError(f'it ends early: {len(elements)} cells of those that it announces')
    volume = VolumeMesh.FromArrays(elements, np.asarray(read.points, dtype=np.float64))
    check_elements(volume, 'its tetrahedra')  # by the numbers of the file
    volume = _used(volume)
    boundary = ConvertVolumeToSurfaceMesh(volume)
    vertices, triangles = boundary.vertex_array(), boundary.triangle_array()
    return ParsedMesh(vertices.copy(), triangles.copy(), volume=volume)


def vtk_text(mesh: VolumeMesh) -> str:
    """Return the text of a file that ``parse_vtk`` reads as this mesh, to the bit."""
    elements, points = mesh.element_array().tolist(), mesh.vertex_array().tolist()
    lines = [
        '# vtk DataFile Version 3.0',
        'tetrahedra, in metres',
        'ASCII',
        'DATASET UNSTRUCTURED_GRID',
        f'POINTS {len(points)} double',
        *(' '.join(map(repr, point)) for point in points),
        f'CELLS {len(elements)} {5 * len(elements)}',
        *(' '.join(map(str, (4, *corners))) for corners in elements),
        f'CELL_TYPES {len(elements)}',
        *['10'] * len(elements),
    ]
    return '\n'.join(lines) + '\n'


def _check_kind(data: bytes) -> None:
    """Raise ValueError unless it is a legacy ASCII file of an unstructured grid."""
    lines = [line.strip().upper() for line in data[:_HEAD].splitlines()]
    if not lines or not lines[0].startswith(b'# VTK DATAFILE VERSION'):
        raise ValueError("it does not begin with '# vtk DataFile Version', as legacy files do")
    if len(lines) < 3 or lines[2] != b'ASCII':
        raise ValueError('its third line must be ASCII: files that are BINARY are not read')
    kind = next((line.split()[1:] for line in lines[3:] if line.startswith(b'DATASET')), [])
    if kind != [b'UNSTRUCTURED_GRID']:
        raise ValueError('its DATASET must be an UNSTRUCTURED_GRID')


def _read(data: bytes) -> Any:
    """Return meshio's mesh of a file, by way of the disk, since it reads only files there.

    Raises ValueError for a file that it cannot read.
    """
    try:
        from meshio import vtk
    except ImportError:
        raise ValueError(_MISSING) from None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, 'mesh.vtk')
        path.write_bytes(data)
        try:
            return vtk.read(path)
        except Exception as problem:  # of many kinds, and some without a message
            said = f' ({problem})' if str(problem) else ''
            raise ValueError(f'meshio makes nothing of it{said}; {_LAYOUT}') from None


def _used(mesh: VolumeMesh) -> VolumeMesh:
    """Return the mesh without the vertices of no element."""
    used, elements = np.unique(mesh.element_array(), return_inverse=True)
    rows: NDArray[np.int64] = elements.reshape(-1, 4)
    return VolumeMesh.FromArrays(rows, mesh.vertex_array()[used])
