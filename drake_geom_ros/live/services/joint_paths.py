"""A JointTrajectory of a request as the way on which a controller takes the joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.conversions.message_types import (
    TimeMessage,
    TrajectoryMessage,
    TrajectoryPointMessage,
)
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.services.joint_views import JointsNow
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.trajectories import JointSpline, JointTrajectory

POINTS, SPLINE = 'points', 'spline'
PROFILES = POINTS, SPLINE
START_TOLERANCE = 0.01  # [rad] or [m], as MoveIt's allowed_start_tolerance


class TimedPath(NamedTuple):
    """Rows (k, q) of joint values, and when each is reached (k,) [s].

    The way is straight from row to row, or follows ``spline``.
    """

    rows: Floats
    times: Floats
    spline: JointSpline | None = None

    def as_spline(self) -> JointSpline:
        """Return the way as a spline, which is straight where it has no other one."""
        return self.spline or JointSpline(JointTrajectory(self.times, self.rows))

    def beside(self, other: TimedPath) -> TimedPath:
        """Return the way of the joints of both; raises ArgumentError for other times."""
        if not np.array_equal(self.times, other.times):
            raise ArgumentError(
                f'multi_dof_path has points at {_listed(other.times)} s, and path at '
                f'{_listed(self.times)} s; they must have the same times'
            )
        rows = np.hstack((self.rows, other.rows))
        if self.spline is None and other.spline is None:
            return TimedPath(rows, self.times)
        return TimedPath(rows, self.times, self.as_spline().beside(other.as_spline()))

    def begun_at(self, values: Floats, time: float) -> TimedPath:
        """Return the way with a straight one from values (q,) in front, from a time [s] on."""
        spline = None if self.spline is None else self.spline.begun_at(values, time)
        rows, times = np.vstack((values, self.rows)), np.concatenate(([time], self.times))
        return TimedPath(rows, times, spline)

    def speeds(self) -> Floats:
        """Return an upper bound (q,) of the speed of each joint [rad/s] or [m/s]."""
        if self.spline is not None:
            return self.spline.speeds()
        steps = np.abs(np.diff(self.rows, axis=0)) / np.diff(self.times)[:, None]
        return np.asarray(steps.max(axis=0, initial=0.0))


def _listed(times: Floats) -> str:
    return some_of([f'{time:g}' for time in times.tolist()])


def for_the_scene(
    live: LiveScene, trajectory: TrajectoryMessage, ignore_foreign_joints: bool
) -> tuple[TrajectoryMessage | PathOfJoints, list[str]]:
    """Return a trajectory message for the joints of the scene, and the names of others.

    These are left in unless they are to be ignored, so that whoever looks them up refuses them.
    """
    if not ignore_foreign_joints:
        return trajectory, []
    names = list(trajectory.joint_names)
    with live.reading() as scene:
        is_known = scene.model.joints.are_known(names)
    foreign = [name for name, is_joint in zip(names, is_known, strict=True) if not is_joint]
    return (_without_columns(trajectory, is_known), foreign) if foreign else (trajectory, [])


def _without_columns(trajectory: TrajectoryMessage, is_known: Sequence[bool]) -> PathOfJoints:
    """Return a trajectory message with the joints that are known alone.

    Raises ArgumentError where none is, and for a point that has not a number for each joint.
    """
    names = [
        name for name, is_joint in zip(trajectory.joint_names, is_known, strict=True) if is_joint
    ]
    if not names:
        raise ArgumentError(
            f'path is of {some_of(list(trajectory.joint_names))}, none of which is a joint of the '
            'scene: nothing of it could be checked'
        )
    points = []
    for number, point in enumerate(trajectory.points):
        _check_lengths(number, point, len(is_known))
        points.append(
            PathPoint(
                _chosen(point.positions, is_known),
                _chosen(point.velocities, is_known),
                _chosen(point.accelerations, is_known),
                point.time_from_start,
            )
        )
    return PathOfJoints(names, points)


class PathPoint(NamedTuple):
    """A point of a path as a JointTrajectory has it."""

    positions: list[float]
    velocities: list[float]
    accelerations: list[float]
    time_from_start: TimeMessage


Points: TypeAlias = Sequence[TrajectoryPointMessage | PathPoint]


class PathOfJoints(NamedTuple):
    """A path as a JointTrajectory has it."""

    joint_names: list[str]
    points: list[PathPoint]


def _chosen(values: Sequence[float], is_known: Sequence[bool]) -> list[float]:
    return (
        [v for v, is_joint in zip(values, is_known, strict=True) if is_joint]
        if len(values)
        else []
    )


def timed_path(
    trajectory: TrajectoryMessage | PathOfJoints,
    names: Sequence[str],
    start: JointsNow,
    profile: str,
    start_time: float = 0.0,
) -> TimedPath:
    """Return the way of a JointTrajectory; raises ArgumentError for what it cannot be.

    ``start`` has the values at ``start_time`` [s]. Where the first point comes later, the way
    begins there; a spline then begins with the speeds of now, 0 where nobody knows one. Points
    without times, all 0, go from time 0 to 1 by equal parts; one alone is the end. An empty
    ``profile`` is that of splines where a point has velocities.
    """
    points: Points = trajectory.points
    if not len(points):
        raise ArgumentError('path has joint names and no points; give at least one')
    if profile not in ('', *PROFILES):
        allowed = ', '.join(PROFILES)
        raise ArgumentError(
            f'profile is {profile!r}; it must be one of {allowed}, or empty: {SPLINE} where '
            f'points have velocities, else {POINTS}'
        )
    for number, point in enumerate(points):
        _check_lengths(number, point, len(names))
    rows = _rows_of(points, names)
    times = np.array([seconds_of(point.time_from_start) for point in points])
    if profile == SPLINE or (not profile and _has_derivatives(points)):
        return _spline_path(points, names, rows, times, start, start_time)
    if not times.any():
        if len(points) > 1:
            return TimedPath(rows, np.linspace(0.0, 1.0, len(points)))
        times = np.ones(1)
    _refuse_times(times)
    if times[0] > start_time:
        _refuse_unknown(times[0], names, start.now, start_time)
        rows, times = np.vstack((start.now, rows)), np.concatenate(([start_time], times))
    return TimedPath(rows, times)


def _spline_path(
    points: Points,
    names: Sequence[str],
    rows: Floats,
    times: Floats,
    start: JointsNow,
    start_time: float,
) -> TimedPath:
    """Return the way along splines, whose points must have times."""
    if not times.any():
        raise ArgumentError(
            'the points of path have velocities and no time_from_start: a spline needs times. '
            f'Give them, or profile {POINTS!r}, which goes straight from point to point'
        )
    _refuse_times(times)
    velocities = _derivatives(points, 'velocities', names)
    accelerations = _derivatives(points, 'accelerations', names)
    if times[0] > start_time:
        _refuse_unknown(times[0], names, start.now, start_time)
        rows, times = np.vstack((start.now, rows)), np.concatenate(([start_time], times))
        velocities = _begun_with(np.nan_to_num(start.speeds), velocities)
        accelerations = _begun_with(np.zeros(len(names)), accelerations)
    spline = JointSpline(JointTrajectory(times, rows, velocities, accelerations))
    return TimedPath(rows, times, spline)


def _begun_with(start: Floats, derivatives: Floats) -> Floats:
    """Return derivatives after those of a start (q,); NaN if the first point has none."""
    first = np.where(np.isnan(derivatives[:1]), np.nan, start)
    return np.asarray(np.vstack((first, derivatives)))


def _has_derivatives(points: Points) -> bool:
    return any(len(point.velocities) or len(point.accelerations) for point in points)


def _rows_of(points: Points, names: Sequence[str]) -> Floats:
    # Number by number: NumPy holds the interpreter's lock while it looks at 100 000 arrays.
    numbers = (number for point in points for number in point.positions)
    rows = np.fromiter(numbers, np.float64, len(points) * len(names))
    rows = rows.reshape(len(points), len(names))
    bad = np.argwhere(~np.isfinite(rows))
    if bad.size:
        number, column = bad[0].tolist()
        raise ArgumentError(
            f'point {number} of path: {names[column]} = {rows[number, column]}; positions '
            'must be finite'
        )
    return rows


def _derivatives(points: Points, name: str, names: Sequence[str]) -> Floats:
    """Return derivatives (k, q), NaN of points that have none; raises ArgumentError."""
    rows = np.full((len(points), len(names)), np.nan)
    for number, point in enumerate(points):
        values = getattr(point, name)
        if not len(values):
            continue
        rows[number] = values
        if not np.isfinite(rows[number]).all():
            raise ArgumentError(
                f'point {number} of path has the {name} {rows[number].tolist()}; they must be '
                'finite, or left out'
            )
        if name == 'accelerations' and not len(point.velocities):
            raise ArgumentError(
                f'point {number} of path has accelerations and no velocities; a quintic needs both'
            )
    return rows


def _refuse_times(times: Floats) -> None:
    """Raise ArgumentError for times [s] that do not grow."""
    steps = np.diff(times)
    if times[0] < 0.0 or (steps <= 0.0).any():
        number = 0 if times[0] < 0.0 else 1 + int(np.argmax(steps <= 0.0))
        raise ArgumentError(
            f'point {number} of path has the time_from_start {times[number]:g} s; times must be '
            '>= 0 and grow from point to point, or all be 0'
        )


def _refuse_unknown(first: float, names: Sequence[str], start: Floats, time: float) -> None:
    """Raise ArgumentError if the start of a path is unknown."""
    unknown = [name for name, q in zip(names, start, strict=True) if np.isnan(q)]
    if unknown:
        raise ArgumentError(
            f'path begins at {first:g} s, and nobody knows where {", ".join(unknown)} '
            f'are at {time:g} s: give a point with time_from_start 0, or start_joints'
        )


def refuse_far_start(names: Sequence[str], path: TimedPath, now: Floats, tolerance: float) -> None:
    """Raise ArgumentError where a joint is not where a path begins, within a tolerance."""
    far = np.abs(path.rows[0] - now)
    if (far > tolerance).any():
        column = int(np.nanargmax(far))
        raise ArgumentError(
            f'path begins with {names[column]} = {path.rows[0, column]:.6g}, and the joint '
            f'is at {now[column]:.6g} now, which is {far[column]:.3g} away; at most '
            f'{tolerance:g} is allowed (start_tolerance). Give the first point a time_from_start '
            'later than 0 to begin where the joints are, or start_joints for another beginning'
        )


def _check_lengths(number: int, point: TrajectoryPointMessage | PathPoint, count: int) -> None:
    """Raise ArgumentError for a point that has not a number for each joint."""
    if len(point.positions) != count:
        raise ArgumentError(
            f'point {number} of path has {len(point.positions)} positions for '
            f'{counted(count, "joint")}; it must have one for each'
        )
    for name in ('velocities', 'accelerations'):
        if len(getattr(point, name)) not in (0, count):
            raise ArgumentError(
                f'point {number} of path has {len(getattr(point, name))} {name} for '
                f'{counted(count, "joint")}; it must have one for each, or none'
            )
