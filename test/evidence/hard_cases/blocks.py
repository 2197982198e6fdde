"""Solids with dents as triangles: unions of the cells of a grid, whose lines may lie anywhere."""

import itertools

import numpy as np
from evidence.hard_cases.construct import body

SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))


def surface(cells, lines):
    """Return vertices and triangles of a union of cells (i, j, k) between lines along x, y, z.

    Vertices are shared; triangles run counter-clockwise from outside.
    """
    cells, numbers, triangles = set(cells), {}, []
    for cell, axis, side in itertools.product(sorted(cells), range(3), (0, 1)):
        beside = list(cell)
        beside[axis] += 2 * side - 1
        if tuple(beside) in cells:
            continue
        u, v = (axis + 1) % 3, (axis + 2) % 3
        quad = []
        for du, dv in SQUARE if side else SQUARE[::-1]:
            at = list(cell)
            at[axis] += side
            at[u] += du
            at[v] += dv
            quad.append(numbers.setdefault(tuple(at), len(numbers)))
        triangles += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    vertices = [tuple(float(lines[k][at[k]]) for k in range(3)) for at in numbers]
    return vertices, triangles


def solid(cells, lines=None, R=None, p=(0.0, 0.0, 0.0), scale=1.0):
    """Return the union of cells as a body; without lines these are the integers."""
    lines = lines or [np.arange(8.0)] * 3
    vertices, triangles = surface(cells, lines)
    return of_triangles([tuple(scale * x for x in v) for v in vertices], triangles, R, p)


def of_triangles(vertices, triangles, R=None, p=(0.0, 0.0, 0.0)):
    """Return a body of vertices and triangles."""
    made = body('Solid', vertices, R, p)
    return type(made)('Solid', made.size, made.R, made.p, tuple(map(tuple, triangles)))


def flat(outline):
    """Return the cells of an outline, rows of `#` from y = 0 on, of one layer."""
    return [(x, y, 0) for y, row in enumerate(outline) for x, c in enumerate(row) if c == '#']


CUBE = [(0, 0, 0)]
L = flat(('##', '#.'))
U = flat(('###', '#.#'))
RING = flat(('###', '#.#', '###'))
FRAME = flat(('#####', '#...#', '#...#', '#...#', '#####'))
CORNER = [cell for cell in itertools.product(range(2), repeat=3) if cell != (1, 1, 1)]
HOLLOW = [cell for cell in itertools.product(range(3), repeat=3) if cell != (1, 1, 1)]
