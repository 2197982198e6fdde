"""Solids that are unions of boxes: what is known of them from the kernels of convex pairs alone.

The distance from a union is the least of those from its parts. A body that overlaps must move at
least as far as the deepest part asks for, and is out when every part is apart.
"""

import functools
from dataclasses import dataclass

import numpy as np

from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels import calling
from drake_geom_ros.geometry._proximity.pair_table import ALL_ROWS, BOX, ROW_OF_TYPES, TYPE_COUNT
from drake_geom_ros.geometry._solid_mesh import solid_of

# Outlines on the unit grid, as the cells that they cover; each is extruded by one unit along z.
CELLS = {
    'L': [(0, 0), (1, 0), (0, 1)],
    'U': [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1)],
    'ring': [(x, y) for x in range(3) for y in range(3) if (x, y) != (1, 1)],
}
# The same as few boxes: lower corner, upper corner.
PARTS = {
    'L': [((0, 0, 0), (2, 1, 1)), ((0, 0, 0), (1, 2, 1))],
    'U': [((0, 0, 0), (3, 1, 1)), ((0, 0, 0), (1, 2, 1)), ((2, 0, 0), (3, 2, 1))],
    'ring': [
        ((0, 0, 0), (3, 1, 1)),
        ((0, 2, 0), (3, 3, 1)),
        ((0, 0, 0), (1, 3, 1)),
        ((2, 0, 0), (3, 3, 1)),
    ],
}


@dataclass(frozen=True)
class Body:
    """A shape at its pose: one kernel shape, or a solid with the boxes that it is made of."""

    kind: int
    parameters: np.ndarray
    R: np.ndarray
    p: np.ndarray
    boxes: tuple = ()  # (half sizes, middle in the body) of each part of a solid

    def parts(self):
        """The convex bodies whose union this is."""
        if not self.boxes:
            return [self]
        return [Body(BOX, half, self.R, self.p + self.R @ middle) for half, middle in self.boxes]

    def moved(self, t):
        return Body(self.kind, self.parameters, self.R, self.p + t, self.boxes)

    def turned(self, R):
        return Body(self.kind, self.parameters, R @ self.R, R @ self.p, self.boxes)


def surface_of(name, cuts=1):
    """The triangles of a union of unit cells, each side cut into ``cuts`` by ``cuts`` squares."""
    cells = {(x, y, 0) for x, y in CELLS[name]}
    vertices, triangles = [], []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                beside = np.array(cell)
                beside[axis] += 2 * side - 1
                if tuple(beside) in cells:
                    continue
                u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
                corner = np.array(cell, dtype=float) + side * np.eye(3)[axis]
                for i in range(cuts):
                    for j in range(cuts):
                        at = len(vertices)
                        square = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                        vertices += [corner + a / cuts * u + b / cuts * v for a, b in square]
                        quad = [at, at + 1, at + 2, at + 3]
                        quad = quad if side else quad[::-1]
                        triangles += [quad[:3], [quad[0], quad[2], quad[3]]]
    return MeshData(vertices, triangles)


@functools.cache
def _parameters(name, scale, cuts):
    return solid_of(surface_of(name, cuts), (scale, scale, scale))


def solid(name, R, p, scale=1.0, cuts=1):
    """A solid at a pose, its corner at p."""
    kind, parameters = _parameters(name, scale, cuts)
    boxes = tuple(
        (0.5 * scale * (np.array(b) - a), 0.5 * scale * np.add(a, b)) for a, b in PARTS[name]
    )
    return Body(kind, parameters, np.asarray(R), np.asarray(p, dtype=float), boxes)


def row_of(A, B, tolerance=1e-9, cutoff=np.inf, hint=(0.0, 0.0, 0.0)):
    """The result row of a pair, the lower type first."""
    row = ALL_ROWS[ROW_OF_TYPES[A.kind * TYPE_COUNT + B.kind]]
    out = np.zeros(calling.PAIR_WIDTH)
    out[calling.NORMAL : calling.NORMAL + 3] = hint
    row.load_kernel()(
        A.kind, A.parameters, np.ascontiguousarray(A.R),
        B.kind, B.parameters, np.ascontiguousarray(B.R),
        B.p - A.p, tolerance, cutoff, out,
    )  # fmt: skip
    return out


def parts_gap(A, B):
    """The least signed distance of the parts, and how far off it may be.

    Positive: the distance of A and B. Negative: they must move at least that far apart.
    """
    least, error = np.inf, 0.0
    for a in A.parts():
        for b in B.parts():
            low, high = (a, b) if a.kind <= b.kind else (b, a)
            out = row_of(low, high)
            if out[calling.DISTANCE] < least:
                least, error = out[calling.DISTANCE], out[calling.ERROR_BOUND]
    return least, error
