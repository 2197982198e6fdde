"""Compiled reader of the poses of many frames, the first step of every message and cycle.

``math.batched`` does the same in NumPy, at 20 microseconds or more per call for any number of
poses; it is used to name what is wrong with invalid poses.

A pose that was read is a row of twelve numbers: R by its rows, then p.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.runtime.arrays import Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import Entry, compiled, given, own
from drake_geom_ros.math.tolerances import FARTHEST, QUATERNION_NORM

Floats = NDArray[np.float64]

POSITION = 9  # column of p
POSE_WIDTH = 12

# Return codes of ``_read_frame_poses``.
REFUSED = 0
READ = 1  # valid, with ids in any order
RISING = 2  # valid, with strictly ascending ids
KNOWN = 3  # valid, with ids equal to known ascending ones


def packed_poses(Rs: Floats, ps: Floats) -> Floats:
    """Return poses by R (n, 3, 3) and p (n, 3) [m] as rows (n, POSE_WIDTH)."""
    return np.hstack((Rs.reshape(-1, POSITION), ps))


def rotations_of(X_PFs: Floats) -> Floats:
    """Return R (n, 3, 3) of rows (n, POSE_WIDTH)."""
    return X_PFs[:, :POSITION].reshape(-1, 3, 3)


def positions_of(X_PFs: Floats) -> Floats:
    """Return p (n, 3) [m] of rows (n, POSE_WIDTH)."""
    return X_PFs[:, POSITION:]


@compiled
def read_poses(poses: Floats, Xs: Floats) -> int:
    """Write the rows Xs (n, POSE_WIDTH) of ``poses`` (n, 7), x y z qx qy qz qw, normalised.

    Returns the first row that has a number that is not finite, a coordinate beyond FARTHEST [m] or
    a quaternion off unit length by more than QUATERNION_NORM; n if there is none.
    """
    for k in range(poses.shape[0]):
        for c in range(3):
            if not abs(poses[k, c]) <= FARTHEST:
                return k
        for c in range(3, 7):
            if not math.isfinite(poses[k, c]):
                return k
        x, y, z, w = poses[k, 3], poses[k, 4], poses[k, 5], poses[k, 6]
        squared = x * x + y * y + (z * z + w * w)
        if not abs(math.sqrt(squared) - 1.0) <= QUATERNION_NORM:
            return k
        s = 2.0 / squared
        for c in range(3):
            Xs[k, POSITION + c] = poses[k, c]
        Xs[k, 0] = 1.0 - s * (y * y + z * z)
        Xs[k, 4] = 1.0 - s * (x * x + z * z)
        Xs[k, 8] = 1.0 - s * (x * x + y * y)
        Xs[k, 1], Xs[k, 3] = s * (x * y - w * z), s * (x * y + w * z)
        Xs[k, 2], Xs[k, 6] = s * (x * z + w * y), s * (x * z - w * y)
        Xs[k, 5], Xs[k, 7] = s * (y * z - w * x), s * (y * z + w * x)
    return poses.shape[0]


def _read_frame_poses(ids: Indices, known_ids: Indices, poses: Floats, Xs: Floats) -> int:
    """Read the poses of frames with ids (n,) as ``read_poses`` does; return a code for the ids.

    RISING: they ascend strictly, so all are different. KNOWN: they equal ``known_ids`` (m,), which
    ascend. READ: any other order. REFUSED: a pose is invalid, or the number or width of poses does
    not match.
    """
    if poses.shape[0] != ids.size or poses.shape[1] != 7:
        return REFUSED
    if read_poses(poses, Xs) < ids.size:
        return REFUSED
    rising, same = True, ids.size == known_ids.size
    for k in range(ids.size):
        rising &= k == 0 or ids[k] > ids[k - 1]
        same = same and ids[k] == known_ids[k]
    if same:
        return KNOWN
    return RISING if rising else READ


# Poses in the caller's arrays, with ids, are read into our own rows: see ``_read_frame_poses``.
FRAME_POSES = Entry(
    _read_frame_poses,
    given(np.int64, 1),
    own(np.int64, 1),
    given(np.float64, 2),
    own(np.float64, 2),
)
