"""STL files, binary and text. The format has no unit: numbers are metres, as in RViz and Drake.

trimesh parses them, once they are known to be whole: it would read damaged text in part, and take
the words of a name for numbers.
"""

from __future__ import annotations

import codecs

import numpy as np

from drake_geom_ros.geometry.meshes import _by_trimesh
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh
from drake_geom_ros.geometry.tolerances import UNIT_NORMAL

_HEADER = 84  # [bytes] a comment and the number of triangles
_FACET = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('attribute', '<u2')])


def parse_stl(data: bytes) -> ParsedMesh:
    """Return the mesh in an STL file; raises ValueError for a truncated or other file.

    Bytes behind the triangles of a binary file are left out, with a remark, unless they may be
    triangles that the header does not count.
    """
    stated_count = int.from_bytes(data[80:_HEADER], 'little')
    end = _HEADER + stated_count * _FACET.itemsize
    remarks: tuple[str, ...] = ()
    text = data.removeprefix(codecs.BOM_UTF8)
    count = stated_count
    if len(data) == end:
        content = data
    elif text.lstrip()[:5].lower() == b'solid' and b'\0' not in text:
        content, count = _solids_in(text.decode(errors='replace'))
    elif stated_count and end < len(data) and not _may_be_facets(data[end:]):
        content = data[:end]
        remarks = (f'{len(data) - end} bytes behind its {stated_count} triangles are left out',)
    elif len(data) < _HEADER:
        raise ValueError(
            f'{len(data)} bytes are no STL file, whose header alone has {_HEADER}: it is truncated'
        )
    else:
        actual_count = (len(data) - _HEADER) // _FACET.itemsize
        beyond = len(data) - _HEADER - stated_count * _FACET.itemsize
        reason = 'it is truncated, or no STL file'
        if beyond > 0:
            reason = f'it is too long by {beyond} bytes: damaged, or no STL file'
        raise ValueError(
            f'its header tells of {stated_count} triangles, and {actual_count} are found in '
            f'{len(data)} bytes: {reason}'
        )
    if not count:
        raise ValueError('it has no triangles')
    loaded = _by_trimesh.parsed(content, 'stl')
    solids = loaded['geometry'].values() if 'geometry' in loaded else [loaded]
    vertices = np.concatenate([np.asarray(each['vertices'], np.float64) for each in solids])
    if vertices.shape != (3 * count, 3):
        raise ValueError(f'of its {count} triangles {len(vertices) // 3} can be read')
    return ParsedMesh(vertices, np.arange(len(vertices)).reshape(-1, 3), remarks=remarks)


def _may_be_facets(data: bytes) -> bool:
    """Return whether bytes begin with a facet: finite numbers, and a normal of length 0 or 1."""
    if len(data) < _FACET.itemsize or not any(data[: _FACET.itemsize]):
        return False
    facet = np.frombuffer(data, _FACET, 1)[0]
    length = float(np.linalg.norm(facet['normal'].astype(np.float64)))
    is_normal = length == 0.0 or abs(length - 1.0) < UNIT_NORMAL
    return is_normal and bool(np.isfinite(facet['corners']).all())


def _solids_in(text: str) -> tuple[bytes, int]:
    """Return the vertices of a file of text, in solids without names, and its facets' number."""
    lines: list[str] = []
    vertices = facets = 0
    inside = False  # a solid
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.lower().split()
        word = words[0] if words else ''
        if word == 'vertex':
            _check_vertex(words, line, number)
            vertices += 1
            lines.append(' '.join(words))
        elif word == 'endfacet':
            facets += 1
            if vertices != 3 * facets:
                raise ValueError(
                    f'line {number}: facet {facets} has {vertices - 3 * facets + 3} vertices'
                )
        elif word in ('solid', 'endsolid'):
            if inside == (word == 'solid'):
                raise ValueError(
                    f'line {number}: {word!r} {"within" if inside else "without"} a solid'
                )
            inside = not inside
            lines.append(word)
    if inside or vertices != 3 * facets:
        raise ValueError(f"it is truncated: {facets} triangles are found, and no 'endsolid'")
    return '\n'.join([*lines, '']).encode(), facets


def _check_vertex(words: list[str], line: str, number: int) -> None:
    """Raise ValueError for a vertex that is no three numbers."""
    try:
        is_point = len([float(word) for word in words[1:]]) == 3
    except ValueError:
        is_point = False
    if not is_point:
        raise ValueError(f'line {number}: {line.strip()!r} is no vertex')
