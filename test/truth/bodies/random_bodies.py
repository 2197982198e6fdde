"""Directions, rotations, shapes and poses: even, random, and such as solvers fail on."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.cross_check.bodies import BOUNDED, COUNTS, FROM_VERTICES, Body, as_tuples
from drake_geom_ros.math.array_types import Floats


def random_directions(rng: np.random.Generator, count: int) -> Floats:
    """Return unit vectors (count, 3): of a ball the vertices of a hull of as many."""
    directions = rng.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1)[:, None]


def even_directions(count: int) -> Floats:
    """Return unit vectors (count, 3) that lie evenly: a Fibonacci spiral."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    rho = np.sqrt(1.0 - z * z)
    return np.column_stack([rho * np.cos(turn), rho * np.sin(turn), z])


def random_rotations(rng: np.random.Generator, count: int) -> Floats:
    """Return uniformly random rotation matrices (count, 3, 3)."""
    w_first = rng.normal(size=(count, 4))  # as whoever stored cases by their seeds drew them
    matrices: Floats = Rotation.from_quat(w_first[:, [1, 2, 3, 0]]).as_matrix()
    return matrices


def random_rotation(rng: np.random.Generator, near: float | None = None) -> Floats:
    """Return a random rotation matrix (3, 3), by an angle of ``near`` [rad] if given."""
    if near is None:
        return random_rotations(rng, 1)[0]
    axis = rng.normal(size=4)[1:]
    matrix: Floats = Rotation.from_rotvec(near / np.linalg.norm(axis) * axis).as_matrix()
    return matrix


def random_body(rng: np.random.Generator, kind: str, corners: int = 0) -> Body:
    """Return a shape of a kind, some 0.2 m wide; a hull has as many corners as asked for."""
    if kind in FROM_VERTICES:
        # All on an ellipsoid: each is a vertex of the hull.
        return Body(kind, random_directions(rng, corners) * rng.uniform(0.08, 0.2, 3))
    return Body.of_halves(kind, rng.uniform(0.05, 0.2, COUNTS.get(kind, 0)))


def awkward_body(rng: np.random.Generator, scale: float, lattice: bool) -> Body:
    """Return a body about as large as ``scale`` [m]; on a lattice of a few equal sizes.

    A hull is a cube there, elsewhere that of a dozen points.
    """
    halves = scale * (rng.integers(1, 3, 3) / 2.0 if lattice else 10.0 ** rng.uniform(-2, 0, 3))
    points = box_corners() if lattice else rng.uniform(-1.0, 1.0, (12, 3))
    kind = (*BOUNDED, 'Convex')[int(rng.integers(len(BOUNDED) + 1))]
    if kind == 'Convex':
        return Body(kind, as_tuples(points * halves))
    return Body.of_halves(kind, halves)


def awkward_poses(rng: np.random.Generator, scale: float, lattice: bool, count: int) -> Floats:
    """Return poses (count, 7), x y z [m] qx qy qz qw, some ``scale`` about the origin.

    They are any, or on lattice points in one of few orientations.
    """
    poses = np.empty((count, 7))
    if lattice:
        poses[:, :3] = scale * rng.integers(-2, 3, (count, 3)) / 2.0
        halves = np.array([[0, 0, 0, 1.0], [1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [1, 1, 1, 1]])
        poses[:, 3:] = halves[rng.integers(len(halves), size=count)]
    else:
        poses[:, :3] = scale * rng.uniform(-1.5, 1.5, (count, 3))
        poses[:, 3:] = rng.normal(size=(count, 4))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    return poses


def box_corners(size: Floats | tuple[float, ...] = (1.0, 1.0, 1.0)) -> Floats:
    """Return the corners (8, 3) [m] of a box about the origin."""
    corners: Floats = (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5) * np.array(size)
    return corners
