"""Wavefront .obj files: vertices and faces, faces cut into triangles, objects merged.

The reader uses ``v`` and ``f`` of all objects and groups, and skips normals, textures and
materials. Curved surfaces and references to other files are errors. There is no unit: numbers are
metres, as in RViz and Drake.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry.errors import MeshFileError
from drake_geom_ros.math.array_types import Floats, Indices

Point = tuple[float, ...]
_Flat = tuple[float, float]

# Corners of a polygon that are cut off though none is an ear; the remainder becomes a fan.
_MOST_LOST = 100

# Surfaces that are no polygons, and statements that refer to another file.
_NOT_READ = ('surf', 'bzp', 'bsp', 'call', 'csh')


class _Polygon(NamedTuple):
    """A face in the file: vertices counted from 0, and its location."""

    vertices: list[int]
    where: str


def read_obj(filename: str | os.PathLike[str]) -> tuple[Floats, Indices]:
    """Return vertices (n, 3) and triangles (m, 3), indices counted from 0, of an .obj file.

    Raises MeshFileError with file and line if it cannot be read, has an invalid number or index,
    or has no faces.
    """
    try:
        text = Path(filename).read_text(encoding='utf-8-sig', errors='replace')
    except OSError as error:
        raise MeshFileError(f"'{filename}' cannot be read: {error.strerror}") from None
    points, triangles = parse_obj(text, filename)
    if len(triangles) == 0:
        raise MeshFileError(f"'{filename}' has no faces: no line of it begins with 'f '")
    return points, triangles


def obj_text(points: Floats, triangles: Indices | None = None) -> str:
    """Return vertices (n, 3) and triangles (m, 3), counted from 0, as the text of an .obj file."""
    lines = ['v ' + ' '.join(_shortest(x) for x in point) for point in points.tolist()]
    if triangles is not None:
        lines += ['f ' + ' '.join(map(str, corners)) for corners in (triangles + 1).tolist()]
    return ''.join(f'{line}\n' for line in lines)


def _shortest(x: float) -> str:
    """Return the shortest text that parses to the same number."""
    return repr(x).removesuffix('.0')


def parse_obj(text: str, filename: str | os.PathLike[str]) -> tuple[Floats, Indices]:
    """Return the result of ``read_obj`` for a file's text, which may have no faces."""
    points: list[Point] = []
    polygons: list[_Polygon] = []
    for number, words in _statements(text):
        where = f'{filename}:{number}'
        if words[0] == 'v':
            points.append(_point(words[1:4], where))
        elif words[0] == 'f':
            polygons.append(_Polygon(_corners(words[1:], len(points), where), where))
        elif words[0] in _NOT_READ:
            raise MeshFileError(f'{where}: {words[0]!r} is not read; export triangles')
    if not points:
        raise MeshFileError(f"'{filename}' has no faces and no vertices: no line begins with 'v '")
    triangles: list[tuple[int, int, int]] = []
    for polygon in polygons:
        if max(polygon.vertices) >= len(points):
            raise MeshFileError(
                f'{polygon.where}: there is no vertex {max(polygon.vertices) + 1}, '
                f'the file has {len(points)}'
            )
        triangles += triangulate(polygon.vertices, [points[i] for i in polygon.vertices])
    vertices = np.array(points, dtype=np.float64).reshape(-1, 3)
    return vertices, np.array(triangles, dtype=np.int64).reshape(-1, 3)


