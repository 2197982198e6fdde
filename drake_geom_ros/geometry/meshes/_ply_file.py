"""PLY files, text and binary: ``vertex`` and ``face``, with their colours.

The format has no unit: numbers are metres, as in RViz.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from drake_geom_ros.geometry.meshes._obj_file import triangulate
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh
from drake_geom_ros.math.array_types import Floats, Indices

_KINDS = {
    name: kind
    for kind, names in {
        'i1': 'char int8',
        'u1': 'uchar uint8',
        'i2': 'short int16',
        'u2': 'ushort uint16',
        'i4': 'int int32',
        'u4': 'uint uint32',
        'f4': 'float float32',
        'f8': 'double float64',
    }.items()
    for name in names.split()
}
_ORDERS = {'binary_little_endian': '<', 'binary_big_endian': '>'}
_END = b'end_header'


class _Property(NamedTuple):
    """A column of an element; a list has a number of members of the type ``size``."""

    name: str
    kind: str
    size: str = ''


class _Element(NamedTuple):
    """A table of the file, as described by its header."""

    name: str
    rows: int
    properties: list[_Property]


Columns = dict[str, Floats]
Lists = dict[str, tuple[Indices, Indices]]


class _TruncatedError(Exception):
    """Raised if the file has fewer numbers than its header states."""


class _PlyBody(Protocol):
    """Reader of the numbers after the header, in their order."""

    position: int

    def table(self, kinds: list[str], rows: int) -> Floats:
        """Return numbers (rows, len(kinds)); raises _TruncatedError if there are too few."""

    def left(self) -> str:
        """Return a description of the unread remainder; empty for none."""


class _Text:
    def __init__(self, body: bytes) -> None:
        self.position = 0
        self._words = body.split()

    def table(self, kinds: list[str], rows: int) -> Floats:
        end = self.position + rows * len(kinds)
        words = self._words[self.position : end]
        if len(words) < rows * len(kinds):
            raise _TruncatedError
        self.position = end
        return np.array(words, dtype=np.float64).reshape(rows, len(kinds))

    def left(self) -> str:
        count = len(self._words) - self.position
        return f'{count} numbers' if count else ''


class _Binary:
    def __init__(self, body: bytes, order: str) -> None:
        self.position = 0
        self._body, self._order = body, order

    def table(self, kinds: list[str], rows: int) -> Floats:
        row = np.dtype([(str(k), self._order + kind) for k, kind in enumerate(kinds)])
        if len(self._body) - self.position < rows * row.itemsize:
            raise _TruncatedError
        table = np.frombuffer(self._body, row, rows, self.position)
        self.position += rows * row.itemsize
        columns = [table[str(k)].astype(np.float64) for k in range(len(kinds))]
        return np.stack(columns, axis=1) if columns else np.zeros((rows, 0))

    def left(self) -> str:
        count = len(self._body) - self.position
        return f'{count} bytes' if count else ''


def parse_ply(data: bytes) -> ParsedMesh:
    """Return the mesh in a PLY file; raises ValueError for a truncated or other file."""
    end = data.find(_END)
    if not data.startswith(b'ply') or end < 0:
        raise ValueError("it does not begin as a PLY file: 'ply' and a header up to 'end_header'")
    order, elements = _header(data[:end].decode(errors='replace'))
    start = data.index(b'\n', end) + 1
    body: _PlyBody = (
        _Binary(data[start:], _ORDERS[order]) if order in _ORDERS else _Text(data[start:])
    )
    tables = {element.name: _read(body, element) for element in elements}
    if body.left():
        raise ValueError(f'{body.left()} are left over after what its header tells of')
    by_name = {element.name: element for element in elements}
    if 'tristrips' in by_name:
        raise ValueError("it has 'tristrips'; 'face' is read")
    columns = tables['vertex'][0] if 'vertex' in tables else {}
    if missing := [axis for axis in 'xyz' if axis not in columns]:
        raise ValueError(f"its header has no {', '.join(missing)} of an element 'vertex'")
    vertices = np.stack([columns[axis] for axis in 'xyz'], axis=1)
    none = np.zeros((0, 3), dtype=np.int64)
    if 'face' not in tables:
        return ParsedMesh(vertices, none)
    of_faces, lists = tables['face']
    corners, counts = next(
        (lists[name] for name in ('vertex_index', 'vertex_indices') if name in lists),
        (none[:, 0], np.zeros(0, dtype=np.int64)),
    )
    if by_name['face'].rows and not len(counts):
        raise ValueError("its faces have no list 'vertex_index' or 'vertex_indices'")
    triangles, faces = _triangles(corners, counts, vertices)
    colours = _colours(by_name['face'], of_faces)
    if colours is not None:
        return ParsedMesh(vertices, triangles, colours[faces].astype(np.float32))
    colours = _colours(by_name['vertex'], columns)
    if colours is not None:
        colours = colours[triangles].mean(axis=1).astype(np.float32)
    return ParsedMesh(vertices, triangles, colours)


def _header(text: str) -> tuple[str, list[_Element]]:
    """Return the format of the file, and its elements."""
    order, elements = '', list[_Element]()
    for line in text.splitlines()[1:]:
        words = line.split()
        if words[:1] == ['format']:
            order = words[1]
        elif words[:1] == ['element']:
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[:2] == ['property', 'list']:
            made = _Property(words[4], _KINDS[words[3]], _KINDS[words[2]])
            elements[-1].properties.append(made)
        elif words[:1] == ['property']:
            elements[-1].properties.append(_Property(words[2], _KINDS[words[1]]))
        elif words and words[0] not in ('comment', 'obj_info'):
            raise ValueError(f'its header has the line {line.strip()!r}')
    if order != 'ascii' and order not in _ORDERS:
        raise ValueError(f'its format is {order!r}; ascii, {", ".join(_ORDERS)} are read')
    _refuse_doubles('element', [element.name for element in elements])
    for element in elements:
        _refuse_doubles(f'{element.name} property', [each.name for each in element.properties])
    return order, elements


def _refuse_doubles(what: str, names: list[str]) -> None:
    """Raise ValueError for a duplicate name, since it is ambiguous."""
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f'its header has the {what} {name!r} twice; it must be there once')


def _read(body: _PlyBody, element: _Element) -> tuple[Columns, Lists]:
    """Return the columns (rows,) of an element, and its lists: their members and their lengths."""
    start = body.position
    try:
        blocks = _alike(body, element)
        if blocks is None:
            body.position = start
            blocks = [_row(body, element.properties) for _ in range(element.rows)]
    except _TruncatedError:
        raise ValueError(
            f'its header tells of {element.rows} rows of {element.name!r}: it is truncated'
        ) from None
    columns: Columns = {}
    lists: Lists = {}
    for k, each in enumerate(element.properties):
        parts = [row[k] for row in blocks]
        members = np.concatenate([np.zeros(0), *(part.ravel() for part in parts)])
        if each.size:
            lengths = [np.full(len(part), part.shape[1], dtype=np.int64) for part in parts]
            none = np.zeros(0, dtype=np.int64)
            lists[each.name] = members.astype(np.int64), np.concatenate([none, *lengths])
        else:
            columns[each.name] = members
    return columns, lists


def _row(body: _PlyBody, properties: list[_Property]) -> list[Floats]:
    """Return the values (1, members) of each property in the next row."""
    values = []
    for each in properties:
        members = int(body.table([each.size], 1)[0, 0]) if each.size else 1
        values.append(body.table([each.kind] * members, 1))
    return values


def _alike(body: _PlyBody, element: _Element) -> list[list[Floats]] | None:
    """Return the values (rows, members) of each property, or None if lists differ in length.

    Usually all rows have the lengths of the first one; other tables are read row by row, slowly.
    """
    if not element.rows:
        return []
    start = body.position
    widths = [part.shape[1] for part in _row(body, element.properties)]
    body.position = start
    kinds: list[str] = []
    places = []
    for each, width in zip(element.properties, widths, strict=True):
        kinds += [each.size] if each.size else []
        places.append(len(kinds))
        kinds += [each.kind] * width
    try:
        table = body.table(kinds, element.rows)
    except _TruncatedError:
        return None
    for each, place, width in zip(element.properties, places, widths, strict=True):
        if each.size and (table[:, place - 1] != width).any():
            return None
    return [[table[:, k : k + width] for k, width in zip(places, widths, strict=True)]]


def _triangles(corners: Indices, counts: Indices, vertices: Floats) -> tuple[Indices, Indices]:
    """Return the triangles (m, 3) of faces with ``counts`` corners, and the face of each."""
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
        raise ValueError(f'a face has the vertex {corners.max()}; there are {len(vertices)}')
    if (counts == 3).all():
        return corners.reshape(-1, 3), np.arange(len(counts))
    triangles: list[tuple[int, int, int]] = []
    faces: list[int] = []
    ends = np.cumsum(counts).tolist()
    for face, (end, count) in enumerate(zip(ends, counts.tolist(), strict=True)):
        if count < 3:
            raise ValueError(f'face {face} has {count} corners')
        names = corners[end - count : end].tolist()
        x, y, z = vertices[names].T.tolist()
        made = triangulate(names, list(zip(x, y, z, strict=True)))
        triangles += made
        faces += [face] * len(made)
    return np.array(triangles, dtype=np.int64).reshape(-1, 3), np.array(faces, dtype=np.int64)


def _colours(element: _Element, columns: Columns) -> Floats | None:
    """Return the colours (rows, 3) from 0 to 1 of an element's rows, None where it has none."""
    names = ('red', 'green', 'blue')
    if not all(name in columns for name in names):
        return None
    kinds = {each.name: np.dtype(each.kind) for each in element.properties}
    most = [1 if kinds[name].kind == 'f' else np.iinfo(kinds[name]).max for name in names]
    return np.stack([columns[name] for name in names], axis=1) / most
