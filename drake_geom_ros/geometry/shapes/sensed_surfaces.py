"""Triangles of sensed maps, for drawing: the faces of cells, and balls as polyhedra."""

from __future__ import annotations

import itertools

import numpy as np

from drake_geom_ros.geometry._proximity.tolerances import ON_GRID
from drake_geom_ros.math.array_types import Floats, Indices

_FEW = 10_000  # balls that are drawn with 32 triangles each; of more with 8
_SIDES = [np.array(s) * np.eye(3, dtype=np.int64)[k] for k in range(3) for s in (1, -1)]


def surface_of_balls(positions: Floats, radius: float) -> tuple[Floats, Indices]:
    """Return vertices (n, 3) [m] and triangles (m, 3), from outside, of polyhedra in balls."""
    corners, triangles = _ball(len(positions) <= _FEW)
    return _copies(positions, radius * corners, triangles)


def _copies(centres: Floats, corners: Floats, triangles: Indices) -> tuple[Floats, Indices]:
    """Return one polyhedron at each of the centres (n, 3)."""
    vertices = (centres[:, None] + corners).reshape(-1, 3)
    firsts = len(corners) * np.arange(len(centres))
    return vertices, (firsts[:, None, None] + triangles).reshape(-1, 3)


def _ball(fine: bool) -> tuple[Floats, Indices]:
    """Return an octahedron in the unit ball, or one whose triangles are cut in four."""
    corners = np.array(_SIDES, dtype=np.float64)
    signs = list(itertools.product((0, 1), repeat=3))
    # Corner 2 k + s is at +1 or -1 of axis k; an odd number of -1 turns the triangle around.
    triangles = np.array(
        [(a, 2 + b, 4 + c) if (a + b + c) % 2 == 0 else (a, 4 + c, 2 + b) for a, b, c in signs]
    )
    if not fine:
        return corners, triangles
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    unique, of = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    middles = corners[unique].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    ab, bc, ca = (len(corners) + of.reshape(-1, 3)).T
    a, b, c = triangles.T
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    finer = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.vstack((corners, middles)), finer


def surface_of_cells(centres: Floats, edge: float) -> tuple[Floats, Indices]:
    """Return vertices (n, 3) [m] and triangles (m, 3), from outside, of the faces of cubes.

    If the cubes lie on one grid, faces that two of them share are left out, and shared corners
    have identical coordinates, so that no ray passes between two faces.
    """
    cells, half = _cells_of_one_grid(centres, edge), 0.5 * edge
    if cells is None:
        faces = [centres[:, None] + half * _square(side) for side in _SIDES]
    else:
        # From integers: computed from their centres, shared corners would differ by rounding.
        numbers = _number(cells)
        bare = [~np.isin(_number(cells + side), numbers, assume_unique=True) for side in _SIDES]
        faces = [
            centres[0] + half * (2.0 * cells[shown][:, None] + _square(side))
            for shown, side in zip(bare, _SIDES, strict=True)
        ]
    corners = np.concatenate(faces).reshape(-1, 3)
    firsts = 4 * np.arange(len(corners) // 4)[:, None, None]
    return corners, (firsts + np.array([(0, 1, 2), (0, 2, 3)])).reshape(-1, 3)


def _cells_of_one_grid(centres: Floats, edge: float) -> Indices | None:
    """Return offsets [edges] (n, 3) of distinct cubes from the first; None if not on one grid."""
    if not len(centres):
        return None
    places = (centres - centres[0]) / edge
    cells = np.rint(places)
    if not (np.abs(places - cells) <= ON_GRID).all() or not np.abs(cells).max() < 2**20:
        return None
    keys: Indices = cells.astype(np.int64)
    return keys[np.unique(_number(keys), return_index=True)[1]]


def _square(side: Indices) -> Indices:
    """Return the corners (4, 3) of a side of a cube [half edges], counter-clockwise outside."""
    k = int(np.argmax(np.abs(side)))
    u, v = np.roll(np.eye(3, dtype=np.int64), -k - 1, axis=0)[:2]
    if side[k] < 0:
        u, v = v, u
    corners: Indices = side + np.array([-u - v, u - v, u + v, v - u])
    return corners


def _number(cells: Indices) -> Indices:
    """Return a unique number for each cell (n, 3) of a grid with indices below 2^20 - 1."""
    numbers: Indices = ((cells + 2**20) * np.array([1, 2**21, 2**42])).sum(axis=1)
    return numbers
