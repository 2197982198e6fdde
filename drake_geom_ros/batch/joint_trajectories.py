"""``check_trajectory``: a continuous check of the curve on which a controller takes joints."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.paths import PathChecker
from drake_geom_ros.common.times import time_between
from drake_geom_ros.geometry import (
    AccuracyLike,
    ArgumentError,
    GeometryId,
    MotionCheck,
    SceneGraph,
    SceneGraphContext,
)
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import CLEARANCE_TOLERANCE, TIME_TOLERANCE
from drake_geom_ros.trajectories.joint_spline import JointSpline, JointTrajectory


def check_trajectory(
    scene_graph: SceneGraph | SceneGraphContext,
    joints: Joints,
    trajectory: JointTrajectory,
    min_distance: float = 0.0,
    time_tolerance: float = TIME_TOLERANCE,
    max_evaluations: int = 0,
    *,
    accuracy: AccuracyLike = '',
    ignore_start_contacts: bool = False,
    ignore_limits: bool = False,
    bound_tolerance: float = math.inf,
) -> MotionCheck:
    """Return whether a trajectory is clear as a controller executes it, for all times.

    Each segment is followed on its own polynomial, not on a chord: straight without velocities,
    cubic with velocities, quintic with accelerations too (``JointSpline``). The certified bounds
    of a motion use closed bounds of the polynomial's derivatives on each segment.

    Args:
        scene_graph: The scene, or a context of it.
        joints: The columns of the trajectory.
        trajectory: Points with times [s]; ``velocities`` and ``accelerations`` may be None.
        min_distance: Pairs are clear while they are farther apart [m].
        time_tolerance: The longest span [s] that may hold the first contact.
        max_evaluations: Of pairs by kernels; 0: no limit.
        accuracy: The level, or a length [m]; empty: that of the scene.
        ignore_start_contacts: Leave out pairs that are not clear at the start.
        ignore_limits: Let joints pass their limits.
        bound_tolerance: As in ``check_path`` [m].

    Returns:
        A result as that of ``check_path``, with times [s] of the trajectory.

    Raises:
        ArgumentError: For a trajectory that cannot be meant, and for one that leaves the limits of
            a joint, at a point or between two, unless ``ignore_limits``.
    """
    spline = JointSpline(trajectory)
    longest = float(np.diff(spline.times).max(initial=0.0)) or 1.0
    with PathChecker(
        scene_graph,
        joints,
        min_distance,
        time_tolerance / longest,
        max_evaluations,
        accuracy=accuracy,
        ignore_start_contacts=ignore_start_contacts,
        ignore_limits=ignore_limits,
        bound_tolerance=bound_tolerance,
    ) as checker:
        return in_seconds(checker.check_spline(spline), spline.times)


class ClearanceBounds(NamedTuple):
    """Certified bounds of the clearance of a trajectory, by intervals of its time."""

    times: Floats  # (k + 1,) [s]
    clearances: Floats  # (k,) [m] no pair is nearer within the interval; -inf: nothing is proved


def clearance_bounds(
    scene_graph: SceneGraph | SceneGraphContext,
    joints: Joints,
    trajectory: JointTrajectory | JointSpline,
    intervals: int = 100,
    tolerance: float = CLEARANCE_TOLERANCE,
    **options: Any,
) -> ClearanceBounds:
    """Return bounds of the clearance of a trajectory in intervals of equal time.

    Args:
        scene_graph: The scene, or a context of it.
        joints: The columns of the trajectory.
        trajectory: As for ``check_trajectory``, or its spline.
        intervals: How many, at least 1.
        tolerance: Bounds are at most this [m] below the smallest distance that was computed,
            unless rounding or ``max_evaluations`` ends the proof earlier.
        options: ``max_evaluations`` of each interval, ``accuracy`` and ``ignore_start_contacts``
            as of ``check_trajectory``. Limits of joints are not looked at.

    Returns:
        Times and bounds. An interval in which bodies touch has the bound -inf.

    Raises:
        ArgumentError: For less than one interval, and as ``check_trajectory``.
    """
    if intervals < 1:
        raise ArgumentError(f'intervals={intervals} must be at least 1')
    spline = trajectory if isinstance(trajectory, JointSpline) else JointSpline(trajectory)
    times = np.linspace(spline.times[0], spline.times[-1], intervals + 1)
    with PathChecker(
        scene_graph, joints, 0.0, bound_tolerance=tolerance, ignore_limits=True, **options
    ) as checker:
        checks = checker.check_between(spline, times)
    bounds = [check.lower_bound if check.outcome == 'clear' else -math.inf for check in checks]
    return ClearanceBounds(times, np.array(bounds))


class FastestGeometry(NamedTuple):
    """The geometry with the largest bound of the speed of its points, and that bound."""

    geometry: GeometryId
    speed: float  # [m/s] certified: no point of any geometry is faster at any time


def cartesian_speed(
    scene_graph: SceneGraph | SceneGraphContext,
    joints: Joints,
    trajectory: JointTrajectory | JointSpline,
) -> FastestGeometry:
    """Return an upper bound of the speed of all points of all geometries along a trajectory.

    The speed in the world counts, as ISO/TS 15066 has it. The bound adds up the largest speed of
    each joint in a segment times the reach from its axis (Craig, Introduction to Robotics, 3rd
    ed., equation 5.13), so it is no less than the truth, and larger where an arm is bent.

    Raises ArgumentError as ``check_trajectory``.
    """
    spline = trajectory if isinstance(trajectory, JointSpline) else JointSpline(trajectory)
    with PathChecker(scene_graph, joints, ignore_limits=True) as checker:
        return fastest_geometry(checker, spline)


def fastest_geometry(checker: PathChecker, spline: JointSpline) -> FastestGeometry:
    """Return the bound of ``cartesian_speed`` by a checker that is prepared already."""
    speeds, geometries = checker.speeds(spline)
    fastest = int(np.argmax(speeds))
    return FastestGeometry(geometries[fastest], float(speeds[fastest]))


def in_seconds(check: MotionCheck, times: Floats) -> MotionCheck:
    """Return a result with times [s] instead of rows of a path, which are reached at ``times``."""
    first, last = (
        _time_of(place, times, towards)
        for place, towards in zip(check.times, (-math.inf, math.inf), strict=True)
    )
    return replace(check, times=(first, last), time=_time_of(check.time, times, None))


def _time_of(place: float, times: Floats, towards: float | None) -> float:
    """Return the time [s] of a place by rows, rounded as by ``time_between``."""
    if len(times) == 1:
        return float(times[0])
    edge = min(int(place), len(times) - 2)
    begin, end = times[edge : edge + 2].tolist()
    return time_between(begin, end, place - edge, towards)
