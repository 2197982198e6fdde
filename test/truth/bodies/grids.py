"""Solids with dents: unions of the cells of a grid, whose lines may lie anywhere.

However finely the faces are cut, the body is the same, and boxes tell the truth about it.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence

import numpy as np

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.math.array_types import Floats

Cell = tuple[int, int, int]
Lines = Sequence[Floats]  # along x, y, z [m]

SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))
INTEGERS: Lines = [np.arange(8.0)] * 3


def flat(*outline: str) -> list[Cell]:
    """Return the cells of an outline, rows of `#` from y = 0 on, of one layer."""
    return [(x, y, 0) for y, row in enumerate(outline) for x, c in enumerate(row) if c == '#']


CUBE: list[Cell] = [(0, 0, 0)]
L = flat('##', '#.')
U = flat('###', '#.#')
RING = flat('###', '#.#', '###')
FRAME = flat('#####', '#...#', '#...#', '#...#', '#####')
CORNER = [cell for cell in np.ndindex(2, 2, 2) if cell != (1, 1, 1)]
HOLLOW = [cell for cell in np.ndindex(3, 3, 3) if cell != (1, 1, 1)]


def surface(
    cells: Collection[Cell], lines: Lines = INTEGERS, cuts: int = 1
) -> tuple[list[tuple[float, ...]], list[tuple[int, ...]]]:
    """Return vertices (n, 3) [m] and triangles (m, 3) of a union of cells.

    Vertices are shared; triangles run counter-clockwise from outside. Each face of a cell is cut
    into ``cuts`` by ``cuts`` squares.
    """
    cells, numbers, triangles = set(cells), dict[tuple[int, ...], int](), []
    for cell, axis, side in itertools.product(sorted(cells), range(3), (0, 1)):
        beside = list(cell)
        beside[axis] += 2 * side - 1
        if tuple(beside) in cells:
            continue
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for i, j in np.ndindex(cuts, cuts):
            quad = []
            for du, dv in SQUARE if side else SQUARE[::-1]:
                at = [cuts * c for c in cell]
                at[axis] += cuts * side
                at[u] += i + du
                at[v] += j + dv
                quad.append(numbers.setdefault(tuple(at), len(numbers)))
            triangles += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    fine = [np.interp(np.arange(len(x) * cuts) / cuts, range(len(x)), x) for x in lines]
    vertices = [tuple(float(fine[k][at[k]]) for k in range(3)) for at in numbers]
    return vertices, triangles


def boxes(cells: Collection[Cell], lines: Lines = INTEGERS) -> tuple[Body, ...]:
    """Return the largest boxes in a union of cells: it is theirs, and none is in another one."""
    cells = set(cells)
    most = np.max(list(cells), axis=0) + 1
    spans = [list(itertools.combinations(range(n + 1), 2)) for n in most]
    full = [
        box
        for box in itertools.product(*spans)
        if cells.issuperset(itertools.product(*(range(*span) for span in box)))
    ]
    largest = [box for box in full if not any(_within(box, other) for other in full)]
    found = []
    for box in largest:
        low, high = (np.array([lines[k][box[k][end]] for k in range(3)]) for end in (0, 1))
        found.append(Body('Box', tuple((high - low).tolist()), p=0.5 * (low + high)))
    return tuple(found)


def _within(
    box: tuple[tuple[int, ...], ...],
    other: tuple[tuple[int, ...], ...],
) -> bool:
    """Return whether a box is a part of another one."""
    inside = all(o[0] <= b[0] and b[1] <= o[1] for b, o in zip(box, other, strict=True))
    return inside and box != other


def solid(
    cells: Collection[Cell], lines: Lines = INTEGERS, *, cuts: int = 1, scale: float = 1.0
) -> Body:
    """Return the union of cells as a body, ``scale`` times as large."""
    scaled = [scale * line for line in lines]
    vertices, triangles = surface(cells, scaled, cuts)
    return Body('Solid', tuple(vertices), triangles=tuple(triangles), parts=boxes(cells, scaled))
