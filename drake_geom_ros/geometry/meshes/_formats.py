"""Table of mesh file formats, and the function that parses any of them.

Lengths are metres, and the up axis is as in RViz: glTF is rotated to Z up, the units of
Collada and 3MF are applied, and Collada's ``<up_axis>`` is not; the others have neither.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from xml.etree.ElementTree import ParseError

from drake_geom_ros.common.stand_ins import stand_in
from drake_geom_ros.geometry.errors import GeometryError, MeshFileError
from drake_geom_ros.geometry.meshes._3mf_file import parse_3mf
from drake_geom_ros.geometry.meshes._dae_file import parse_dae
from drake_geom_ros.geometry.meshes._gltf_file import parse_gltf
from drake_geom_ros.geometry.meshes._obj_file import parse_obj
from drake_geom_ros.geometry.meshes._off_file import parse_off
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh
from drake_geom_ros.geometry.meshes._ply_file import parse_ply
from drake_geom_ros.geometry.meshes._stl_file import parse_stl
from drake_geom_ros.geometry.meshes._vtk_file import parse_vtk

_READERS: dict[str, Callable[[bytes], ParsedMesh]] = {
    'dae': parse_dae,
    '3mf': parse_3mf,
    'glb': parse_gltf,
    'off': parse_off,
    'ply': parse_ply,
    'stl': parse_stl,
    'vtk': parse_vtk,
}
FORMATS = tuple(sorted({'gltf', 'obj', *_READERS}))  # the suffixes, in lower case
_NO_FILES: Mapping[str, bytes] = MappingProxyType({})
VOLUME_FORMATS = ('vtk',)  # those of tetrahedra


def parse_mesh(
    data: bytes, kind: str, filename: str, companions: Mapping[str, bytes] = _NO_FILES
) -> ParsedMesh:
    """Return the mesh in a file's content; ``kind`` is its suffix.

    ``companions`` are the contents of the files that it names for its numbers (see
    ``companions_of``); no other file is opened. Raises MeshFileError for another format, and for
    content that cannot be read completely.
    """
    if reason := stand_in(data):
        raise MeshFileError(f'{filename!r} cannot be read: {reason}')
    if kind == 'obj':
        return parse_obj(data.decode('utf-8-sig', errors='replace'), filename)
    if kind not in FORMATS:
        raise MeshFileError(
            f'{filename!r}: mesh files of the formats {", ".join(FORMATS)} are read, by their '
            f'suffix, and {kind!r} is none of them'
        )
    try:
        return parse_gltf(data, companions) if kind == 'gltf' else _READERS[kind](data)
    except (ValueError, ParseError, GeometryError) as error:
        raise MeshFileError(f'{filename!r} cannot be read: {error}') from None
    except Exception as error:
        # A document of another structure leads to errors of many kinds.
        raise MeshFileError(f'{filename!r} holds no mesh that can be read: {error!r}') from None
