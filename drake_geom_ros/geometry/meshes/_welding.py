"""Closes surfaces: merges vertices in one place and, if necessary, welds nearly equal ones.

Exporters that write rounded numbers, or numbers of several bodies, leave equal vertices a last
digit apart, and each edge between them is open. If an open surface is closed after vertices within
a hundred-millionth of its size are welded, they are welded, with a remark.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.errors import MeshFileError
from drake_geom_ros.geometry.meshes._library import near_one_another
from drake_geom_ros.geometry.tolerances import WELDED_APART
from drake_geom_ros.math.array_types import Floats, Indices

ADVICE = "without the property ('mesh', 'solid') a mesh counts as its convex hull"


class ClosedSurface(NamedTuple):
    """Vertices (n, 3) [m] and triangles (m, 3) with every edge matched by another.

    ``welded`` is the number of vertices moved onto others, by at most ``farthest`` [m].
    """

    vertices: Floats
    triangles: Indices
    welded: int = 0
    farthest: float = 0.0

    def remarks(self) -> tuple[str, ...]:
        """Return descriptions of the changes."""
        if not self.welded:
            return ()
        return (
            f'{self.welded} of its vertices were welded to others, at most {self.farthest:.2g} m '
            'away: only so is its surface closed',
        )


def closed_surface(vertices: Floats, triangles: Indices, name: str) -> ClosedSurface:
    """Return the closed surface of a mesh; raises MeshFileError if it has none."""
    surface = ClosedSurface(*merged(vertices, triangles))
    try:
        check_closed(surface.triangles, name)
    except MeshFileError:
        surface = _welded(surface)
        if not surface.welded or not _is_closed(surface.triangles):
            raise
    return surface


def _is_closed(triangles: Indices) -> bool:
    try:
        check_closed(triangles, '')
    except MeshFileError:
        return False
    return True


def _welded(surface: ClosedSurface) -> ClosedSurface:
    """Return a surface with nearly equal vertices moved onto the first of them.

    A row of vertices, each near the next, could collapse over any distance. So nothing is welded
    if a vertex would move farther than the tolerance between neighbours.
    """
    vertices = surface.vertices
    apart = WELDED_APART * float(np.ptp(vertices, axis=0).max(initial=0.0))
    first = np.arange(len(vertices))
    for group in near_one_another(vertices, apart):
        first[group] = group.min()  # merged vertices are in ascending order
    moves = np.linalg.norm(vertices - vertices[first], axis=1)
    farthest = float(moves.max(initial=0.0))
    if farthest > 2.0 * apart:
        return surface
    moved = merged(vertices[first], surface.triangles)
    return ClosedSurface(*moved, int(np.count_nonzero(moves)), farthest)


def merged(vertices: Floats, triangles: Indices) -> tuple[Floats, Indices]:
    """Return a mesh without duplicate vertices, and without triangles with two equal corners."""
    rows = vertices + 0.0  # -0.0 is 0.0
    order = np.lexsort(rows.T)
    fresh = np.ones(len(rows), dtype=np.bool_)
    fresh[1:] = (np.diff(rows[order], axis=0) != 0.0).any(axis=1)
    names = np.empty(len(rows), dtype=np.int64)
    names[order] = np.cumsum(fresh) - 1
    triangles = names[triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    return rows[order[fresh]], without_walls(triangles)


def without_walls(triangles: Indices) -> Indices:
    """Return the triangles without pairs that lie back to back, as a wall between two bodies."""
    corners = np.sort(triangles, axis=1)
    order = np.lexsort(corners.T)
    fresh = np.ones(len(triangles), dtype=np.bool_)
    fresh[1:] = (np.diff(corners[order], axis=0) != 0).any(axis=1)
    of = np.empty(len(triangles), dtype=np.int64)
    of[order] = np.cumsum(fresh) - 1
    a, b, c = triangles.T
    turn = np.where((a < b) ^ (b < c) ^ (c < a), 1.0, -1.0)
    alone = (np.bincount(of) != 2) | (np.bincount(of, turn) != 0.0)
    remaining: Indices = triangles[alone[of]]
    return remaining


def check_closed(triangles: Indices, name: str) -> None:
    """Raise MeshFileError unless every edge is matched by one in the opposite direction."""
    if len(triangles) == 0:
        raise MeshFileError(f'{name}: no triangles, so it bounds no solid')
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    codes = edges.min(axis=1) * (int(triangles.max()) + 1) + edges.max(axis=1)
    _, at, counts = np.unique(codes, return_inverse=True, return_counts=True)
    balance = np.bincount(at.ravel(), np.where(edges[:, 0] < edges[:, 1], 1.0, -1.0))
    unmatched = balance != 0.0
    if not unmatched.any():
        return
    opened = int((unmatched & (counts == 1)).sum())
    along = int((unmatched & (counts == 2)).sum())
    crowded = int((unmatched & (counts > 2)).sum())
    raise MeshFileError(
        f'{name} bounds no solid: of its edges {opened} are open (one triangle only: close the '
        f'holes), {along} have two triangles that run the same way (turn one side of them '
        f'around), {crowded} have three or more that do not pair up. {ADVICE}'
    )
