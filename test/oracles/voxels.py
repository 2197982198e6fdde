"""Surfaces of sets of cells of a grid, of which it is known whether they cross themselves."""

import numpy as np

from truth.bodies.grids import surface
from truth.bodies.random_bodies import random_rotation

KINDS = ('any', 'pits', 'tunnels', 'shells', 'corners', 'edges')


def filled_cells(rng, kind, n):
    """Return which cells of an n x n x n grid are filled; at least one is."""
    filled = np.ones((n, n, n), dtype=bool)
    i, j, k = np.indices(filled.shape)
    if kind == 'any':
        filled = rng.random(filled.shape) < rng.uniform(0.2, 0.8)
    elif kind == 'pits':
        for x, y, z in rng.integers(0, n, (n, 3)):
            filled[x, y, max(z, 1) :] = False
    elif kind == 'tunnels':
        for x, y in rng.integers(0, n, (n, 2)):
            np.moveaxis(filled, rng.integers(3), 0)[:, x, y] = False
    elif kind == 'shells':  # a body in the cavity of a body, and so on
        filled = np.minimum.reduce([i, j, k, n - 1 - i, n - 1 - j, n - 1 - k]) % 2 == 0
    elif kind == 'corners':
        filled = (i + j + k) % 2 == 0
    else:
        filled = (i + j) % 2 == 0
    filled[0, 0, 0] |= not filled.any()
    return filled


def lines_of(rng, n, width, spread):
    """Return n + 1 lines along x, y and z; their gaps span ``spread`` powers of ten."""
    gaps = width * 10 ** rng.uniform(-spread, 0.0, (3, n))
    return np.concatenate((np.zeros((3, 1)), np.cumsum(gaps, axis=1)), axis=1)


def voxel_mesh(rng, kind, n=4, width=1.0, spread=0.0):
    """Return vertices (v, 3) and triangles (t, 3) of cells of a kind."""
    cells = map(tuple, np.argwhere(filled_cells(rng, kind, n)).tolist())
    vertices, triangles = surface(cells, lines_of(rng, n, width, spread))
    return np.array(vertices), np.array(triangles)


def placed(rng, vertices, triangles, far=0.0):
    """Return the mesh moved by about ``far``, and turned, in single precision and cut up, or not.

    Rounding comes last, and every vertex of a place gets the same.
    """
    if rng.random() < 0.5:
        vertices = vertices @ random_rotation(rng).T
    vertices = vertices + far * rng.normal(size=3)
    if rng.random() < 0.5:
        vertices = vertices.astype(np.float32).astype(float)
    if rng.random() < 0.5:
        vertices, triangles = vertices[triangles.ravel()], np.arange(triangles.size).reshape(-1, 3)
    return vertices, triangles
