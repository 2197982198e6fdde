"""How fast points may move while a motion lasts: certified bounds, node by node.

A point x of a body hangs on a node, that on its parent, and so on. In the axes of a parent P of
N, ``p_Px = p_PN + R_PN p_Nx``. With N turning at the rate w about an axis that it carries, with
bounds ``s`` and ``b`` of the speed and of the acceleration of its origin, and with bounds ``r``,
``v``, ``a`` of length, speed and acceleration of p_Nx, those of p_Px are (Craig, Introduction to
Robotics, 3rd ed., equations 5.13 and 6.9)

    r + |p_PN|,   v + s + w r,   a + b + 2 w v + w^2 r.

Against a node on which two bodies hang both, their common one, only what is between it and the
bodies counts (Schwarzer, Saha, Latombe, Exact collision checking of robot paths, WAFR 2002, for
speeds): two links that move together do not move against one another. All three are linear in the
length r that a body's farthest point has in the node that it hangs on.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.vectors import norm, vector_at
from drake_geom_ros.geometry._proximity.motion.arrays import (
    ANGLE,
    BEND,
    JOINTS,
    KIND,
    OFFSET,
    SCREW,
    SLIDE,
    SLIDE_ROUNDING,
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
    """Bounds for points of a body that are as far as r from the node that it hangs on [m].

    They move no faster than ``speed + speed_r r`` against another node, and their speed changes
    no faster than ``bend + bend_r r``; they are no farther from it than ``reach + r``.
    """

    speed: float
    speed_r: float
    bend: float
    bend_r: float
    reach: float


@inlined
def rates_against(motion: MotionArrays, node: int, ancestor: int) -> Rates:
    """Return the bounds of points of a node against one that it hangs on."""
    nodes, parents = motion.nodes, motion.parents
    speed, speed_r, bend, bend_r, reach = 0.0, 0.0, 0.0, 0.0, 0.0
    while node != ancestor:
        w = nodes[node, TURN]
        bend += nodes[node, BEND] + 2.0 * w * speed + w * w * reach
        bend_r += 2.0 * w * speed_r + w * w
        speed += nodes[node, SLIDE] + w * reach
        speed_r += w
        reach += nodes[node, OFFSET]
        node = parents[node]
    return Rates(speed, speed_r, bend, bend_r, reach)


@inlined
def rounding_of_body(motion: MotionArrays, node: int, r: float) -> float:
    """Return how far interpolating may have put points, up to r [m] from a node, from the truth.

    As speeds, roundings of all nodes up to the world add up; a product of poses on the way rounds
    by as much as its terms are long, which the whole length bounds.
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
    """Write the bounds of nodes that are frames which move by poses."""
    by_screw = motion.flags[KIND] == SCREW
    for k in range(motion.rows.size):
        # Frames are nodes by their rows, where there are no links.
        node, move = row(motion.nodes, motion.rows[k]), row(motion.moves, k)
        angle, step = move[ANGLE], norm(vector_at(move, STEP))
        start = norm(vector_at(row(motion.starts, k), POSITION))
        end = norm(vector_at(row(motion.ends, k), POSITION))
        moves = angle > 0.0 or step > 0.0
        node[TURN], node[SLIDE] = angle * ROUNDED_UP, step * ROUNDED_UP
        node[BEND] = angle * step * ROUNDED_UP if by_screw else 0.0
        # From the chord a curve is no farther than an eighth of its acceleration.
        node[OFFSET] = (max(start, end) + 0.125 * node[BEND]) * ROUNDED_UP
        node[TURN_ROUNDING] = INTERPOLATED_ROTATION if moves else 0.0
        node[SLIDE_ROUNDING] = INTERPOLATED_POSITION * (start + end + step) if moves else 0.0


@inlined
def _link_rates(motion: MotionArrays) -> None:
    """Write the bounds of nodes that are links: each turns or slides by its joint's rate.

    The origin of a link is on the axis of its joint.
    """
    for j in range(motion.chain_parents.size):
        node, leader = row(motion.nodes, 1 + motion.children[j]), motion.leaders[j]
        length, rate, size = norm(vector_at(row(motion.X_PJs, j), 0)), 0.0, abs(motion.offsets[j])
        if leader >= 0:
            start, end = motion.values[0, leader], motion.values[1, leader]
            multiplier = abs(motion.multipliers[j])
            rate = abs(end - start) * multiplier * ROUNDED_UP
            size += multiplier * (abs(start) + abs(end))
        kind = motion.kinds[j]
        node[TURN] = rate if kind == REVOLUTE else 0.0
        node[SLIDE] = rate if kind == PRISMATIC else 0.0
        node[BEND] = 0.0
        node[OFFSET] = (length + (size if kind == PRISMATIC else 0.0)) * ROUNDED_UP
        node[TURN_ROUNDING] = INTERPOLATED_ROTATION
        node[SLIDE_ROUNDING] = 0.0
        if kind != FIXED:
            rounding = 4.0 * EPS * size
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
    """Return how far points of b may be from the node that the half space a hangs on [m].

    ``far`` [m] is what b and the half space move by at most, and how far b reaches.
    """
    squared = 0.0
    for c in range(3):
        squared += (p_WGs[b, c] - p_WGs[a, c]) * (p_WGs[b, c] - p_WGs[a, c])
    return math.sqrt(squared) + far
