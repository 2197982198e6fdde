"""Sensed maps to test with, and what all their cells as geometries of their own say."""

import numpy as np
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.geometry import Box, OccupiedCells, PointCloud, Sphere
from drake_geom_ros.math import RigidTransform

KINDS = (OccupiedCells, PointCloud)


def cells_of(shape):
    """Return the shape of one cell and the centres (n, 3) of all."""
    if isinstance(shape, OccupiedCells):
        return Box(*3 * [shape.resolution()]), shape.centres()
    return Sphere(shape.radius()), shape.positions()


def grid(*counts):
    """Return the centres of a block of cells of edge 1 about the origin."""
    axes = [np.arange(count) - 0.5 * (count - 1) for count in counts]
    return np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1).reshape(-1, 3)


def awkward_maps(rng):
    """Return names and centres (n, 3), in edges of a cell."""
    some = rng.uniform(-3.0, 3.0, (23, 3))
    return {
        'one': np.zeros((1, 3)),
        'beside': np.array([[4.0, -3.0, 2.0]]),
        'two': np.array([[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
        'line': grid(9, 1, 1),
        'plane': grid(7, 7, 1),
        'block': grid(3, 4, 5),
        'shell': grid(5, 5, 5)[np.abs(grid(5, 5, 5)).max(axis=1) > 1.5],
        'coinciding': np.repeat(some[:4], 6, axis=0),
        'random': some,
        'far apart': 40.0 * some,
    }


def nearest_of_all(shape, X_WM, body, X_WB):
    """Return the least signed distance of a body from the cells of a map, one by one, its bound.

    The cells are anchored geometries of their own, which other kernels answer for.
    """
    cell, centres = cells_of(shape)
    anchored = [(cell, X_WM @ RigidTransform(centre)) for centre in centres]
    scene = ShapeScene(body, anchored=anchored).posed(X_WB)
    found = scene.query.ComputeSignedDistancePairwiseClosestPoints()
    assert len(found) == len(centres)
    k = int(np.argmin(found.distance))
    return float(found.distance[k]), float(found.error_bound.max())
