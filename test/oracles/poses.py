"""Poses to test with, general and nearly degenerate; and what poses say in 60 digits, unrounded.

Of those a quaternion is normalised, a matrix stands for the rotation nearest to it.
"""

import numpy as np
from mpmath import MPContext
from scipy.spatial.transform import Rotation

mp = MPContext()  # not that of others, whose precision stays as it is
mp.dps = 60


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


def vector(numbers):
    """Return numbers as a column."""
    return mp.matrix([mp.mpf(float(x)) for x in numbers])


def rotation_of_quaternion(qxqyqzqw):
    """Return the rotation of a quaternion of any length."""
    x, y, z, w = vector(qxqyqzqw)
    s = 2 / (x * x + y * y + z * z + w * w)
    return mp.matrix(
        [
            [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
        ]
    )


def nearest_rotation(R):
    """Return the rotation nearest to a matrix that is almost one: Newton's iteration."""
    Q = mp.matrix([[mp.mpf(float(x)) for x in row] for row in R])
    for _ in range(8):
        Q = (Q + (Q**-1).T) / 2
    return Q


def composed(poses):
    """Return R and p of the product of poses, each 7 numbers or a pair of R (3, 3) and p (3,)."""
    R_WF, p_WF = mp.eye(3), mp.matrix(3, 1)
    for pose in poses:
        if len(pose) == 2:
            R_PF, p_PF = nearest_rotation(pose[0]), vector(pose[1])
        else:
            R_PF, p_PF = rotation_of_quaternion(pose[3:]), vector(pose[:3])
        R_WF, p_WF = R_WF * R_PF, p_WF + R_WF * p_PF
    return R_WF, p_WF


def length(v):
    """Return |v|."""
    return mp.sqrt(sum(x * x for x in v))


def box_distance(half, q):
    """Return the signed distance of a point, in the box's frame, to a box."""
    beyond = [abs(x) - mp.mpf(float(h)) for x, h in zip(q, half, strict=True)]
    if max(beyond) <= 0:
        return max(beyond)
    return length([max(b, mp.mpf(0)) for b in beyond])
