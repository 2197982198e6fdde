"""Solids that are unions of boxes: what is known of them from the kernels of convex pairs alone.

The distance from a union is the least of those from its parts. A body that overlaps must move at
least as far as the deepest part asks for, and is out when every part is apart.
"""

import functools
from dataclasses import dataclass

import numpy as np

from drake_geom_ros.evidence import grids
from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kinds import BOX
from drake_geom_ros.geometry._proximity.pair_table import ALL_ROWS, ROW_OF_TYPES, TYPE_COUNT
from drake_geom_ros.geometry._solid_mesh import solid_of

CELLS = {'L': grids.L, 'U': grids.U, 'ring': grids.RING}


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
    """The surface of a union of unit cells, each side cut into ``cuts`` by ``cuts`` squares."""
    return MeshData(*grids.surface(CELLS[name], cuts=cuts))


@functools.cache
def _parameters(name, scale, cuts):
    return solid_of(surface_of(name, cuts), (scale, scale, scale))


def solid(name, R, p, scale=1.0, cuts=1):
    """A solid at a pose, its corner at p."""
    kind, parameters = _parameters(name, scale, cuts)
    boxes = tuple(
        (0.5 * scale * np.array(box.size), scale * box.p) for box in grids.boxes(CELLS[name])
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