def triangulate(names: list[int], corners: list[Point]) -> list[tuple[int, int, int]]:
    """Return the triangles of a plane polygon, with its orientation.

    Ears are clipped off (Meisters, American Mathematical Monthly 82(6), 1975); a convex polygon
    becomes a fan about its first corner. ``names`` are the indices of the corners in the result.
    """
    if len(names) == 3:
        return [(names[0], names[1], names[2])]
    flat = _projected(corners)
    loop = list(range(len(names)))
    notches = np.array([_turn(*_around(loop, k, flat)) <= 0.0 for k in loop])
    points, lost, triangles = np.array(flat), 0, []
    while len(loop) > 3 and lost <= _MOST_LOST and notches[loop].any():
        inward = points[notches]
        ears = (k for k in range(1, len(loop)) if _is_ear(_around(loop, k, flat), inward))
        ear = next(ears, 0)
        lost += ear == 0  # the polygon crosses itself, or has no area
        k = ear or 1
        triangles.append((loop[k - 1], loop[k], loop[(k + 1) % len(loop)]))
        notches[loop[k]] = False
        del loop[k]
        for beside in (k - 1, k % len(loop)):
            notches[loop[beside]] = _turn(*_around(loop, beside, flat)) <= 0.0
    triangles += [(loop[0], b, c) for b, c in itertools.pairwise(loop[1:])]
    return [(names[a], names[b], names[c]) for a, b, c in triangles]


def _statements(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and words of each statement, without comments and blank lines."""
    pending: list[str] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split('#', 1)[0].split()
        if words and words[-1].endswith('\\'):  # goes on in the next line
            pending += [*words[:-1], words[-1][:-1]]
            continue
        statement = [word for word in pending + words if word]
        pending = []
        if statement:
            yield number, statement
    if pending := [word for word in pending if word]:  # a last line that is continued by none
        yield number, pending


def _point(words: list[str], where: str) -> Point:
    """Return the coordinates of a vertex."""
    try:
        point = tuple(float(word) for word in words)
    except ValueError:
        point = ()
    if len(point) != 3 or not np.isfinite(point).all():
        raise MeshFileError(f'{where}: a vertex needs three finite numbers, given {words}')
    return point


def _corners(words: list[str], count: int, where: str) -> list[int]:
    """Return the vertices of a face, counted from 0, after ``count`` vertices were read."""
    if len(words) < 3:
        raise MeshFileError(f'{where}: a face needs at least three vertices, given {words}')
    corners = []
    for word in words:
        try:
            index = int(word.split('/', 1)[0])
        except ValueError:
            raise MeshFileError(f'{where}: {word!r} is not the index of a vertex') from None
        corner = index - 1 if index > 0 else count + index  # a negative one counts from the end
        if index == 0 or corner < 0:
            raise MeshFileError(
                f'{where}: there is no vertex {index}; {count} were given by then, from 1'
            )
        corners.append(corner)
    return corners


def _projected(corners: list[Point]) -> list[_Flat]:
    """Return the corners in the coordinate plane the polygon faces most, counter-clockwise."""
    points = np.array(corners)
    points -= points[0]
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)  # Newell
    k = int(np.argmax(np.abs(normal)))
    i, j = ((k + 1) % 3, (k + 2) % 3) if normal[k] >= 0.0 else ((k + 2) % 3, (k + 1) % 3)
    return [(point[i], point[j]) for point in points.tolist()]


def _around(loop: list[int], k: int, flat: list[_Flat]) -> tuple[_Flat, _Flat, _Flat]:
    """Return corner k of a loop between its neighbours."""
    return flat[loop[k - 1]], flat[loop[k]], flat[loop[(k + 1) % len(loop)]]


def _is_ear(corner: tuple[_Flat, _Flat, _Flat], inward: Floats) -> bool:
    """Return whether a corner can be cut off: it is convex, and no other corner is in it.

    If another corner is in it, so is one of the reflex corners ``inward`` (k, 2).
    """
    a, b, c = corner
    if _turn(a, b, c) <= 0.0:
        return False
    p = inward.T
    inside = (_turn(a, b, p) >= 0.0) & (_turn(b, c, p) >= 0.0) & (_turn(c, a, p) >= 0.0)
    return all(tuple(q) in corner for q in inward[inside].tolist())


def _turn(a: _Flat, b: _Flat, c: Any) -> Any:
    """Return twice the area of the triangle a b c, positive for a left turn; c may be many."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
