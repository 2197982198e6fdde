"""Solids that are unions of lattice cells, and the truth about them in fractions.

Moved without a turn they are unions of boxes still, so how far they are apart, or between what how
deep they are, takes nothing but differences of the numbers that are given.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import Mesh, MeshData
from drake_geom_ros.math.array_types import Floats
from truth.bodies import grids
from truth.bodies.grids import Cell

SIDE = 3  # cells along each axis, at most
UNITS = (1.0, 1e-3, 0.3, 1e4)  # [m] of a cell
MAP = (5e5, 4e6, 300.0)  # units: vertices in map coordinates
NEIGHBOURS = [tuple(sign * row) for row in np.eye(3, dtype=int) for sign in (-1, 1)]

Span = tuple[Fraction, Fraction]
Box = tuple[Span, Span, Span]


class Lattice(NamedTuple):
    """A solid of cells, and what it is made from: lines (3, SIDE + 1) [m], vertices, triangles."""

    cells: tuple[Cell, ...]
    lines: Floats
    vertices: Floats
    triangles: tuple[tuple[int, ...], ...]
    about: str

    @property
    def mesh(self) -> Mesh:
        """The solid as a shape."""
        return Mesh.FromMeshData(MeshData(self.vertices, self.triangles))

    def boxes(self, p: Floats) -> list[Box]:
        """Return the cells as boxes, moved by p (3,) [m]."""
        return [self._box(cell, p) for cell in self.cells]

    def _box(self, cell: Cell, p: Floats) -> Box:
        line = [
            [Fraction(float(x)) + Fraction(float(p[k])) for x in self.lines[k]] for k in range(3)
        ]
        x, y, z = ((line[k][cell[k]], line[k][cell[k] + 1]) for k in range(3))
        return x, y, z

    def walls(self) -> list[Box]:
        """Return the sides of cells that are the surface, as boxes without thickness."""
        found = []
        for cell in self.cells:
            box = self._box(cell, np.zeros(3))
            for axis, side in itertools.product(range(3), (0, 1)):
                beside = list(cell)
                beside[axis] += 2 * side - 1
                if tuple(beside) not in self.cells:
                    x, y, z = (
                        (box[k][side], box[k][side]) if k == axis else box[k] for k in range(3)
                    )
                    found.append((x, y, z))
        return found

    def signed_distance(self, q: Floats) -> float:
        """Return the signed distance [m] of a point from the surface."""
        point = [(Fraction(float(x)),) * 2 for x in q]
        squared = min(_squared(wall, point) for wall in self.walls())
        inside = any(_squared(box, point) == 0 for box in self.boxes(np.zeros(3)))
        return (-1.0 if inside else 1.0) * _root(squared)


def random_lattice(rng: np.random.Generator) -> Lattice:
    """Return a connected solid: plain, in map coordinates, with walls cut, or with T-junctions."""
    cells = {(0, 0, 0)}
    for _ in range(int(rng.integers(1, 9))):
        cell = list(cells)[rng.integers(len(cells))]
        beside = tuple(np.add(cell, NEIGHBOURS[rng.integers(6)]).tolist())
        if min(beside) >= 0 and max(beside) < SIDE:
            cells.add(beside)
    unit, mapped = float(rng.choice(UNITS)), bool(rng.random() < 0.3)
    lines = unit * (
        np.arange(SIDE + 1.0) + (np.array(MAP)[:, None] if mapped else np.zeros((3, 1)))
    )
    cuts = int(rng.choice([1, 1, 2]))
    vertices, triangles = grids.surface(sorted(cells), list(lines), cuts)
    points, about = np.array(vertices), f'unit {unit:g}' + (', map' if mapped else '')
    if rng.random() < 0.3:
        about += ', T-junctions'
        for _ in range(int(rng.integers(1, 4))):
            points, triangles = with_junction(rng, points, triangles)
    return Lattice(tuple(sorted(cells)), lines, points, tuple(map(tuple, triangles)), about)


def with_junction(
    rng: np.random.Generator, vertices: Floats, triangles: list[tuple[int, ...]]
) -> tuple[Floats, list[tuple[int, ...]]]:
    """Return a mesh in which a triangle is cut at the middle of a side, and its neighbour is not.

    A triangle without area closes the gap.
    """
    k = int(rng.integers(len(triangles)))
    a, b, c = np.roll(triangles[k], int(rng.integers(3))).tolist()
    m = len(vertices)
    middle = 0.5 * (vertices[a] + vertices[b])
    cut = [(a, m, c), (m, b, c), (a, b, m)]
    return np.vstack((vertices, middle)), [*triangles[:k], *cut, *triangles[k + 1 :]]


def _gap(a: Box, b: Box, axis: int) -> Fraction:
    """Return how far two boxes are apart along an axis; negative where they overlap."""
    return max(b[axis][0] - a[axis][1], a[axis][0] - b[axis][1])


def _squared(a: Box, b: Box) -> Fraction:
    return sum((max(_gap(a, b, k), Fraction(0)) ** 2 for k in range(3)), Fraction(0))


def _root(squared: Fraction) -> float:
    """Return a square root, right to the last digits, of any size."""
    if squared == 0:
        return 0.0
    power = (squared.numerator.bit_length() - squared.denominator.bit_length()) // 2
    scaled = squared / Fraction(4) ** power
    return math.ldexp(math.sqrt(scaled), power)


def truth(a: list[Box], b: list[Box]) -> tuple[float, float]:
    """Return between what the signed distance [m] of two unions of boxes is.

    Apart it is known. Overlapping, each two boxes that do must be parted; and the moves along the
    axes that part all of them are ways out.
    """
    squared = min(_squared(x, y) for x, y in itertools.product(a, b))
    if squared > 0:
        return (_root(squared),) * 2
    depth = max(min(-_gap(x, y, k) for k in range(3)) for x, y in itertools.product(a, b))
    if depth <= 0:
        return 0.0, 0.0
    ways = [_way_out(a, b, axis, side) for axis in range(3) for side in (0, 1)]
    return -float(min(ways)), -float(depth)


def _way_out(a: list[Box], b: list[Box], axis: int, side: int) -> Fraction:
    """Return how far b must move along an axis, up or down, until it is beyond all of a."""
    others = [k for k in range(3) if k != axis]
    found = Fraction(0)
    for x, y in itertools.product(a, b):
        if all(_gap(x, y, k) < 0 for k in others):
            far = x[axis][1] - y[axis][0] if side else y[axis][1] - x[axis][0]
            found = max(found, far)
    return found
