"""Poses to test with: seeded, general and nearly degenerate ones alike."""

import numpy as np
from scipy.spatial.transform import Rotation


def random_poses(count, seed=0):
    """Return poses (count, 7), x y z qx qy qz qw: every third a quarter turn or next to one."""
    rng = np.random.default_rng(seed)
    poses = np.hstack((rng.normal(size=(count, 3)), rng.normal(size=(count, 4))))
    for k in range(0, count, 3):
        axis = rng.permutation(np.eye(3))[0]
        angle = rng.integers(-4, 5) * np.pi / 2 + rng.choice([0.0, 1e-9, 1e-16, 1e-4])
        poses[k, 3:] = Rotation.from_rotvec(angle * axis).as_quat()
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    return poses


def matrix_of(pose):
    """Return the (4, 4) matrix of one pose, computed by SciPy."""
    X = np.eye(4)
    X[:3, :3] = Rotation.from_quat(pose[3:]).as_matrix()
    X[:3, 3] = pose[:3]
    return X
