"""Wavefront .obj files: vertices and faces, faces cut into triangles, objects merged.

The reader uses ``v`` and ``f`` of all objects and groups, and skips normals, textures and
materials. Curved surfaces and references to other files are errors. There is no unit: numbers are
metres, as in RViz and Drake. NumPy parses the numbers, in blocks of statements. trimesh's reader
would drop lines that are indented, read relative indices of vertices from the end of the file, and
skip faces that it does not understand; and it took 0.4 kB a vertex, most of it for words.
"""

from __future__ import annotations

import os
import re
from array import array
from collections import defaultdict
from collections.abc import Iterator, MutableSequence
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.errors import MeshFileError
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh
from drake_geom_ros.geometry.meshes._polygons import cut_faces
from drake_geom_ros.math.array_types import Floats, Indices

# Surfaces that are no polygons, and statements that refer to another file.
_NOT_READ = ('surf', 'bzp', 'bsp', 'call', 'csh')
_BLOCK = 1 << 16  # characters that are split together
_STATEMENTS = 1 << 14  # parsed together
Number = TypeVar('Number', bound=np.generic)
_PLAIN_CORNERS = re.compile('[1-9][0-9]*(?: [1-9][0-9]*)+').fullmatch


class StatementLines(NamedTuple):
    """The numbers of statements of one kind, as text, and the lines of the file they are on."""

    texts: list[str]
    numbers: MutableSequence[int]


class _Mesh(NamedTuple):
    """Vertices (n, 3), triangles (m, 3), and the face (m,) of each, in the order of the file."""

    vertices: Floats
    triangles: Indices
    faces: Indices


def read_obj(filename: str | os.PathLike[str]) -> tuple[Floats, Indices]:
    """Return vertices (n, 3) and triangles (m, 3), indices counted from 0, of an .obj file.

    Raises MeshFileError with file and line if it cannot be read, has an invalid number or index,
    or has no faces.
    """
    try:
        text = Path(filename).read_text(encoding='utf-8-sig', errors='replace')
    except OSError as error:
        raise MeshFileError(f"'{filename}' cannot be read: {error.strerror}") from None
    mesh = parse_obj(text, filename)
    if len(mesh.triangles) == 0:
        raise MeshFileError(f"'{filename}' has no faces: no line of it begins with 'f '")
    return mesh.vertices, mesh.triangles


def obj_text(points: Floats, triangles: Indices | None = None) -> str:
    """Return vertices (n, 3) and triangles (m, 3), counted from 0, as the text of an .obj file."""
    lines = ['v ' + ' '.join(_shortest(x) for x in point) for point in points.tolist()]
    if triangles is not None:
        lines += ['f ' + ' '.join(map(str, corners)) for corners in (triangles + 1).tolist()]
    return ''.join(f'{line}\n' for line in lines)


def _shortest(x: float) -> str:
    """Return the shortest text that parses to the same number."""
    return repr(x).removesuffix('.0')


def parse_obj(text: str, filename: str | os.PathLike[str]) -> ParsedMesh:
    """Return the mesh in a file's text, which may have no faces; errors as ``read_obj``.

    Its parts are named by the last ``o`` or ``g`` before a face.
    """
    points = StatementLines([], array('q'))  # a list takes 40 bytes a line
    # By the number of corners.
    faces: dict[int, StatementLines] = defaultdict(lambda: StatementLines([], array('q')))
    name, names, labels = '', list[str](), list[int]()  # of parts, and the part of each face
    for number, words in _statements(text):
        if words[0] == 'v':
            points.texts.append(' '.join(words[1:4]))
            points.numbers.append(number)
        elif words[0] == 'f':
            corners = _corners(words[1:], len(points.texts), f'{filename}:{number}')
            of_kind = faces[len(words) - 1]
            of_kind.texts.append(corners)
            of_kind.numbers.append(number)
            if not names or names[-1] != name:
                names.append(name)
            labels.append(len(names) - 1)
        elif words[0] in ('o', 'g'):
            name = ' '.join(words[1:])
        elif words[0] in _NOT_READ:
            raise MeshFileError(f'{filename}:{number}: {words[0]!r} is not read; export triangles')
    if not points.texts:
        raise MeshFileError(f"'{filename}' has no faces and no vertices: no line begins with 'v '")
    try:
        mesh = mesh_of(points, faces)
    except (ValueError, IndexError):
        _check_points(points, filename)
        _check_indices(faces, len(points.texts), filename)
        raise
    parts: dict[str, list[Indices]] = defaultdict(list)
    of_triangles = np.array(labels, dtype=np.int64)[mesh.faces]
    for label, part in enumerate(names):
        if part:
            parts[part].append(np.flatnonzero(of_triangles == label))
    return ParsedMesh(
        mesh.vertices,
        mesh.triangles,
        parts={part: np.concatenate(rows) for part, rows in parts.items()},
    )


