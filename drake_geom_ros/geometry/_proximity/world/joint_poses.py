"""Forward kinematics of joint trees, compiled: the poses of all links by rows of joint values."""

from __future__ import annotations

import math
from typing import TypeAlias

from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined

Quaternion: TypeAlias = tuple[float, float, float, float]  # x, y, z, w

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2  # what a joint does along or about its axis


@inlined
def _compose(poses: Floats, a: int, p: Vector, q: Quaternion, b: int) -> None:
    """Write the product of the pose in row a and of (p, q) to row b; rows x y z qx qy qz qw."""
    x, y, z, w = poses[a, 3], poses[a, 4], poses[a, 5], poses[a, 6]
    # p + 2 w (v x p) + 2 v x (v x p) for a unit quaternion (v, w), Rodrigues' formula.
    s, t, u = y * p[2] - z * p[1], z * p[0] - x * p[2], x * p[1] - y * p[0]
    poses[b, 0] = poses[a, 0] + p[0] + 2.0 * (w * s + (y * u - z * t))
    poses[b, 1] = poses[a, 1] + p[1] + 2.0 * (w * t + (z * s - x * u))
    poses[b, 2] = poses[a, 2] + p[2] + 2.0 * (w * u + (x * t - y * s))
    poses[b, 3] = w * q[0] + x * q[3] + (y * q[2] - z * q[1])
    poses[b, 4] = w * q[1] + y * q[3] + (z * q[0] - x * q[2])
    poses[b, 5] = w * q[2] + z * q[3] + (x * q[1] - y * q[0])
    poses[b, 6] = w * q[3] - (x * q[0] + y * q[1] + z * q[2])


@compiled
def pose_links(
    values: Floats,
    leaders: Indices,
    multipliers: Floats,
    offsets: Floats,
    kinds: Indices,
    axes: Floats,
    X_PJs: Floats,
    parents: Indices,
    children: Indices,
    X_WLs: Floats,
    links: Indices,
    first: int,
    chosen: Floats,
) -> None:
    """Write poses X_WL for joint values (N, c) to ``chosen`` (N, m, 7), from row ``first`` on.

    Those of the ``links`` (k,); ``X_WLs`` (links, 7) is room for all of them and holds the root's.
    Of each joint, parents first: which value leads it (-1: none), times what and plus what it is,
    its kind and unit axis, X_PJ (7,), and the rows of its two links.
    """
    for s in range(values.shape[0]):
        for j in range(parents.size):
            value = offsets[j]
            if leaders[j] >= 0:
                value += multipliers[j] * values[s, leaders[j]]
            p = (X_PJs[j, 0], X_PJs[j, 1], X_PJs[j, 2])
            q = (X_PJs[j, 3], X_PJs[j, 4], X_PJs[j, 5], X_PJs[j, 6])
            child = children[j]
            _compose(X_WLs, parents[j], p, q, child)
            x, y, z = axes[j, 0], axes[j, 1], axes[j, 2]
            if kinds[j] == REVOLUTE:
                sine, cosine = math.sin(0.5 * value), math.cos(0.5 * value)
                turn = (x * sine, y * sine, z * sine, cosine)
                _compose(X_WLs, child, (0.0, 0.0, 0.0), turn, child)
            elif kinds[j] == PRISMATIC:
                step = (value * x, value * y, value * z)
                _compose(X_WLs, child, step, (0.0, 0.0, 0.0, 1.0), child)
        for k in range(links.size):
            for c in range(7):
                chosen[s, first + k, c] = X_WLs[links[k], c]
