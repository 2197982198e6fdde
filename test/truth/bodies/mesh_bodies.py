"""Solid meshes with dents, in several resolutions.

``L``
    Two boxes that share a corner. However finely its faces are cut, it is the same body, so that
    boxes tell the truth about it.
``Ball``
    An icosphere with six bumps and dents between them; every resolution is a body of its own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import ConvexHull

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.math.array_types import Floats
from truth.bodies import grids

UNIT = 0.1  # [m] the width of the L's arms
L_LINES = [np.array(line) * UNIT for line in ((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), (-0.5, 0.5))]
RADIUS = 0.12  # [m] of the ball
DENTS = 0.5  # [-] a ball with less than 0.25 is convex
# About so many triangles -> how often each side of the L is cut, each triangle of the ball halved.
CUTS = {100: (2, 1), 1300: (7, 3), 20000: (27, 5)}


@functools.cache
def mesh_body(name: str, resolution: int) -> Body:
    """Return a body by its name and resolution, of ``MAKERS`` and ``CUTS``."""
    body = MAKERS[name](resolution)
    return replace(body, size=np.array(body.size), triangles=np.array(body.triangles))


def l_body(resolution: int) -> Body:
    """Return an L about its inner edge."""
    return grids.solid(grids.L, L_LINES, cuts=CUTS[resolution][0])


def ball(resolution: int) -> Body:
    """Return an icosphere with dents."""
    golden = (1.0 + 5.0**0.5) / 2.0
    points = np.array(
        [np.roll([0.0, s, t * golden], k) for s in (1, -1) for t in (1, -1) for k in range(3)]
    )
    points /= np.linalg.norm(points[0])
    hull = ConvexHull(points)
    outward = np.linalg.det(points[hull.simplices]) > 0.0
    corners = points[np.where(outward[:, None], hull.simplices, hull.simplices[:, ::-1])]
    for _ in range(CUTS[resolution][1]):
        corners = _quartered(corners)
    radii = RADIUS * (1.0 + DENTS * ((corners**4).sum(axis=2, keepdims=True) - 0.6))
    vertices, triangles = np.unique((radii * corners).reshape(-1, 3), axis=0, return_inverse=True)
    return Body('Solid', vertices, triangles=triangles.reshape(-1, 3))


def _quartered(corners: Floats) -> Floats:
    """Return four triangles for each, with the middles of its sides brought to radius 1."""
    middles = corners + np.roll(corners, -1, axis=1)
    middles /= np.linalg.norm(middles, axis=2, keepdims=True)
    (a, b, c), (ab, bc, ca) = np.swapaxes(corners, 0, 1), np.swapaxes(middles, 0, 1)
    parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate([np.stack(part, axis=1) for part in parts])


MAKERS: dict[str, Callable[[int], Body]] = {'L': l_body, 'Ball': ball}
