"""Interpolation of the scene at a time of a motion, 0 at its start and 1 at its end.

A frame moves from X_PF to another pose in one of two ways. Its position moves straight and its
rotation turns about one axis, by the shorter way (slerp); or it follows a screw (Murray, Li,
Sastry, A Mathematical Introduction to Robotic Manipulation, section 2.3). Both turn at a constant
rate about an axis fixed in the frame. Both ways of a half turn are equally short: it turns about
the axis whose first nonzero component is positive. Joints move straight in joint space, or each
along a polynomial of at most the fifth degree.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    cross,
    norm,
    rotate,
    scale,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.motion.arrays import (
    ANGLE,
    AXIS,
    CURVED,
    ELAPSED,
    FIRST_VALUE,
    JOINTS,
    KIND,
    LAST_VALUE,
    NOW,
    POWERS,
    SCREW,
    SPEED,
    STEP,
    MotionArrays,
    motions_of,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import row, table
from drake_geom_ros.geometry._proximity.states.loops import pose_state
from drake_geom_ros.geometry._proximity.tolerances import HALF_TURN, SMALL_TURN
from drake_geom_ros.geometry._proximity.world.joint_poses import pose_links
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH, POSITION
from drake_geom_ros.geometry._proximity.world.pose_update import set_poses, update


@inlined
def _turn_between(start: Floats, end: Floats) -> tuple[Vector, float]:
    """Return the axis and angle [rad], at most pi, of ``R_start^T R_end``, from rows of poses.

    It uses the row of the quaternion that loses no digits (Shepperd, J. Guidance and Control 1(3),
    1978).
    """
    R, S = table(start, 0, 3, 3), table(end, 0, 3, 3)
    x = unrotate(R, (S[0, 0], S[1, 0], S[2, 0]))
    y = unrotate(R, (S[0, 1], S[1, 1], S[2, 1]))
    z = unrotate(R, (S[0, 2], S[1, 2], S[2, 2]))
    twice = (y[2] - z[1], z[0] - x[2], x[1] - y[0])  # 4 w v of the quaternion (v, w)
    trace = x[0] + y[1] + z[2]
    if trace >= x[0] and trace >= y[1] and trace >= z[2]:
        v, w = twice, 1.0 + trace
    elif x[0] >= y[1] and x[0] >= z[2]:
        v, w = (1.0 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2]), twice[0]
    elif y[1] >= z[2]:
        v, w = (y[0] + x[1], 1.0 + y[1] - x[0] - z[2], z[1] + y[2]), twice[1]
    else:
        v, w = (z[0] + x[2], z[1] + y[2], 1.0 + z[2] - x[0] - y[1]), twice[2]
    length = norm(v)
    if length == 0.0:
        return (1.0, 0.0, 0.0), 0.0
    first = v[2]
    if abs(v[1]) > HALF_TURN * length:
        first = v[1]
    if abs(v[0]) > HALF_TURN * length:
        first = v[0]
    flips = w < 0.0
    if abs(w) <= HALF_TURN * length:
        flips = first < 0.0
    return scale((-1.0 if flips else 1.0) / length, v), 2.0 * math.atan2(length, abs(w))


@inlined
def versed(angle: float) -> tuple[float, float]:
    """Return (1 - cos x) / x and 1 - sin x / x, accurate for small angles x [rad], too."""
    if abs(angle) < SMALL_TURN:
        squared = angle * angle
        return 0.5 * angle * (1.0 - squared / 12.0), squared / 6.0 * (1.0 - squared / 20.0)
    half = math.sin(0.5 * angle)
    return 2.0 * half * half / angle, 1.0 - math.sin(angle) / angle


@inlined
def _screw_step(axis: Vector, angle: float, p: Vector) -> Vector:
    """Return the velocity u [m] with which a screw by an angle carries the origin to p.

    ``u = p - x/2 a x p + (1 - x/2 cot(x/2)) a x (a x p)``, the inverse of ``_screwed``.
    """
    turned = cross(axis, p)
    twice = cross(axis, turned)
    if angle < SMALL_TURN:
        rest = angle * angle / 12.0 * (1.0 + angle * angle / 60.0)
    else:
        rest = 1.0 - 0.5 * angle / math.tan(0.5 * angle)
    return add(p, add(scale(-0.5 * angle, turned), scale(rest, twice)))


@inlined
def _screwed(axis: Vector, angle: float, u: Vector) -> Vector:
    """Return where a screw by an angle [rad] with the velocity u [m] carries the origin."""
    turned = cross(axis, u)
    twice = cross(axis, turned)
    first, second = versed(angle)
    return add(u, add(scale(first, turned), scale(second, twice)))


@compiled
def prepare_moves(handle: Handle) -> None:
    """Write the ``moves`` of all frames from their start to their end.

    These are the axis [-] and angle [rad] in the axes of F at the start, followed by the
    displacement of Fo in P [m] for ``SLERP``, or its velocity in F at the start [m] for ``SCREW``.
    """
    motion = motions_of(handle)
    for k in range(motion.starts.shape[0]):
        start, end, move = row(motion.starts, k), row(motion.ends, k), row(motion.moves, k)
        axis, angle = _turn_between(start, end)
        step = sub(vector_at(end, POSITION), vector_at(start, POSITION))
        if motion.flags[KIND] == SCREW:
            p_F = unrotate(table(start, 0, 3, 3), step)
            step = _screw_step(axis, angle, p_F)
        for c in range(3):
            move[AXIS + c], move[STEP + c] = axis[c], step[c]
        move[ANGLE] = angle


@inlined
def _write_pose(start: Floats, move: Floats, by_screw: bool, t: float, X: Floats) -> None:
    """Write the pose (POSE_WIDTH,) of a frame at a time; the rotation by Rodrigues' formula."""
    axis, angle = vector_at(move, AXIS), t * move[ANGLE]
    sine, half = math.sin(angle), math.sin(0.5 * angle)
    rest = 2.0 * half * half  # 1 - cosine, without cancellation
    R = table(start, 0, 3, 3)
    for c in range(3):
        e = (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)
        turned = cross(axis, e)
        column = add(e, add(scale(sine, turned), scale(rest, cross(axis, turned))))
        in_P = rotate(R, column)
        X[c], X[3 + c], X[6 + c] = in_P[0], in_P[1], in_P[2]
    step = scale(t, vector_at(move, STEP))
    if by_screw:
        step = rotate(R, _screwed(axis, angle, step))
    for c in range(3):
        X[POSITION + c] = start[POSITION + c] + step[c]


