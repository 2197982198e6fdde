"""Certified bounds of the speeds of points during a motion, node by node.

A point x of a body belongs to a node, the node to its parent, and so on. In the axes of a parent P
of N, ``p_Px = p_PN + R_PN p_Nx``. Let N turn at the rate w about an axis fixed in it, with bounds
``s`` and ``b`` of the speed and acceleration of its origin, and bounds ``r``, ``v``, ``a`` of the
length, speed and acceleration of p_Nx. Then those of p_Px are (Craig, Introduction to Robotics,
3rd ed., equations 5.13 and 6.9)

    r + |p_PN|,   v + s + w r,   a + b + 2 w v + (w^2 + c) r,

where w bounds the rate and c the angular acceleration: a joint that follows a curve changes its
rate.

Relative to the common node of two bodies, only the nodes between it and the bodies count
(Schwarzer, Saha, Latombe, Exact collision checking of robot paths, WAFR 2002, for speeds): links
that move together have no relative motion. All three bounds are linear in the length r of a body's
farthest point in its own node.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.vectors import norm, vector_at
from drake_geom_ros.geometry._proximity.motion.arrays import (
    ACCELERATION,
    ANGLE,
    BEND,
    JOINTS,
    KIND,
    OFFSET,
    ROUNDING,
    SCREW,
    SIZE,
    SLIDE,
    SLIDE_ROUNDING,
    SPEED,
    SPIN,
    STEP,
    TURN,
    TURN_ROUNDING,
    MotionArrays,
    motions_of,
)
from drake_geom_ros.geometry._proximity.motion.interpolants import prepare_moves
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import row
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    INTERPOLATED_POSITION,
    INTERPOLATED_ROTATION,
    ROUNDED_UP,
)
from drake_geom_ros.geometry._proximity.world.joint_poses import FIXED, PRISMATIC, REVOLUTE
from drake_geom_ros.geometry._proximity.world.pose_rows import POSITION


class Rates(NamedTuple):
    """Bounds for the points of a body at a distance of at most r [m] from the origin of its node.

    Relative to another node, their speed is at most ``speed + speed_r r``, their acceleration at
    most ``bend + bend_r r``, and their distance at most ``reach + r``.
    """

    speed: float
    speed_r: float
    bend: float
    bend_r: float
    reach: float


@inlined
def rates_against(motion: MotionArrays, node: int, ancestor: int) -> Rates:
    """Return the bounds of the points of a node relative to one of its ancestors."""
    nodes, parents = motion.nodes, motion.parents
    speed, speed_r, bend, bend_r, reach = 0.0, 0.0, 0.0, 0.0, 0.0
    while node != ancestor:
        w = nodes[node, TURN]
        turning = w * w + nodes[node, SPIN]
        bend += nodes[node, BEND] + 2.0 * w * speed + turning * reach
        bend_r += 2.0 * w * speed_r + turning
        speed += nodes[node, SLIDE] + w * reach
        speed_r += w
        reach += nodes[node, OFFSET]
        node = parents[node]
    return Rates(speed, speed_r, bend, bend_r, reach)


@inlined
def rounding_of_body(motion: MotionArrays, node: int, r: float) -> float:
    """Return the interpolation error [m] of points up to r [m] from the origin of a node.

    Like speeds, the roundings of all nodes up to the world add up. Each product of poses rounds in
    proportion to the lengths of its terms, which the total length bounds.
    """
    nodes, parents = motion.nodes, motion.parents
    shift, products = 0.0, 0.0
    while node != 0:
        shift += nodes[node, SLIDE_ROUNDING] + nodes[node, TURN_ROUNDING] * r
        r += nodes[node, OFFSET]
        if nodes[node, TURN_ROUNDING] > 0.0:
            products += INTERPOLATED_POSITION
        node = parents[node]
    return shift + products * r


@inlined
def _frame_rates(motion: MotionArrays) -> None:
    """Write the bounds of the nodes of frames that move by poses."""
    by_screw = motion.flags[KIND] == SCREW
    for k in range(motion.rows.size):
        # Without links, the node of a frame is its row.
        node, move = row(motion.nodes, motion.rows[k]), row(motion.moves, k)
        angle, step = move[ANGLE], norm(vector_at(move, STEP))
        start = norm(vector_at(row(motion.starts, k), POSITION))
        end = norm(vector_at(row(motion.ends, k), POSITION))
        moves = angle > 0.0 or step > 0.0
        node[TURN], node[SLIDE] = angle * ROUNDED_UP, step * ROUNDED_UP
        node[BEND] = angle * step * ROUNDED_UP if by_screw else 0.0
        # A curve deviates from its chord by at most an eighth of its acceleration.
        node[OFFSET] = (max(start, end) + 0.125 * node[BEND]) * ROUNDED_UP
        node[TURN_ROUNDING] = INTERPOLATED_ROTATION if moves else 0.0
        node[SLIDE_ROUNDING] = INTERPOLATED_POSITION * (start + end + step) if moves else 0.0


@inlined
def _link_rates(motion: MotionArrays) -> None:
    """Write the bounds of the nodes of links, each of which turns or slides at its joint's rate.

    The origin of a link is on the axis of its joint.
    """
    for j in range(motion.chain_parents.size):
        node, leader = row(motion.nodes, 1 + motion.children[j]), motion.leaders[j]
        length, size = norm(vector_at(row(motion.X_PJs, j), 0)), abs(motion.offsets[j])
        rate, change, rounding = 0.0, 0.0, 0.0
        if leader >= 0:
            multiplier = abs(motion.multipliers[j])
            rate = motion.values[SPEED, leader] * multiplier * ROUNDED_UP
            change = motion.values[ACCELERATION, leader] * multiplier * ROUNDED_UP
            size += multiplier * motion.values[SIZE, leader]
            rounding = multiplier * motion.values[ROUNDING, leader]
        kind = motion.kinds[j]
        node[TURN] = rate if kind == REVOLUTE else 0.0
        node[SLIDE] = rate if kind == PRISMATIC else 0.0
        node[SPIN] = change if kind == REVOLUTE else 0.0
        node[BEND] = change if kind == PRISMATIC else 0.0
        node[OFFSET] = (length + (size if kind == PRISMATIC else 0.0)) * ROUNDED_UP
        node[TURN_ROUNDING] = INTERPOLATED_ROTATION
        node[SLIDE_ROUNDING] = 0.0
        if kind != FIXED:
            rounding += 4.0 * EPS * size
            node[TURN_ROUNDING] += rounding if kind == REVOLUTE else 0.0
            node[SLIDE_ROUNDING] += rounding if kind == PRISMATIC else 0.0


@compiled
def prepare(handle: Handle) -> None:
    """Write all bounds of a motion between its start and its end."""
    motion = motions_of(handle)
    if motion.flags[KIND] == JOINTS:
        _link_rates(motion)
    else:
        prepare_moves(handle)
        _frame_rates(motion)


@inlined
def plane_reach(motion: MotionArrays, p_WGs: Floats, a: int, b: int, far: float) -> float:
    """Return a bound of the distance [m] of points of b from the origin of the half space a.

    ``far`` [m] is the largest motion of b and the half space plus the outer radius of b.
    """
    squared = 0.0
    for c in range(3):
        squared += (p_WGs[b, c] - p_WGs[a, c]) * (p_WGs[b, c] - p_WGs[a, c])
    return math.sqrt(squared) + far
