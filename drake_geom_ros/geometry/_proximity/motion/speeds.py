"""Certified bounds of the speeds of geometries in the world, for all edges of a path at once.

The bounds are those of ``rates``, relative to the world: a joint that turns at the rate w moves
points at a distance d from its axis at w d, and the speeds of all joints below a point add up.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.motion.arrays import (
    OFFSET,
    MotionArrays,
)
from drake_geom_ros.geometry._proximity.motion.joint_path import JointPath
from drake_geom_ros.geometry._proximity.tolerances import ROUNDED_UP
from drake_geom_ros.geometry._proximity.world.joint_poses import PRISMATIC, REVOLUTE

Floats = NDArray[np.float64]
_BOUNDS = 5  # coefficients of a curve come before its bounds


def speeds_of_geometries(motion: MotionArrays, path: JointPath) -> Floats:
    """Return an upper bound (e, n) of the speed of all points of geometries [m] an edge.

    ``motion`` is one by joints. A half space that turns has points of any speed: infinity.
    """
    turns, slides, offsets = _of_nodes(motion, path)
    parents, reaches = motion.parents.tolist(), motion.reaches
    # By edges and nodes: the speed of the origin of a node, and the rate at which it turns.
    speeds, rates = np.zeros((2, *turns.shape))
    done = {0}
    for node in np.unique(motion.on).tolist():
        line = [node]
        while line[-1] not in done:
            line.append(parents[line[-1]])
        done.update(line)
        for parent, child in zip(line[::-1], line[-2::-1], strict=False):
            speeds[:, child] = (
                speeds[:, parent] + rates[:, parent] * offsets[:, child] + slides[:, child]
            )
            rates[:, child] = rates[:, parent] + turns[:, child]
    bounds = speeds[:, motion.on] + rates[:, motion.on] * reaches
    bounds[(reaches == 0.0) & (rates[:, motion.on] > 0.0)] = math.inf
    return np.asarray(bounds * ROUNDED_UP)


def _of_nodes(motion: MotionArrays, path: JointPath) -> tuple[Floats, Floats, Floats]:
    """Return how fast nodes turn [rad] and slide [m], and their offsets [m], each (e, v)."""
    rates, sizes = _of_values(path)
    count = len(rates)
    turns, slides = np.zeros((2, count, len(motion.nodes)))
    offsets = np.repeat(motion.nodes[np.newaxis, :, OFFSET], count, axis=0)
    for j, leader in enumerate(motion.leaders.tolist()):
        node, kind = 1 + motion.children[j], motion.kinds[j]
        length = float(np.linalg.norm(motion.X_PJs[j, :3]))
        size = np.full(count, abs(motion.offsets[j]))
        if leader >= 0:
            multiplier = abs(motion.multipliers[j])
            size += multiplier * sizes[:, leader]
            bound = {REVOLUTE: turns, PRISMATIC: slides}.get(int(kind))
            if bound is not None:
                bound[:, node] = rates[:, leader] * multiplier * ROUNDED_UP
        offsets[:, node] = (length + (size if kind == PRISMATIC else 0.0)) * ROUNDED_UP
    return turns, slides, offsets


def _of_values(path: JointPath) -> tuple[Floats, Floats]:
    """Return bounds (e, c) of the first derivative of values by edges, and of their size."""
    if len(path.curves):
        return path.curves[:, _BOUNDS], path.curves[:, _BOUNDS + 2]
    starts, ends = path.rows[:-1], path.rows[1:]
    return np.abs(ends - starts), np.abs(starts) + np.abs(ends)