@inlined
def _put_frames(motion: MotionArrays, t: float) -> None:
    """Write the poses of all moving frames at a time to ``Xs``; at both ends exactly as given."""
    by_screw = motion.flags[KIND] == SCREW
    for k in range(motion.starts.shape[0]):
        X = row(motion.Xs, k)
        if 0.0 < t < 1.0:
            _write_pose(row(motion.starts, k), row(motion.moves, k), by_screw, t, X)
            continue
        for c in range(POSE_WIDTH):
            X[c] = motion.starts[k, c] if t == 0.0 else motion.ends[k, c]


@inlined
def _risen(values: Floats, c: int, t: float) -> float:
    """Return the change of a value since the start of a curved edge, by Horner's scheme."""
    change = 0.0
    for power in range(SPEED - 1, POWERS - 1, -1):
        change = t * (values[power, c] + change)
    return change


@inlined
def _put_links(motion: MotionArrays, t: float) -> None:
    """Write the poses of those links that are frames, at a time, to ``poses``."""
    values, curved = motion.values, motion.flags[CURVED] != 0
    for c in range(values.shape[1]):
        start, end = values[FIRST_VALUE, c], values[LAST_VALUE, c]
        if t == 1.0:
            values[NOW, c] = end
        elif curved:
            values[NOW, c] = start + _risen(values, c, t)
        else:
            values[NOW, c] = start + t * (end - start)
    chain = (
        motion.leaders,
        motion.multipliers,
        motion.offsets,
        motion.kinds,
        motion.axes,
        motion.X_PJs,
        motion.chain_parents,
        motion.children,
        motion.X_WLs,
        motion.links,
    )
    pose_links(table(row(values, NOW), 0, 1, values.shape[1]), chain, 0, motion.poses)


@compiled
def put_state(handle: Handle, t: float) -> bool:
    """Pose the world at a time of the motion; return whether all poses are valid."""
    motion = motions_of(handle)
    world: Handle = motion.world
    motion.parameters[ELAPSED] = t
    if motion.flags[KIND] == JOINTS:
        _put_links(motion, t)
        return pose_state(row(motion.poses, 0), motion.rows, motion.Xs, world)
    _put_frames(motion, t)
    if set_poses(motion.rows, motion.Xs, world):
        update(world, 1)
    return True
