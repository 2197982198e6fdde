"""The true signed distance of a solid mesh, where it is known: by triangles, and by boxes.

A point, and what is left of a sphere: the nearest of all triangles, sought in floats and told in
40 digits; its side by the winding number, the sum of the solid angles of the triangles (van
Oosterom and Strackee, IEEE Transactions on Biomedical Engineering 30, 1983).

Anything else and a body that is a union of boxes: apart, the nearest of the boxes. Overlapping, it
must move at least as far as the deepest box asks for; where that move leads out of them all it is
the answer, and elsewhere nothing is known (None). The same holds for a sphere that is moved
straight out of the surface: a ball in the solid touches the surface there.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from mpmath import mp, mpf

from drake_geom_ros.cross_check.bodies import Body, Pose
from drake_geom_ros.cross_check.surfaces import nearest_points, winding
from drake_geom_ros.math.array_types import Floats
from truth.references import convex
from truth.references.digits import columns, dot, vector
from truth.references.supports import DIGITS, offset_between
from truth.tolerances import FREE, NEAREST, SIDE


def signed_distance(a: Body, mesh: Body) -> float | None:
    """Return the signed distance [m] of a body and a Solid; None where it is not known."""
    if a.kind in ('Point', 'Sphere'):
        return ball_distance(mesh.corners, mesh.X_WG, a.p, a.size[0] if a.size else 0.0)
    return _of_parts(parts_of(a), parts_of(mesh))


def point_distance(corners: Floats, q: Any) -> tuple[Any, Floats]:
    """Return the signed distance (mpf) [m] of a point from a closed surface, and its nearest.

    ``corners`` (n, 3, 3) [m] of the triangles, counter-clockwise from outside; ``q`` has any
    digits.
    """
    rounded = np.array([float(x) for x in q])
    nearest = nearest_points(corners, rounded)
    distances = np.linalg.norm(nearest - rounded, axis=1)
    best = int(np.argmin(distances))
    size = float(np.abs(corners).max()) + float(np.abs(rounded).max())
    close = np.flatnonzero(distances <= distances[best] + NEAREST * size)
    with mp.workdps(DIGITS):
        distance = min(_of_triangle(corners[k], q) for k in close)
    inside = winding(corners, rounded) > 0.5
    return (-distance if inside else distance), nearest[best]


def ball_distance(corners: Floats, X_WM: Pose, p_WA: Floats, radius: float) -> float | None:
    """Return the signed distance [m] of a ball about A and a closed surface; None if unknown."""
    R, p_WM = X_WM
    with mp.workdps(DIGITS):
        offset = offset_between(p_WM, p_WA)
        q = [dot(column, offset) for column in columns(R)]
        of_point, foot = point_distance(corners, q)
        phi = float(of_point - mpf(float(radius)))
        if phi >= 0.0 or radius == 0.0:
            return phi
        if abs(of_point) < SIDE:
            return None
        away = np.array([float(x) for x in q]) - foot
        outward = away / float(of_point)
        clear, _ = point_distance(corners, list(map(mpf, foot + radius * outward)))
        return phi if clear >= radius - FREE else None


def parts_of(body: Body) -> list[Body]:
    """Return the convex bodies in World whose union a body is; of a Solid those known."""
    if body.kind != 'Solid':
        return [body]
    return [part.moved(body.R, body.p) for part in body.parts]


def _of_parts(a: list[Body], b: list[Body]) -> float | None:
    found = [convex.signed_distance(x, y) for x, y in product(a, b)]
    phi, n = min(found, key=lambda each: each[0])
    if phi >= 0.0:
        return phi
    moved = [part.at(part.p - phi * n) for part in b]
    clear = all(convex.signed_distance(x, y)[0] >= -FREE for x, y in product(a, moved))
    return phi if clear else None


def _of_triangle(triangle: Floats, q: Any) -> Any:
    """Return the distance of a point from a triangle, in as many digits as are set."""
    v = [np.array(vector(corner), dtype=object) for corner in triangle]
    point = np.array(q, dtype=object)
    normal = np.cross(v[1] - v[0], v[2] - v[0])
    sides = [(v[k], v[(k + 1) % 3] - v[k]) for k in range(3)]
    if all(np.cross(along, point - start) @ normal >= 0 for start, along in sides):
        return abs((point - v[0]) @ normal) / mp.sqrt(normal @ normal)
    gaps = []
    for start, along in sides:
        at = min(max((point - start) @ along / (along @ along), mpf(0)), mpf(1))
        gap = point - start - at * along
        gaps.append(mp.sqrt(gap @ gap))
    return min(gaps)
