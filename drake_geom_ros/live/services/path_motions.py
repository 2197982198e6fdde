"""The part of ``check_motion`` about joints: a path, its approach and its speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drake_geom_ros.batch.joint_trajectories import (
    ClearanceBounds,
    FastestGeometry,
    clearance_bounds,
    fastest_geometry,
    in_seconds,
)
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.paths import PathChecker
from drake_geom_ros.geometry import ArgumentError, MotionCheck
from drake_geom_ros.live.conversions.fields import floats
from drake_geom_ros.live.conversions.message_types import TrajectoryMessage
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.conversions.request_types import CheckMotionRequest
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.services.joint_paths import (
    POINTS,
    START_TOLERANCE,
    PathOfJoints,
    TimedPath,
    for_the_scene,
    refuse_far_start,
    timed_path,
)
from drake_geom_ros.live.services.joint_views import GivenJoints, JointsNow, view_of_joints
from drake_geom_ros.live.services.multi_dof_paths import multi_dof_path
from drake_geom_ros.math.tolerances import TIME_TOLERANCE

# Fields of a request that a motion of frames has no use for.
OF_JOINTS = (
    *('ignore_limits', 'ignore_foreign_joints', 'profile', 'start_tolerance'),
    *('start_now', 'approach_time', 'clearance_intervals'),
)
_MOST_INTERVALS = 10_000


@dataclass(frozen=True)
class JointWay:
    """The path of joints that was checked."""

    view: SceneView
    check: MotionCheck  # times [s]
    path: TimedPath
    joints: Joints
    start: JointsNow
    is_begun_now: bool  # with a way from where the joints are to the first point
    foreign: list[str]  # joints of the request that are none of the scene
    fastest: FastestGeometry
    clearances: ClearanceBounds | None


def along_path(
    live: LiveScene, request: CheckMotionRequest, question: Mapping[str, Any]
) -> JointWay:
    """Check a motion of joints, from point to point; ``question`` is that of ``PathChecker``."""
    _refuse_fields(request)
    start_joints = GivenJoints(request.start_joints.names, request.start_joints.positions)
    trajectory, foreign = for_the_scene(live, request.path, request.ignore_foreign_joints)
    moved = multi_dof_path(live, request.multi_dof_path, request.profile)
    several, names = moved.path, [*trajectory.joint_names, *moved.joint_names]
    parts = live, request.start, names, start_joints, moved.frames
    view, joints, begin = view_of_joints(*parts)
    path = _path(trajectory, several, begin, request.profile)
    points = max(len(trajectory.points), len(several.points))
    if request.start_now:
        path = _begun_now(path, joints, begin, request.approach_time, points)
    elif begin.given and len(path.rows) == points:
        raise ArgumentError(
            f'start_joints give {some_of(begin.given)} a value, and so does the first point of '
            'path, which is where it begins; leave them out of one'
        )
    if not request.start_now and (path.spline is not None or request.start_tolerance > 0.0):
        refuse_far_start(joints.names, path, begin.now, request.start_tolerance or START_TOLERANCE)
    spline = path.as_spline()
    # Within the tolerance in seconds on each edge.
    longest = float(np.diff(path.times).max(initial=0.0)) or 1.0
    with PathChecker(
        view.context,
        joints,
        time_tolerance=(request.time_tolerance or TIME_TOLERANCE) / longest,
        ignore_limits=request.ignore_limits,
        **question,
    ) as checker:
        if path.spline is None:
            check = checker.check(path.rows)
        else:
            check = checker.check_spline(path.spline)
        fastest = fastest_geometry(checker, spline)
    return JointWay(
        view=view,
        check=in_seconds(check, path.times),
        path=path,
        joints=joints,
        start=begin,
        is_begun_now=len(path.rows) > points,
        foreign=foreign,
        fastest=fastest,
        clearances=_clearances(view, joints, spline, request),
    )


def _path(
    trajectory: TrajectoryMessage | PathOfJoints,
    several: PathOfJoints,
    begin: JointsNow,
    profile: str,
) -> TimedPath:
    """Return the way of a path and of planar and floating joints beside it."""
    count = len(trajectory.joint_names)
    paths = []
    if count or len(trajectory.points) or not several.joint_names:
        own = JointsNow(begin.now[:count], begin.speeds[:count], begin.given)
        paths.append(timed_path(trajectory, trajectory.joint_names, own, profile))
    if several.joint_names:
        own = JointsNow(begin.now[count:], begin.speeds[count:], begin.given)
        paths.append(timed_path(several, several.joint_names, own, POINTS))
    first, *others = paths
    return first.beside(*others) if others else first


def _refuse_fields(request: CheckMotionRequest) -> None:
    """Raise ArgumentError for fields that cannot be meant."""
    if request.interpolation:
        raise ArgumentError(
            f'interpolation is {request.interpolation!r}; it is of a motion of frames: joints '
            'follow their path'
        )
    if not request.start_tolerance >= 0.0:
        raise ArgumentError(
            f'start_tolerance is {request.start_tolerance}; it must be >= 0 [rad] or [m], and 0 '
            f'stands for {START_TOLERANCE:g}'
        )
    if request.clearance_intervals > _MOST_INTERVALS:
        raise ArgumentError(
            f'clearance_intervals is {request.clearance_intervals}; at most {_MOST_INTERVALS} '
            'are answered'
        )
    seconds = request.approach_time
    if request.start_now != (0.0 < seconds < math.inf) or (not request.start_now and seconds):
        raise ArgumentError(
            f'start_now is {bool(request.start_now)} and approach_time is {seconds}; with '
            'start_now it is the time > 0 [s] of the way to the first point, else 0'
        )


def _begun_now(
    path: TimedPath, joints: Joints, begin: JointsNow, seconds: float, points: int
) -> TimedPath:
    """Return a path with the way from where the joints are now in front."""
    if len(path.rows) > points:
        raise ArgumentError(
            f'start_now is set, and the first point of path comes at {path.times[1]:g} s: the '
            'path begins where the joints are already. Leave one of them out'
        )
    unknown = [name for name, q in zip(joints.names, begin.now, strict=True) if np.isnan(q)]
    if unknown:
        raise ArgumentError(
            f'start_now is set, and nobody knows where {some_of(unknown)} are now; give '
            'start_joints'
        )
    return path.begun_at(begin.now, float(path.times[0]) - seconds)


def _clearances(
    view: SceneView, joints: Joints, spline: Any, request: CheckMotionRequest
) -> ClearanceBounds | None:
    """Return the requested bounds; evaluations are distributed over the intervals."""
    count = int(request.clearance_intervals)
    if not count:
        return None
    most = request.max_evaluations
    return clearance_bounds(
        view.context,
        joints,
        spline,
        count,
        max_evaluations=max(most // count, 1) if most else 0,
        accuracy=request.accuracy,
        ignore_start_contacts=request.ignore_start_contacts,
    )


def fill_way(response: Any, way: JointWay) -> None:
    """Fill in the fields about a path of joints."""
    speeds = way.path.speeds()
    fastest = int(np.argmax(speeds))
    response.fastest_joint, response.joint_speed = way.joints.names[fastest], speeds[fastest]
    response.fastest_geometry = way.view.names.geometry_names[way.fastest.geometry]
    response.cartesian_speed = way.fastest.speed
    if way.clearances is not None:
        response.clearance_times = floats(way.clearances.times)
        response.clearances = floats(way.clearances.clearances)
    response.foreign_joints = way.foreign
    if way.path.spline is None:
        return
    notes = response.message, _note(way.joints.names, way.start, way.is_begun_now)
    response.message = '; '.join(filter(None, notes))


def _note(joint_names: Sequence[str], start: JointsNow, is_begun_now: bool) -> str:
    """Return in words which start values of a spline are unknown."""
    names = np.array(joint_names)
    if np.isnan(start.now).any():
        return (
            f'nobody knows where {some_of(names[np.isnan(start.now)].tolist())} are now: whether '
            'the path begins there was not judged'
        )
    if is_begun_now and np.isnan(start.speeds).any():
        return (
            f'nobody knows how fast {some_of(names[np.isnan(start.speeds)].tolist())} move now: '
            'the way to the first point begins at rest'
        )
    return ''
