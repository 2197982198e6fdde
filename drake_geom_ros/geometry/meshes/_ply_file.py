"""PLY files, text and binary: ``vertex`` and ``face``, with their colours.

The format has no unit: numbers are metres, as in RViz. trimesh parses the numbers. It takes the
first of an element's lists for the lengths of all, rounds text to single precision, and leaves out
what a row has too much; so rows are checked, or written anew, before.
"""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry.meshes import _by_trimesh
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh
from drake_geom_ros.geometry.meshes._polygons import cut_faces
from drake_geom_ros.math.array_types import Floats, Indices

# Names of types by the characters of ``struct``.
_OF_KINDS = {
    'b': 'char int8',
    'B': 'uchar uint8',
    'h': 'short int16',
    'H': 'ushort uint16',
    'i': 'int int32',
    'I': 'uint uint32',
    'f': 'float float32',
    'd': 'double float64',
}
_KINDS = {name: kind for kind, names in _OF_KINDS.items() for name in names.split()}
_ORDERS = {'binary_little_endian': '<', 'binary_big_endian': '>'}
_END = b'end_header'
_LISTS = ('vertex_index', 'vertex_indices')
_COLOURS = ('red', 'green', 'blue')
_KNOWN = ('vertex', 'face', *'xyz', *_LISTS, *_COLOURS)


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

    def of(self, name: str) -> _Property | None:
        """Return the property of a name, None if there is none."""
        return next((each for each in self.properties if each.name == name), None)


def parse_ply(data: bytes) -> ParsedMesh:
    """Return the mesh in a PLY file; raises ValueError for a truncated or other file."""
    end = data.find(_END)
    if not data.startswith(b'ply') or end < 0:
        raise ValueError("it does not begin as a PLY file: 'ply' and a header up to 'end_header'")
    order, elements = _header(data[:end].decode(errors='replace'))
    by_name = {element.name: element for element in elements}
    if 'tristrips' in by_name:
        raise ValueError("it has 'tristrips'; 'face' is read")
    vertex, face = by_name.get('vertex'), by_name.get('face')
    if missing := [axis for axis in 'xyz' if vertex is None or vertex.of(axis) is None]:
        raise ValueError(f"its header has no {', '.join(missing)} of an element 'vertex'")
    assert vertex is not None
    name = next((each for each in _LISTS if face is not None and face.of(each) is not None), '')
    if face is not None and face.rows and not name:
        raise ValueError("its faces have no list 'vertex_index' or 'vertex_indices'")
    tables = _tables(order, elements, data[data.index(b'\n', end) + 1 :])
    vertices = np.column_stack([_column(tables, vertex, axis) for axis in 'xyz'])
    if face is None or not face.rows:
        return ParsedMesh(vertices, np.zeros((0, 3), dtype=np.int64))
    triangles, faces = cut_faces(*_list(tables['face'][name], face.rows), vertices)
    colours = _colours(tables, face)
    if colours is not None:
        return ParsedMesh(vertices, triangles, colours[faces].astype(np.float32))
    colours = _colours(tables, vertex)
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


def _tables(order: str, elements: list[_Element], body: bytes) -> dict[str, Any]:
    """Return trimesh's tables of all elements, checked against the header."""
    if order in _ORDERS:
        try:
            tables = _parsed(order, elements, body)
            if all(_is_even(tables[each.name], each) for each in elements):
                return tables
        except ValueError:
            pass  # too short, too long, or of lists that differ in length
        body = _rows_as_text(elements, body, _ORDERS[order])
    words = _count_words(elements, body)
    tables = _parsed('ascii', elements, body)
    if (count := sum(_size(tables[each.name], each) for each in elements)) != words:
        raise ValueError(f'of its {words} numbers {count} can be read')
    return tables


def _parsed(order: str, elements: list[_Element], body: bytes) -> dict[str, Any]:
    """Return the tables that trimesh reads, by a header of plain names."""
    lines = ['ply', f'format {order} 1.0']
    for place, element in enumerate(elements):
        if element.rows:
            lines.append(f'element {_plain(element.name, place)} {element.rows}')
            for k, each in enumerate(element.properties):
                kind, size = (_OF_KINDS.get(kind, '').partition(' ')[0] for kind in each[1:])
                if order == 'ascii':  # numbers are as in the text, whatever their type
                    kind = 'int' if size and each.kind not in 'fd' else 'double'
                of_list = f'list {size} ' if size else ''
                lines.append(f'property {of_list}{kind} {_plain(each.name, k)}')
    head = '\n'.join([*lines, 'end_header', '']).encode()
    loaded = _by_trimesh.parsed(head + body, 'ply', skip_materials=True, fix_texture=False)
    raw = loaded['metadata']['_ply_raw']
    return {
        element.name: {
            each.name: _values(raw, _plain(element.name, place), _plain(each.name, k))
            for k, each in enumerate(element.properties)
        }
        for place, element in enumerate(elements)
    }


