"""Compiled forward kinematics of joint trees: poses of all links from rows of joint values."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined

Quaternion: TypeAlias = tuple[float, float, float, float]  # x, y, z, w

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2  # motion of a joint about or along its axis


class JointChain(NamedTuple):
    """A forest of joint trees, with all parameters of the poses of its links."""

    leaders: Indices  # (m,) columns of a state; -1: none
    multipliers: Floats  # (m,)
    offsets: Floats  # (m,) [rad] or [m]
    kinds: Indices  # (m,)
    axes: Floats  # (m, 3) unit
    X_PJs: Floats  # (m, 7) x y z [m] qx qy qz qw
    parents: Indices  # (m,) rows of links
    children: Indices  # (m,) rows of links
    X_WLs: Floats  # (links, 7): those of the roots; scratch for the others
    links: Indices  # (n,) rows of those links that are frames of the scene


@inlined
def _compose(poses: Floats, a: int, p: Vector, q: Quaternion, b: int) -> None:
    """Write the product of the pose in row a and (p, q) to row b; rows are x y z qx qy qz qw."""
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
def pose_links(values: Floats, chain: tuple[Any, ...], first: int, chosen: Floats) -> None:
    """Write poses X_WL for joint values (N, c) to ``chosen`` (N, m, 7), from row ``first`` on.

    The poses are those of the ``links`` of a ``JointChain``, passed as a plain tuple, see
    ``pairs.slots``. Its joints are in order, parents first.
    """
    leaders, multipliers, offsets, kinds, axes, X_PJs, parents, children, X_WLs, links = chain
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
