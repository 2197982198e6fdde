"""The service ``check_motion``: whether a whole motion is clear, of frames or of joints.

It runs in a thread of its own, on a view of the scene of when it was called. What it answers is
what ``QueryObject.CheckMotion`` and ``drake_geom_ros.batch.check_path`` answer; here it gets
names, times in seconds and the form of a message.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.batch.joint_trajectories import in_seconds
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.paths import PathChecker
from drake_geom_ros.geometry import ArgumentError, MotionCheck, accuracy_of
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.robot_following import ends_with_followers
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.services.joint_paths import (
    START_TOLERANCE,
    TimedPath,
    for_the_scene,
    refuse_far_start,
    timed_path,
)
from drake_geom_ros.live.services.joint_views import GivenJoints, JointsNow, view_of_joints
from drake_geom_ros.math.tolerances import TIME_TOLERANCE

OUTCOMES = {'clear': 1, 'contact': 2, 'unknown': 3}  # CLEAR, CONTACT and UNKNOWN of the answer


class JointWay(NamedTuple):
    """The path of joints that was checked."""

    path: TimedPath
    joints: Joints
    start: JointsNow
    is_begun_now: bool  # with a way from where the joints are to the first point
    foreign: list[str]  # joints of the request that are none of the scene


def check_motion(live: LiveScene, request: Any, response: Any) -> None:
    """Answer whether a motion is clear; raises RuntimeError to refuse what cannot be asked."""
    if request.accuracy:
        accuracy_of(request.accuracy)
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
    view, check, way = (_along_path if by_joints else _to_poses)(live, request)
    _fill(response, check, view)
    view.beside.fill(response)
    response.scene_version = view.moment.version
    response.oldest_pose_age = view.moment.oldest_pose_age
    response.stale_frames = view.stale_frames()
    response.message = view.reservations()
    if way is not None:
        _fill_way(response, way)


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
    for name in ('ignore_limits', 'ignore_foreign_joints', 'profile', 'start_tolerance'):
        if getattr(request, name):
            raise ArgumentError(f'{name} is of a motion of joints; `end` moves frames by poses')
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


def _along_path(live: LiveScene, request: Any) -> tuple[SceneView, MotionCheck, JointWay]:
    """Check a motion of joints, from point to point."""
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
    start_joints = GivenJoints(request.start_joints.names, request.start_joints.positions)
    trajectory, foreign = for_the_scene(live, request.path, request.ignore_foreign_joints)
    names = list(trajectory.joint_names)
    view, joints, begin = view_of_joints(live, request.start, names, start_joints)
    path = timed_path(trajectory, joints, begin, request.profile)
    if begin.given and len(path.rows) == len(trajectory.points):
        raise ArgumentError(
            f'start_joints give {some_of(begin.given)} a value, and so does the first point of '
            'path, which is where it begins; leave them out of one'
        )
    if path.spline is not None or request.start_tolerance > 0.0:
        refuse_far_start(joints, path, begin.now, request.start_tolerance or START_TOLERANCE)
    # Within the tolerance in seconds on each edge.
    longest = float(np.diff(path.times).max(initial=0.0)) or 1.0
    with PathChecker(
        view.context,
        joints,
        time_tolerance=(request.time_tolerance or TIME_TOLERANCE) / longest,
        ignore_limits=request.ignore_limits,
        **_asked(request),
    ) as checker:
        if path.spline is None:
            check = checker.check(path.rows)
        else:
            check = checker.check_spline(path.spline)
    check = in_seconds(check, path.times)
    is_begun_now = len(path.rows) > len(trajectory.points)
    return view, check, JointWay(path, joints, begin, is_begun_now, foreign)


def _fill_way(response: Any, way: JointWay) -> None:
    """Fill an answer with what belongs to a path of joints."""
    speeds = way.path.speeds()
    fastest = int(np.argmax(speeds))
    response.fastest_joint, response.joint_speed = way.joints.names[fastest], speeds[fastest]
    response.foreign_joints = way.foreign
    if way.path.spline is None:
        return
    names, start = np.array(way.joints.names), way.start
    note = ''
    if np.isnan(start.now).any():
        note = (
            f'nobody knows where {some_of(names[np.isnan(start.now)].tolist())} are now: whether '
            'the path begins there was not judged'
        )
    elif way.is_begun_now and np.isnan(start.speeds).any():
        note = (
            f'nobody knows how fast {some_of(names[np.isnan(start.speeds)].tolist())} move now: '
            'the way to the first point begins at rest'
        )
    response.message = '; '.join(filter(None, (response.message, note)))


def _fill(response: Any, check: MotionCheck, view: SceneView) -> None:
    """Fill an answer with what is true of a motion."""
    response.outcome = OUTCOMES[check.outcome]
    response.times[:] = check.times
    response.last_free, response.time = check.times[0], check.time
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
