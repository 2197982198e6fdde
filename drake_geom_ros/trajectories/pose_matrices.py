"""Homogeneous matrices (..., 4, 4) of poses (..., 7) x y z qx qy qz qw, and back."""

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import matrices_from_poses, poses_from_matrices


def poses_of_matrices(X: ArrayLike) -> Floats:
    """Return the poses (..., 7) [m, -] of rigid transforms (..., 4, 4); qw >= 0."""
    X = np.asarray(X, dtype=float)
    rows = X.reshape(-1, 4, 4)
    return poses_from_matrices(rows[:, :3, :3], rows[:, :3, 3]).reshape(*X.shape[:-2], 7)


def matrices_of_poses(poses: ArrayLike) -> Floats:
    """Return the rigid transforms (..., 4, 4) of poses (..., 7); RuntimeError for a bad pose."""
    poses = np.asarray(poses, dtype=float)
    R, p = matrices_from_poses(poses.reshape(-1, 7))
    X = np.zeros((len(p), 4, 4))
    X[:, :3, :3], X[:, :3, 3], X[:, 3, 3] = R, p, 1.0
    return X.reshape(*poses.shape[:-1], 4, 4)


def inverse(X: ArrayLike) -> Floats:
    """Return the inverse rigid transforms (..., 4, 4)."""
    X = np.asarray(X, dtype=float)
    R_T = np.swapaxes(X[..., :3, :3], -1, -2)
    result = np.array(X)
    result[..., :3, :3] = R_T
    result[..., :3, 3] = -(R_T @ X[..., :3, 3:])[..., 0]
    return result
