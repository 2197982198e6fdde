"""Result of a motion check by a node, and the trajectory message of its request."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from rclpy.duration import Duration
from trajectory_msgs.msg import (
    JointTrajectory,
    JointTrajectoryPoint,
    MultiDOFJointTrajectory,
)

from drake_geom_ros.math.array_types import Floats

_OUTCOMES = ('refused', 'clear', 'contact', 'unknown')


class Motion(NamedTuple):
    """Verdict on a whole motion, certified for all times; see ``batch.check_path``.

    ``outcome`` is one of

    - ``'clear'``: every pair stays beyond ``min_distance`` and at least ``lower_bound`` apart;
    - ``'contact'``: clear until ``times[0]``, in contact at ``times[1]``;
    - ``'unknown'``: clear until ``times[0]``, nothing is proved from there on.

    ``bool()`` of a motion raises TypeError: compare ``outcome`` instead.
    """

    outcome: str
    times: tuple[float, float]  # [s] that hold the first contact
    last_free: float  # [s] the motion is certified until then
    names: tuple[str, str]  # of the reported pair, as source::frame/geometry; empty: none
    ids: tuple[int, int]  # 0: none
    distance: float  # [m] of this pair at ``time``
    error_bound: float  # [m]
    time: float  # [s]
    p_WCa: Floats  # (3,) [m] nearest points at that time
    p_WCb: Floats
    lower_bound: float  # [m] certified for the whole certified part
    evaluations: int
    ignored: int  # pairs left out because they were not clear at the start
    fastest_joint: str  # of a path
    joint_speed: float  # [rad/s] or [m/s] certified: no joint of the path is faster
    fastest_geometry: str  # of a path
    cartesian_speed: float  # [m/s] certified: no point of any geometry is faster
    clearance_times: Floats  # (k + 1,) [s] bounds of the intervals that were asked for
    clearances: Floats  # (k,) [m] certified: no pair is nearer in an interval; -inf: not proved
    foreign_joints: tuple[str, ...]  # of a path: left out, since no robot of the scene has them
    scene_version: int
    oldest_pose_age: float  # [s] of the oldest frame pose used; inf: unknown
    stale_frames: tuple[str, ...]  # frames whose live pose is stale and used; at most 20

    def __bool__(self) -> bool:
        """Raise TypeError: an unknown outcome is neither true nor false."""
        raise TypeError("a Motion is neither true nor false: ask whether outcome == 'clear'")

    @classmethod
    def of(cls, answer: Any) -> Motion:
        """Return the motion of a check_motion response."""
        begin, end = answer.times
        return cls(
            outcome=_OUTCOMES[answer.outcome],
            times=(float(begin), float(end)),
            last_free=answer.last_free,
            names=(answer.geometry_a, answer.geometry_b),
            ids=(answer.id_a, answer.id_b),
            distance=answer.distance,
            error_bound=answer.error_bound,
            time=answer.time,
            p_WCa=np.array([answer.p_wca.x, answer.p_wca.y, answer.p_wca.z]),
            p_WCb=np.array([answer.p_wcb.x, answer.p_wcb.y, answer.p_wcb.z]),
            lower_bound=answer.lower_bound,
            evaluations=answer.evaluations,
            ignored=answer.ignored,
            fastest_joint=answer.fastest_joint,
            joint_speed=answer.joint_speed,
            fastest_geometry=answer.fastest_geometry,
            cartesian_speed=answer.cartesian_speed,
            clearance_times=np.array(answer.clearance_times),
            clearances=np.array(answer.clearances),
            foreign_joints=tuple(answer.foreign_joints),
            scene_version=answer.scene_version,
            oldest_pose_age=answer.oldest_pose_age,
            stale_frames=tuple(answer.stale_frames),
        )


def joint_trajectory(
    joint_names: Sequence[str],
    path: ArrayLike,
    times: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    accelerations: ArrayLike | None = None,
) -> JointTrajectory:
    """Return a path (k, q) [rad] or [m] as a message; ``times`` (k,) [s], to the nanosecond.

    ``velocities`` and ``accelerations`` are (k, q), too. Raises ValueError if numbers of rows
    differ.
    """
    rows = np.atleast_2d(np.asarray(path, dtype=np.float64))
    seconds = np.zeros(len(rows)) if times is None else np.asarray(times, dtype=np.float64)
    if seconds.shape != (len(rows),):
        raise ValueError(
            f'times has the shape {seconds.shape}; a path of {len(rows)} rows has ({len(rows)},)'
        )
    derivatives = [_derivative_rows(each, rows) for each in (velocities, accelerations)]
    points = [
        JointTrajectoryPoint(
            positions=row.tolist(),
            velocities=velocity,
            accelerations=acceleration,
            time_from_start=Duration(nanoseconds=round(time * 1e9)).to_msg(),
        )
        for row, time, velocity, acceleration in zip(
            rows, seconds.tolist(), *derivatives, strict=True
        )
    ]
    return JointTrajectory(joint_names=list(joint_names), points=points)


def _derivative_rows(values: ArrayLike | None, path: Floats) -> list[list[float]]:
    """Return derivatives (k, q) by rows, empty ones for None; raises ValueError."""
    if values is None:
        return [[]] * len(path)
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape != path.shape:
        raise ValueError(
            f'velocities or accelerations have the shape {rows.shape}; the path has {path.shape}'
        )
    listed: list[list[float]] = rows.tolist()
    return listed


def paths_of(message: Any) -> tuple[JointTrajectory, MultiDOFJointTrajectory]:
    """Return the two parts of a trajectory that a planner made.

    ``message`` is a ``moveit_msgs/RobotTrajectory`` or a ``trajectory_msgs/JointTrajectory``.
    Raises TypeError for another one.
    """
    if isinstance(message, JointTrajectory):
        return message, MultiDOFJointTrajectory()
    try:
        return message.joint_trajectory, message.multi_dof_joint_trajectory
    except AttributeError:
        raise TypeError(
            f'trajectory is a {type(message).__name__}; it must be a JointTrajectory or a '
            'RobotTrajectory'
        ) from None
