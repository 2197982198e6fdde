"""Polygons, strips and fans as triangles, since trimesh cuts each polygon into a fan."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.math.array_types import Floats, Indices

Point = tuple[float, ...]
_Flat = tuple[float, float]

# Corners of a polygon that are cut off though none is an ear; the remainder becomes a fan.
_MOST_LOST = 100


class CutFaces(NamedTuple):
    """Triangles (m, 3), and the face (m,) that each is a part of."""

    triangles: Indices
    faces: Indices


def cut_faces(corners: Indices, counts: Indices, vertices: Floats) -> CutFaces:
    """Return the triangles of faces, whose ``counts`` corners follow one another in ``corners``.

    Raises ValueError for an index of no vertex, and for a face of less than three corners.
    """
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(vertices):
        raise ValueError(f'a face has the vertex {corners.max()}; there are {len(vertices)}')
    if (counts == 3).all():
        return CutFaces(corners.reshape(-1, 3), np.arange(len(counts)))
    triangles: list[tuple[int, int, int]] = []
    faces: list[int] = []
    ends = np.cumsum(counts).tolist()
    for face, (end, count) in enumerate(zip(ends, counts.tolist(), strict=True)):
        if count < 3:
            raise ValueError(f'face {face} has {count} corners')
        names = corners[end - count : end].tolist()
        x, y, z = vertices[names].T.tolist()
        made = triangulate(names, list(zip(x, y, z, strict=True)))
        triangles += made
        faces += [face] * len(made)
    rows = np.array(triangles, dtype=np.int64).reshape(-1, 3)
    return CutFaces(rows, np.array(faces, dtype=np.int64))


def strip(order: Indices) -> Indices:
    """Return the triangles (m, 3) of a strip through vertices."""
    triangles = np.column_stack((order[:-2], order[1:-1], order[2:]))
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles


def fan(order: Indices) -> Indices:
    """Return the triangles (m, 3) of a fan about its first vertex."""
    hub = np.broadcast_to(order[:1], len(order[2:]))
    return np.column_stack((hub, order[1:-1], order[2:]))


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
