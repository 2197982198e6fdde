"""Checks of vectors and rotations in arrays, and the rotation nearest to a matrix."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import ORTHOGONAL

_IDENTITY = np.eye(3)


def as_vector(value: ArrayLike, what: str) -> Floats:
    """Return a copy of ``value`` as finite floats (3,); raises RuntimeError for other values."""
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise RuntimeError(f'{what} = {value!r} is not three numbers') from None
    if vector.shape in ((3, 1), (1, 3)):
        vector = vector.reshape(3)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise RuntimeError(f'{what} = {vector.tolist()} is not three finite numbers')
    return vector


def rotation_error(R: Floats) -> float:
    """Return max |R R^T - I| [-] of R (3, 3), or infinity for a reflection or a NaN."""
    if not np.isfinite(R).all() or np.linalg.det(R) <= 0.0:
        return math.inf
    return float(np.abs(R @ R.T - np.eye(3)).max())


def orthogonal(R: Floats) -> Floats:
    """Return the rotation nearest to R (3, 3), which must be almost one; R itself if it is one.

    One step of the iteration of Newton and Schulz towards the polar factor, whose error is 3/8 of
    the square of the defect R^T R - I (Higham, Functions of Matrices, section 8.3).
    """
    defect = R.T @ R - _IDENTITY
    if np.abs(defect).max() <= ORTHOGONAL:
        return R
    nearest: Floats = R - 0.5 * (R @ defect)
    return nearest
