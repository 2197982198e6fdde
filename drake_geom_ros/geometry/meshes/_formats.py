"""Table of mesh file formats, and the function that parses any of them.

Lengths are metres, and the up axis is as in RViz: glTF is rotated to Z up, Collada's ``<unit>`` is
applied and its ``<up_axis>`` is not; the others have neither.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree.ElementTree import ParseError

from drake_geom_ros.common.stand_ins import stand_in
from drake_geom_ros.geometry.errors import GeometryError, MeshFileError
from drake_geom_ros.geometry.meshes._dae_file import parse_dae
from drake_geom_ros.geometry.meshes._gltf_file import parse_gltf
from drake_geom_ros.geometry.meshes._obj_file import parse_obj
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh
from drake_geom_ros.geometry.meshes._ply_file import parse_ply
from drake_geom_ros.geometry.meshes._stl_file import parse_stl
from drake_geom_ros.geometry.meshes._vtk_file import parse_vtk

_READERS: dict[str, Callable[[bytes], ParsedMesh]] = {
    'dae': parse_dae,
    'glb': parse_gltf,
    'gltf': parse_gltf,
    'ply': parse_ply,
    'stl': parse_stl,
    'vtk': parse_vtk,
}
FORMATS = tuple(sorted({'obj', *_READERS}))  # the suffixes, in lower case
VOLUME_FORMATS = ('vtk',)  # those of tetrahedra


def parse_mesh(data: bytes, kind: str, filename: str) -> ParsedMesh:
    """Return the mesh in a file's content; ``kind`` is its suffix.

    Files that it refers to are not opened. Raises MeshFileError for another format, and for
    content that cannot be read completely.
    """
    if reason := stand_in(data):
        raise MeshFileError(f'{filename!r} cannot be read: {reason}')
    if kind == 'obj':
        return ParsedMesh(*parse_obj(data.decode('utf-8-sig', errors='replace'), filename))
    if kind not in _READERS:
        raise MeshFileError(
            f'{filename!r}: mesh files of the formats {", ".join(FORMATS)} are read, by their '
            f'suffix, and {kind!r} is none of them'
        )
    try:
        return _READERS[kind](data)
    except (ValueError, ParseError, GeometryError) as error:
        raise MeshFileError(f'{filename!r} cannot be read: {error}') from None
    except Exception as error:
        # A document of another structure leads to errors of many kinds.
        raise MeshFileError(f'{filename!r} holds no mesh that can be read: {error!r}') from None
