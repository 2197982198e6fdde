"""Poses of many frames from one array, compiled: what every message and every cycle does first.

``math.batched`` does the same in NumPy, at 20 microseconds and more a call whatever the number of
poses; it stays the one that names what is wrong.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.compiled import compiled


@compiled
def read_poses(poses, norm_tolerance, farthest, Rs, ps):  # type: ignore[no-untyped-def]
    """Write R (n, 3, 3) and p (n, 3) [m] of ``poses`` (n, 7), x y z qx qy qz qw, normalised.

    Returns the first row that has a number that is not finite, a coordinate beyond ``farthest``
    [m] or a quaternion off unit length by more than ``norm_tolerance``; n if there is none.
    """
    for k in range(poses.shape[0]):
        for c in range(3):
            if not abs(poses[k, c]) <= farthest:
                return k
        for c in range(3, 7):
            if not math.isfinite(poses[k, c]):
                return k
        x, y, z, w = poses[k, 3], poses[k, 4], poses[k, 5], poses[k, 6]
        squared = x * x + y * y + (z * z + w * w)
        if not abs(math.sqrt(squared) - 1.0) <= norm_tolerance:
            return k
        s = 2.0 / squared
        for c in range(3):
            ps[k, c] = poses[k, c]
        R = Rs[k]
        R[0, 0] = 1.0 - s * (y * y + z * z)
        R[1, 1] = 1.0 - s * (x * x + z * z)
        R[2, 2] = 1.0 - s * (x * x + y * y)
        R[0, 1], R[1, 0] = s * (x * y - w * z), s * (x * y + w * z)
        R[0, 2], R[2, 0] = s * (x * z + w * y), s * (x * z - w * y)
        R[1, 2], R[2, 1] = s * (y * z - w * x), s * (y * z + w * x)
    return poses.shape[0]


@compiled
def read_frame_poses(ids, poses, norm_tolerance, farthest, Rs, ps):  # type: ignore[no-untyped-def]
    """Do what ``read_poses`` does; return if all are poses, and if the ids (n,) rise strictly.

    They do when frames come in their order, and then all of them are different.
    """
    rising = True
    for k in range(1, ids.size):
        rising &= ids[k] > ids[k - 1]
    return read_poses(poses, norm_tolerance, farthest, Rs, ps) == ids.size, rising
