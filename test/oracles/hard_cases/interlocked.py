"""Solids in one another to the last bits: slots, sheets, walls in line, junctions, polycubes.

Lengths are sums of powers of two or of whole metres, so what is drawn is what floats hold. Of
polycubes the depth is the least of all places of the lattice.
"""

import itertools

import numpy as np
from oracles.hard_cases.construct import body, case, placing

from drake_geom_ros.cross_check.bodies import Body
from truth.bodies.grids import L, flat, surface

X = np.eye(3)[0]
CELLS = [np.arange(9.0)] * 3
CAP_AND_STEM = [(0, 1, 0), (1, 1, 0), (2, 1, 0), (1, 0, 0)]
SLOT = flat('###', '#.#')
MAP = np.array([2.0**19, 2.0**22, 0.0])
LITTLE = 2.0**-28


def of_cells(cells, lines, origin=(0.0, 0.0, 0.0)):
    """Return cells between lines as a solid whose vertices are measured from an origin."""
    lines = [np.asarray(x, dtype=float) + o for x, o in zip(lines, origin, strict=True)]
    vertices, triangles = surface([tuple(cell) for cell in cells], lines)
    return Body('Solid', vertices, triangles=triangles)


def known(about, a, b, distance):
    return case(about, a, b, distance, placing(a, b, X))


def interlocked(rng):
    """Yield the cases of all parts."""
    parts = slots(), sheets(), walls_in_line(), junctions(), polycubes(rng)
    for row in itertools.chain(*parts):
        yield known(*row)


def slots():
    """A T whose stem is in the slot of a U, down to its floor: too wide, it has to go up."""
    wall = of_cells(SLOT, CELLS)
    for more in (2.0**-30, 2.0**-20, 2.0**-10, 0.0):
        lines = [[0.5, 1.0, 2.0 + more, 2.5 + more], [1.0, 2.0, 2.5], [0.0, 1.0]]
        yield (
            f'a T too wide for its slot by {more:g}',
            of_cells(CAP_AND_STEM, lines),
            wall,
            (-1.0 if more else 0.0),
        )
        block = body('Box', (1.0 + more, 1.0, 1.0), None, (1.5 + 0.5 * more, 1.5, 0.5))
        yield f'a box too wide for its slot by {more:g}', block, wall, -1.0 if more else 0.0
    lines = [[0.5, 1.0 + LITTLE, 2.0 - LITTLE, 2.5], [1.0 + LITTLE, 2.0, 2.5], [0.0, 1.0]]
    yield 'a T that has a little room', of_cells(CAP_AND_STEM, lines), wall, 0.0


def sheets():
    """A sheet that fills its slot, and one that is in the wall beside it."""
    for thin in (2.0**-29, 2.0**-20, 2.0**-7):
        lines = [[0.0, 1.0, 1.0 + thin, 2.0 + thin], [0.0, 1.0, 2.0], [0.0, 1.0]]
        other = [[0.5, 1.0, 1.0 + thin, 1.5 + thin], [1.0, 2.0, 2.5], [0.0, 1.0]]
        fits = of_cells(CAP_AND_STEM, other)
        yield f'a sheet of {thin:g} fills its slot', fits, of_cells(SLOT, lines), 0.0
    thin = 2.0**-7
    lines = [[0.0, 1.0, 1.0 + thin, 2.0 + thin], [0.0, 1.0, 2.0], [0.0, 1.0]]
    other = [[0.5, 1.0, 1.0 + thin, 1.5 + thin], [1.0, 2.0, 2.5], [0.0, 1.0]]
    fits, slot = of_cells(CAP_AND_STEM, other, MAP), of_cells(SLOT, lines, MAP)
    yield 'a sheet of 8 mm fills its slot, in map coordinates', fits, slot, 0.0


def walls_in_line():
    """Prisms of which all walls but those that cross are in line."""
    one = of_cells(L, CELLS)
    for axis, side in itertools.product(range(3), (1.0, -1.0)):
        step = np.zeros(3)
        step[axis] = side * ((2.0 if axis < 2 else 1.0) - LITTLE)
        yield f'an L in line with an L, axis {axis}, {side:+g}', one.at(step), one, -LITTLE
    lines = [2.0 * x for x in CELLS]
    one = of_cells(L, lines, MAP)
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = (4.0 if axis < 2 else 2.0) - 2.0**-7
        yield f'the same in map coordinates, axis {axis}', one.at(step), one, -(2.0**-7)


def junctions():
    """Cubes that touch an L, of which each edge of a wall ends in another's: no area closes it."""
    vertices, triangles = (np.array(x).tolist() for x in surface(L, CELLS))
    for t in list(triangles[:4]):
        a, b, c = t
        triangles += [[a, len(vertices), c], [len(vertices), b, c], [a, b, len(vertices)]]
        triangles.remove(t)
        vertices.append(np.mean([vertices[a], vertices[b]], axis=0).tolist())
    wall = Body('Solid', vertices, triangles=triangles)
    for at in ([1.0, 1.0, 0.0], [1.0, 1.0, 0.5], [0.25, 0.25, 1.0], [2.0, 0.0, 0.0]):
        block = body('Box', (1.0, 1.0, 1.0), None, np.array(at) + 0.5)
        yield f'a box beside junctions, at {at}', block, wall, 0.0
    into = body('Box', (1.0, 1.0, 1.0), None, (1.5 - LITTLE, 1.5, 0.5))
    yield 'a box a little in a wall with junctions', into, wall, -LITTLE


def polycubes(rng):
    """Random ones that overlap."""
    count = 0
    while count < 13:
        mine, its = polycube(rng, 3, 6), polycube(rng, 3, 8)
        p = rng.integers(-16, 17, 3) / 8.0
        depth = depth_of(mine, its, p)
        if depth > 0.0:
            count += 1
            yield f'polycubes {count}', of_cells(mine, CELLS).at(p), of_cells(its, CELLS), -depth


def polycube(rng, n, count):
    """Return connected cells of a lattice, more than a row of them."""
    cells = {(n // 2,) * 3, (n // 2 + 1, n // 2, n // 2), (n // 2, n // 2 + 1, n // 2)}
    while len(cells) < count:
        near = list(sorted(cells)[rng.integers(len(cells))])
        near[rng.integers(3)] += int(rng.choice([-1, 1]))
        if all(0 <= x < n for x in near):
            cells.add(tuple(near))
    return sorted(cells)


def depth_of(mine, its, p):
    """Return how far cells moved by p have to go at least to be out of others."""
    low = np.unique([np.subtract(b, a) for a in mine for b in its], axis=0)
    lines = [np.unique(np.concatenate((low[:, k] - 1, low[:, k] + 1, [p[k]]))) for k in range(3)]
    places = np.stack(np.meshgrid(*lines, indexing='ij'), -1).reshape(-1, 3)
    inside = (np.abs(low - places[:, None]) < 1.0).all(axis=2).any(axis=1)
    return float(np.linalg.norm(places[~inside] - p, axis=1).min())
