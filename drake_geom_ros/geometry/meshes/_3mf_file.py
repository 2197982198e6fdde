"""3MF files, read by trimesh and checked against what the file says of itself.

trimesh leaves out numbers that it cannot read and parts that are missing, and keeps the unit in
its notes: such files are refused here, and lengths become metres.
"""

from __future__ import annotations

import io
import zipfile
from xml.etree import ElementTree

import numpy as np

from drake_geom_ros.geometry.meshes import _by_trimesh
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh, Pieces

_METRES = {
    'micron': 1.0 / 1_000_000.0,
    'millimeter': 1.0 / 1000.0,
    'centimeter': 0.01,
    'inch': 0.0254,
    'foot': 0.3048,
    'meter': 1.0,
}
MOST_BYTES = 500_000_000  # of a file when it is unpacked
# Extensions that add bodies or replace them.
_PLAIN = ('', 'p', 'm', 'b', 'BambuStudio', 'slic3rpe')


def parse_3mf(data: bytes) -> ParsedMesh:
    """Return the mesh of the objects that a file builds, each at its place.

    Raises ValueError, or another error for a document of another structure.
    """
    roots = _models(data)
    stated = _counts(roots)
    scene = _by_trimesh.scene_of(data, '3mf')
    counts = [
        sum(len(getattr(mesh, name)) for mesh in scene.geometry.values())
        for name in ('vertices', 'faces')
    ]
    if counts != stated:
        raise ValueError(
            f'it has {stated[0]} vertices and {stated[1]} triangles, of which {counts[0]} and '
            f'{counts[1]} can be read'
        )
    pieces = Pieces()
    for node in scene.graph.nodes_geometry:
        T_FN, name = scene.graph[node]
        mesh = scene.geometry[name]
        pieces.add(T_FN, np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces))
    unit = roots[0].get('unit', 'millimeter')
    if unit not in _METRES:
        raise ValueError(f'its unit is {unit!r}; read are {", ".join(_METRES)}')
    vertices, triangles = pieces.all()
    remarks = () if unit == 'meter' else (f'lengths are times {_METRES[unit]:g} m by its unit',)
    return ParsedMesh(vertices * _METRES[unit], triangles, None, remarks)


def _models(data: bytes) -> list[ElementTree.Element]:
    """Return the roots of the models in a file, the main one first."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if sum(each.file_size for each in archive.infolist()) > MOST_BYTES:
            raise ValueError(f'unpacked, it has more than {MOST_BYTES} bytes')
        if bad := archive.testzip():
            raise ValueError(f'its part {bad!r} is damaged')
        names = sorted(
            (each for each in archive.namelist() if each.lower().endswith('.model')),
            key=lambda each: not each.lower().endswith('3d/3dmodel.model'),
        )
        roots = [ElementTree.fromstring(archive.read(name)) for name in names]
    if not roots or not names[0].lower().endswith('3d/3dmodel.model'):
        raise ValueError("it has no part '3D/3dmodel.model'")
    required = roots[0].get('requiredextensions', '').split()
    if odd := [each for each in required if each not in _PLAIN]:
        raise ValueError(f'it requires {", ".join(odd)}, which is not read')
    return roots


def _counts(roots: list[ElementTree.Element]) -> list[int]:
    """Return how many vertices and triangles the models have."""
    tags = [each.tag.rpartition('}')[2] for root in roots for each in root.iter()]
    return [tags.count(tag) for tag in ('vertex', 'triangle')]
