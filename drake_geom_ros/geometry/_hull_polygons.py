"""The faces of a convex hull as polygons: its triangles, united where they lie in one plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.tolerances import COPLANAR, EPS

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def united(vertices: Floats, triangles: Indices) -> list[list[int]]:
    """Return the polygons, counter-clockwise from outside, that triangles (m, 3) of a hull make.

    A face is what can be reached from a triangle without leaving its plane by more than rounding.
    """
    noise = COPLANAR * EPS * float(np.ptp(vertices, axis=0).max())
    edges = {
        (int(row[i]), int(row[i - 2])): k for k, row in enumerate(triangles) for i in range(3)
    }
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    free = np.ones(len(triangles), dtype=np.bool_)
    polygons = []
    # From the largest triangle on, whose plane is known best.
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    for seed in np.argsort(-areas, kind='stable').tolist():
        if free[seed]:
            rises = np.abs((vertices - a[seed]) @ normals[seed])
            face = _reached(seed, triangles, edges, rises <= noise, free)
            polygons.append(_around(face, triangles))
    return polygons


def _reached(
    seed: int,
    triangles: Indices,
    edges: dict[tuple[int, int], int],
    level: NDArray[np.bool_],
    free: NDArray[np.bool_],
) -> list[int]:
    """Return the free triangles of level vertices that hang together with one; take them."""
    face = [seed]
    free[seed] = False
    for k in face:
        corners = triangles[k].tolist()
        for i in range(3):
            beyond = edges[corners[i - 2], corners[i]]
            if free[beyond] and level[triangles[beyond]].all():
                free[beyond] = False
                face.append(beyond)
    return face


def _around(face: list[int], triangles: Indices) -> list[int]:
    """Return the vertices around triangles that hang together, in their sense of turning."""
    corners = triangles[face].tolist()
    sides = {(row[i], row[i - 2]) for row in corners for i in range(3)}
    following = {start: end for start, end in sides if (end, start) not in sides}
    loop = [min(following)]
    while (vertex := following[loop[-1]]) != loop[0]:
        loop.append(vertex)
    return loop