def mesh_of(points: StatementLines, faces: dict[int, StatementLines]) -> _Mesh:
    """Return the mesh of statements; raises ValueError or IndexError for invalid ones."""
    vertices = _numbers(points.texts, 3, np.float64)
    if not np.isfinite(vertices).all():
        raise ValueError('a vertex is no three finite numbers')
    by_count = {count: _numbers(each.texts, count, np.int64) - 1 for count, each in faces.items()}
    if any(each.max() >= len(vertices) for each in by_count.values()):
        raise IndexError('a face has a vertex beyond the last one')
    # Back in the order of the file.
    lines_of = [number for count in faces for number in faces[count].numbers]
    places = np.argsort(np.argsort(np.array(lines_of, dtype=np.int64)))
    counts = np.zeros(len(places), dtype=np.int64)
    counts[places] = np.repeat(list(faces), [len(each.texts) for each in faces.values()])
    starts = np.cumsum(counts) - counts
    corners = np.zeros(counts.sum(), dtype=np.int64)
    done = 0
    for count, each in faces.items():
        rows = places[done : done + len(each.texts)]
        corners[starts[rows][:, None] + np.arange(count)] = by_count[count]
        done += len(each.texts)
    return _Mesh(vertices, *cut_faces(corners, counts, vertices))


def _numbers(texts: list[str], count: int, kind: type[Number]) -> NDArray[Number]:
    """Return the numbers of statements with ``count`` each; raises ValueError for other words."""
    numbers = np.empty((len(texts), count), dtype=kind)
    for first in range(0, len(texts), _STATEMENTS):
        some = texts[first : first + _STATEMENTS]
        # The same parser as of trimesh's reader. It refuses other words, or ends before them.
        flat = np.fromstring(' '.join(some), dtype=kind, sep=' ')
        numbers[first : first + len(some)] = flat.reshape(len(some), count)
    return numbers


def _statements(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and words of each statement, without comments and blank lines."""
    pending: list[str] = []
    for number, line in enumerate(_lines(text), start=1):
        words = line.split('#', 1)[0].split()
        if words and words[-1].endswith('\\'):  # goes on in the next line
            pending += [*words[:-1], words[-1][:-1]]
            continue
        statement = [word for word in pending + words if word] if pending else words
        pending = []
        if statement:
            yield number, statement
    if pending := [word for word in pending if word]:  # a last line that is continued by none
        yield number, pending


def _lines(text: str) -> Iterator[str]:
    """Yield the lines of a text as ``splitlines`` lists them; a list takes twice the text."""
    start = 0
    while start < len(text):
        end = text.find('\n', start + _BLOCK) + 1 or len(text)
        yield from text[start:end].splitlines()
        start = end


def _corners(words: list[str], count: int, where: str) -> str:
    """Return the vertices of a face, counted from 1, after ``count`` vertices were read."""
    if len(words) < 3:
        raise MeshFileError(f'{where}: a face needs at least three vertices, given {words}')
    text = ' '.join([word.partition('/')[0] for word in words])
    if _PLAIN_CORNERS(text):
        return text
    corners = []
    for word in words:
        try:
            index = int(word.partition('/')[0])
        except ValueError:
            raise MeshFileError(f'{where}: {word!r} is not the index of a vertex') from None
        corner = index if index > 0 else count + index + 1  # a negative one counts from the end
        if index == 0 or corner < 1:
            raise MeshFileError(
                f'{where}: there is no vertex {index}; {count} were given by then, from 1'
            )
        corners.append(str(corner))
    return ' '.join(corners)


def _check_points(points: StatementLines, filename: str | os.PathLike[str]) -> None:
    """Raise MeshFileError for the first vertex that is no three finite numbers."""
    for text, number in zip(*points, strict=True):
        try:
            point = [float(word) for word in text.split()]
        except ValueError:
            point = []
        if len(point) != 3 or not np.isfinite(point).all():
            raise MeshFileError(
                f'{filename}:{number}: a vertex needs three finite numbers, given {text.split()}'
            )


def _check_indices(
    faces: dict[int, StatementLines], count: int, filename: str | os.PathLike[str]
) -> None:
    """Raise MeshFileError for the first face with a vertex beyond the last one."""
    for each in faces.values():
        for text, number in zip(*each, strict=True):
            highest = max(map(int, text.split()))
            if highest > count:
                raise MeshFileError(
                    f'{filename}:{number}: there is no vertex {highest}, the file has {count}'
                )