def _plain(name: str, place: int) -> str:
    """Return the name of an element or property for trimesh, which acts on others, too."""
    return name if name in _KNOWN else f'other_{place}'


def _values(raw: dict[str, Any], element: str, name: str) -> Any:
    """Return the values of a property; an empty element has none."""
    table = raw.get(element, {}).get('data')
    return np.zeros(0) if table is None else table[name]


def _is_even(table: dict[str, Any], element: _Element) -> bool:
    """Return whether the lists of a binary element are as long as trimesh takes them for."""
    lists = [table[each.name] for each in element.properties if each.size and element.rows]
    return all((each['f0'] == each['f1'].shape[1]).all() for each in lists)


def _size(table: dict[str, Any], element: _Element) -> int:
    """Return how many words an element of text has, with the lengths of its lists."""
    size = 0
    for each in element.properties:
        if element.rows:
            members = _list(table[each.name], element.rows)[0]
            size += len(members) + (element.rows if each.size else 0)
    return size


def _list(values: Any, rows: int) -> tuple[Indices, Indices]:
    """Return the members of a list property, and how many each row has."""
    if values.dtype.names:
        values = values['f1']
    if values.dtype == object:
        counts = np.array([len(each) for each in values], dtype=np.int64)
        return np.concatenate(list(values)).astype(np.int64), counts
    members = values.reshape(rows, -1)
    return members.ravel().astype(np.int64), np.full(rows, members.shape[1], dtype=np.int64)


def _column(tables: dict[str, Any], element: _Element, name: str) -> Floats:
    """Return the column (rows,) of a property."""
    column: Floats = np.ravel(tables[element.name][name]).astype(np.float64)
    return column


def _colours(tables: dict[str, Any], element: _Element) -> Floats | None:
    """Return the colours (rows, 3) from 0 to 1 of an element's rows, None where it has none."""
    kinds = [each.kind for name in _COLOURS if (each := element.of(name)) is not None]
    if len(kinds) < len(_COLOURS):
        return None
    most = [1 if kind in 'fd' else np.iinfo(np.dtype(kind)).max for kind in kinds]
    return np.column_stack([_column(tables, element, name) for name in _COLOURS]) / most


def _count_words(elements: list[_Element], body: bytes) -> int:
    """Return how many words the rows of text have.

    Raises ValueError for rows that are missing, left over, or of another length than their lists
    say.
    """
    rows = [words for row in body.splitlines() if (words := row.split())]
    done = 0
    for element in elements:
        element_rows = rows[done : done + element.rows]
        if len(element_rows) < element.rows:
            raise ValueError(_truncated(element))
        for words in element_rows:
            width = 0
            for each in element.properties:
                width += 1 + (int(words[width]) if each.size and width < len(words) else 0)
            if width != len(words):
                raise ValueError(
                    f'a row of {element.name!r} has {len(words)} numbers, not {width}'
                )
        done += element.rows
    if left := sum(map(len, rows[done:])):
        raise ValueError(f'{left} numbers are left over after what its header tells of')
    return sum(map(len, rows))


def _rows_as_text(elements: list[_Element], body: bytes, order: str) -> bytes:
    """Return the rows of a binary file, whose lists differ in length, as lines of text."""
    lines: list[str] = []
    place = 0
    for element in elements:
        for _ in range(element.rows):
            words: list[str] = []
            for each in element.properties:
                count = 1
                try:
                    if each.size:
                        (count,) = struct.unpack_from(order + each.size, body, place)
                        place += struct.calcsize(order + each.size)
                        words.append(str(int(count)))
                    kinds = f'{order}{int(count)}{each.kind}'
                    words += map(repr, struct.unpack_from(kinds, body, place))
                except struct.error:
                    raise ValueError(_truncated(element)) from None
                place += struct.calcsize(kinds)
            lines.append(' '.join(words))
    if left := len(body) - place:
        raise ValueError(f'{left} bytes are left over after what its header tells of')
    return '\n'.join(lines).encode()


def _truncated(element: _Element) -> str:
    return f'its header tells of {element.rows} rows of {element.name!r}: it is truncated'
