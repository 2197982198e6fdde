"""Outward orientation of surfaces, piece by piece; ambiguous ones are refused."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.tolerances import NO_VOLUME
from drake_geom_ros.geometry.errors import MeshFileError
from drake_geom_ros.geometry.meshes._library import connected_pieces
from drake_geom_ros.geometry.meshes._welding import closed_surface, merged
from drake_geom_ros.math.array_types import Floats, Indices

_SAMPLES = 32  # vertices of a piece that are tested for being inside another
# Winding number above which a vertex is inside: it is 1 inside another piece, 0 outside, and where
# both touch a fraction, which is small at a corner.
_WITHIN = 0.05


def turned_outward(vertices: Floats, triangles: Indices, name: str) -> tuple[Floats, Indices]:
    """Return a surface with each closed piece oriented outward, together with pieces inside it.

    So a cavity, a piece inside another with the opposite orientation, stays one. Triangles that
    share an edge with no third belong to one piece. An open piece is not changed. Raises
    MeshFileError if the only two triangles at an edge have opposite orientations.
    """
    try:
        clean = closed_surface(vertices, triangles, name)
        p_MVs, clear = clean.vertices, clean.triangles
    except MeshFileError:
        p_MVs, clear = merged(vertices, triangles)
        if not len(clear):
            return vertices, triangles
    piece_of = _pieces(p_MVs, clear, name)
    inverted = _inverted(p_MVs, clear, piece_of)
    if not inverted.any():
        return vertices, triangles
    turn = inverted[piece_of]
    return p_MVs, np.where(turn[:, None], clear[:, ::-1], clear)


def _pieces(vertices: Floats, triangles: Indices, name: str) -> Indices:
    """Return the piece (m,) of each triangle: neighbours at an edge of exactly two share one."""
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    low, high = edges.min(axis=1), edges.max(axis=1)
    _, at, counts = np.unique(low * len(vertices) + high, return_inverse=True, return_counts=True)
    order = np.argsort(at.ravel(), kind='stable')
    first, second = order[counts[at.ravel()[order]] == 2].reshape(-1, 2).T
    along = (edges[first] == edges[second]).all(axis=1)
    if along.any():
        ends = vertices[edges[first[along][0]]].tolist()
        raise MeshFileError(
            f'{name} has no outside: of its edges {int(along.sum())} have two triangles that run '
            f'the same way, such as that from {ends[0]} to {ends[1]}; turn one side of them around'
        )
    each = np.arange(len(triangles))
    pairs = np.vstack((np.column_stack((first, second)) // 3, np.column_stack((each, each))))
    piece_of = np.empty(len(triangles), dtype=np.int64)
    for k, rows in enumerate(connected_pieces(np.column_stack((pairs, pairs[:, 0])), len(each))):
        piece_of[pairs[rows].ravel()] = k
    return piece_of


def _inverted(vertices: Floats, triangles: Indices, piece_of: Indices) -> NDArray[np.bool_]:
    """Return the mask (k,) of pieces to reverse: the outermost one around them is inside out."""
    corners = vertices[triangles]
    origin, size = vertices.mean(axis=0), float(np.ptp(vertices, axis=0).max())
    a, b, c = np.moveaxis(corners - origin, 1, 0)
    volumes = np.bincount(piece_of, (np.cross(a, b) * c).sum(axis=1) / 6.0)
    volumes[_open(triangles, piece_of, len(volumes))] = 0.0
    closed = np.abs(volumes) > NO_VOLUME * size**3
    inverted = closed & (volumes < 0.0)
    if not inverted.any() or np.count_nonzero(closed) == 1:
        return inverted
    order = np.argsort(piece_of, kind='stable')
    pieces = np.split(corners[order], np.cumsum(np.bincount(piece_of))[:-1])
    lowest = np.array([piece.min(axis=(0, 1)) for piece in pieces])
    highest = np.array([piece.max(axis=(0, 1)) for piece in pieces])
    outermost = inverted.copy()
    largest_first = np.argsort(-np.abs(volumes), kind='stable')
    for k in np.flatnonzero(closed).tolist():
        around = closed & (np.abs(volumes) > abs(volumes[k]))
        around &= (lowest <= lowest[k]).all(axis=1) & (highest >= highest[k]).all(axis=1)
        for other in largest_first[around[largest_first]].tolist():
            if _goes_around(pieces[other], pieces[k].reshape(-1, 3)):
                outermost[k] = inverted[other]
                break
    return outermost


def _open(triangles: Indices, piece_of: Indices, count: int) -> Indices:
    """Return the open pieces, with an edge that no other edge of the piece matches."""
    edges = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    low, high = edges.min(axis=1), edges.max(axis=1)
    _, at = np.unique(low * (int(triangles.max()) + 1) + high, return_inverse=True)
    keys, at = np.unique(at.ravel() * count + np.repeat(piece_of, 3), return_inverse=True)
    balance = np.bincount(at.ravel(), np.where(edges[:, 0] == low, 1.0, -1.0))
    return np.unique(keys[balance != 0.0] % count)


def _goes_around(corners: Floats, points: Floats) -> bool:
    """Return whether a closed surface of triangles (m, 3, 3) encloses a piece's points (n, 3).

    Several points are tested, since a piece that it crosses has points on either side.
    """
    chosen = np.linspace(0, len(points) - 1, _SAMPLES).astype(np.int64)
    for point in points[np.unique(chosen)]:
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        # Van Oosterom & Strackee 1983.
        over = (np.cross(a, b) * c).sum(axis=1)
        under = la * lb * lc + (a * b).sum(axis=1) * lc
        under += (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
        if abs(np.arctan2(over, under).sum()) < _WITHIN * 2.0 * math.pi:
            return False
    return True
