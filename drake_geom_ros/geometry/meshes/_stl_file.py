"""STL files, binary and text. The format has no unit: numbers are metres, as in RViz and Drake."""

from __future__ import annotations

import codecs

import numpy as np
from numpy.typing import NDArray

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
    if len(data) == end:
        corners = np.frombuffer(data, _FACET, stated_count, _HEADER)['corners']
    elif text.lstrip()[:5].lower() == b'solid' and b'\0' not in text:
        corners = _corners_in(text.decode(errors='replace'))
    elif stated_count and end < len(data) and not _may_be_facets(data[end:]):
        corners = np.frombuffer(data, _FACET, stated_count, _HEADER)['corners']
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
    if not len(corners):
        raise ValueError('it has no triangles')
    vertices = corners.reshape(-1, 3).astype(np.float64)
    return ParsedMesh(vertices, np.arange(len(vertices)).reshape(-1, 3), remarks=remarks)


def _may_be_facets(data: bytes) -> bool:
    """Return whether bytes begin with a facet: finite numbers, and a normal of length 0 or 1."""
    if len(data) < _FACET.itemsize or not any(data[: _FACET.itemsize]):
        return False
    facet = np.frombuffer(data, _FACET, 1)[0]
    length = float(np.linalg.norm(facet['normal'].astype(np.float64)))
    is_normal = length == 0.0 or abs(length - 1.0) < UNIT_NORMAL
    return is_normal and bool(np.isfinite(facet['corners']).all())


def _corners_in(text: str) -> NDArray[np.float64]:
    """Return the corners (m, 3, 3) of the facets in a file of text."""
    corners: list[list[float]] = []
    facets = 0
    inside = False  # a solid
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        word = words[0].lower() if words else ''
        if word == 'vertex':
            try:
                x, y, z = map(float, words[1:])
            except ValueError:
                raise ValueError(f'line {number}: {line.strip()!r} is no vertex') from None
            corners.append([x, y, z])
        elif word == 'endfacet':
            facets += 1
            if len(corners) != 3 * facets:
                raise ValueError(
                    f'line {number}: facet {facets} has {len(corners) - 3 * facets + 3} vertices'
                )
        elif word in ('solid', 'endsolid'):
            if inside == (word == 'solid'):
                raise ValueError(
                    f'line {number}: {word!r} {"within" if inside else "without"} a solid'
                )
            inside = not inside
    if inside or len(corners) != 3 * facets:
        raise ValueError(f"it is truncated: {facets} triangles are found, and no 'endsolid'")
    return np.array(corners, dtype=np.float64).reshape(-1, 3, 3)
