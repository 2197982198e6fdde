"""The service ``check_motion``: whether a whole motion is clear, of frames or of joints.

It runs in a thread of its own, on a view of the scene of when it was called. What it answers is
what ``QueryObject.CheckMotion`` and ``drake_geom_ros.batch.check_path`` answer; here it gets
names, times in seconds and the form of a message.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.paths import PathChecker
from drake_geom_ros.common.counting import counted
from drake_geom_ros.common.times import time_between
from drake_geom_ros.geometry import ACCURACY_LEVELS, ArgumentError, MotionCheck
from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.robot_following import ends_with_followers
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.services.joint_views import GivenJoints, view_of_joints
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import TIME_TOLERANCE

OUTCOMES = {'clear': 1, 'contact': 2, 'unknown': 3}  # CLEAR, CONTACT and UNKNOWN of the answer


class TimedPath(NamedTuple):
    """Rows (k, q) of joint values, and when each is reached (k,) [s]."""

    rows: Floats
    times: Floats

    def time_of(self, place: float, towards: float | None = None) -> float:
        """Return the time [s] of a place by rows, rounded as by ``time_between``."""
        edge = min(int(place), len(self.times) - 2)
        begin, end = self.times[edge : edge + 2].tolist()
        return time_between(begin, end, place - edge, towards)


def check_motion(live: LiveScene, request: Any, response: Any) -> None:
    """Answer whether a motion is clear; raises RuntimeError to refuse what cannot be asked."""
    if request.accuracy not in ('', *ACCURACY_LEVELS):
        allowed = ', '.join(ACCURACY_LEVELS)
        raise ArgumentError(f'accuracy is {request.accuracy!r}; it must be one of {allowed}')
    if not 0.0 <= request.time_tolerance < math.inf:
        raise ArgumentError(
            f'time_tolerance is {request.time_tolerance}; it must be > 0 [s] and finite, and 0 '
            f'stands for {TIME_TOLERANCE:g}'
        )
    by_joints = bool(request.path.joint_names or request.path.points)
    by_poses = bool(request.end.frame_names or len(request.end.frame_ids))
    if by_joints == by_poses:
        raise ArgumentError(
            f'end and path are {"both given" if by_joints else "both empty"}; end poses the '
            'frames that move, path the joints: give one of them'
        )
    view, check, path = (_along_path if by_joints else _to_poses)(live, request)
    _fill(response, check, view, path)
    view.beside.fill(response)
    response.scene_version = view.moment.version
    response.oldest_pose_age = view.moment.oldest_pose_age
    response.stale_frames = view.stale_frames()
    response.message = view.reservations()


def _asked(request: Any) -> dict[str, Any]:
    """Return what is asked of either kind of motion, as the core names it."""
    return {
        'min_distance': request.min_distance,
        'max_evaluations': request.max_evaluations,
        'accuracy': request.accuracy,
        'ignore_start_contacts': request.ignore_start_contacts,
    }


def _to_poses(live: LiveScene, request: Any) -> tuple[SceneView, MotionCheck, None]:
    """Check the motion of frames, whose times go from 0 to 1."""
    if request.ignore_limits:
        raise ArgumentError('ignore_limits is of a motion of joints; `end` moves frames by poses')
    with live.reading() as scene:
        ends = scene.model.reader.read(request.end).poses
        view = live.view(request.start, request.start_joints)
        ends = ends_with_followers(scene, view.query, ends, request.interpolation)
    check = view.query.CheckMotion(
        ends,
        time_tolerance=request.time_tolerance or TIME_TOLERANCE,
        interpolation=request.interpolation or 'slerp',
        **_asked(request),
    )
    return view, check, None


def _along_path(live: LiveScene, request: Any) -> tuple[SceneView, MotionCheck, TimedPath]:
    """Check a motion of joints, straight from point to point."""
    if request.interpolation:
        raise ArgumentError(
            f'interpolation is {request.interpolation!r}; it is of a motion of frames: joints go '
            'straight from point to point'
        )
    start_joints = GivenJoints(request.start_joints.names, request.start_joints.positions)
    names = list(request.path.joint_names)
    view, joints, begin = view_of_joints(live, request.start, names, start_joints)
    path = timed_path(request.path, joints, begin.now)
    if begin.given and len(path.rows) == len(request.path.points):
        raise ArgumentError(
            f'start_joints give {some_of(begin.given)} a value, and so does the first point of '
            'path, which is where it begins; leave them out of one'
        )
    # Within the tolerance in seconds on each edge.
    longest = float(np.diff(path.times).max(initial=0.0)) or 1.0
    with PathChecker(
        view.context,
        joints,
        time_tolerance=(request.time_tolerance or TIME_TOLERANCE) / longest,
        ignore_limits=request.ignore_limits,
        **_asked(request),
    ) as checker:
        return view, checker.check(path.rows), path


def timed_path(trajectory: Any, joints: Joints, start: Floats) -> TimedPath:
    """Return the way of a JointTrajectory; raises ArgumentError for what it cannot be.

    ``start`` (q,) are the values at time 0 where the first point comes later, NaN of joints of
    which nobody knows one. Points without times, all 0, go from time 0 to 1 by equal parts; one
    alone is the end.
    """
    points = trajectory.points
    if not len(points):
        raise ArgumentError('path has joint names and no points; give at least one')
    count = joints.count
    for number, point in enumerate(points):
        _check_point(number, point, count)
    # Number by number: NumPy holds the interpreter's lock while it looks at 100 000 arrays.
    numbers = (number for point in points for number in point.positions)
    rows = np.fromiter(numbers, np.float64, len(points) * count)
    rows = rows.reshape(len(points), count)
    bad = np.argwhere(~np.isfinite(rows))
    if bad.size:
        number, column = bad[0].tolist()
        raise ArgumentError(
            f'point {number} of path: {joints.names[column]} = {rows[number, column]}; positions '
            'must be finite'
        )
    times = np.array([seconds_of(point.time_from_start) for point in points])
    if not times.any():
        if len(points) > 1:
            return TimedPath(rows, np.linspace(0.0, 1.0, len(points)))
        times = np.ones(1)
    steps = np.diff(times)
    if times[0] < 0.0 or (steps <= 0.0).any():
        number = 0 if times[0] < 0.0 else 1 + int(np.argmax(steps <= 0.0))
        raise ArgumentError(
            f'point {number} of path has the time_from_start {times[number]:g} s; times must be '
            '>= 0 and grow from point to point, or all be 0'
        )
    if times[0] > 0.0:
        unknown = [name for name, q in zip(joints.names, start, strict=True) if np.isnan(q)]
        if unknown:
            raise ArgumentError(
                f'path begins at {times[0]:g} s, and nobody knows where {", ".join(unknown)} '
                'are at 0 s: give a point with time_from_start 0, or start_joints'
            )
        rows, times = np.vstack((start, rows)), np.concatenate(([0.0], times))
    return TimedPath(rows, times)


def _check_point(number: int, point: Any, count: int) -> None:
    """Raise ArgumentError for a point of which the positions alone do not say the way."""
    if len(point.positions) != count:
        raise ArgumentError(
            f'point {number} of path has {len(point.positions)} positions for '
            f'{counted(count, "joint")}; it must have one for each'
        )
    for name in ('velocities', 'accelerations', 'effort'):
        if len(getattr(point, name)):
            raise ArgumentError(
                f'point {number} of path has {name}: by these a controller leaves the straight '
                'way between points, which is the one that is checked. Cut the curve into points, '
                f'and leave {name} empty'
            )


def _fill(response: Any, check: MotionCheck, view: SceneView, path: TimedPath | None) -> None:
    """Fill an answer with what is true of a motion, times by a path's where it has any."""
    times, time = check.times, check.time
    if path is not None:
        times = path.time_of(times[0], -math.inf), path.time_of(times[1], math.inf)
        time = path.time_of(time)
    response.outcome = OUTCOMES[check.outcome]
    response.times[:] = times
    response.last_free, response.time = times[0], time
    if check.id_A is not None and check.id_B is not None:
        names = view.names
        response.geometry_a, response.geometry_b = (
            names.geometry_names[id] for id in (check.id_A, check.id_B)
        )
        response.id_a, response.id_b = check.id_A.get_value(), check.id_B.get_value()
        for point, p in ((response.p_wca, check.p_WCa), (response.p_wcb, check.p_WCb)):
            point.x, point.y, point.z = p.tolist()
    response.distance, response.error_bound = check.distance, check.error_bound
    response.lower_bound = check.lower_bound
    response.evaluations, response.ignored = check.evaluations, check.ignored
