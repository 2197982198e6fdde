"""The service ``check_motion``: whether a whole motion is clear, of frames or of joints.

It runs in a thread of its own, on a view of the scene of when it was called. What it answers is
what ``QueryObject.CheckMotion`` and ``drake_geom_ros.batch.check_path`` answer; here it gets
names, times in seconds and the form of a message.
"""

from __future__ import annotations

import math
from typing import Any

from drake_geom_ros.geometry import ArgumentError, MotionCheck, accuracy_of
from drake_geom_ros.live.conversions.request_types import CheckMotionRequest
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.robot_following import ends_with_followers
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.services.path_motions import OF_JOINTS, along_path, fill_way
from drake_geom_ros.math.tolerances import TIME_TOLERANCE

OUTCOMES = {'clear': 1, 'contact': 2, 'unknown': 3}  # CLEAR, CONTACT and UNKNOWN of the answer


def check_motion(live: LiveScene, request: CheckMotionRequest, response: Any) -> None:
    """Answer whether a motion is clear; raises RuntimeError to refuse what cannot be asked."""
    if request.accuracy:
        accuracy_of(request.accuracy)
    if not 0.0 <= request.time_tolerance < math.inf:
        raise ArgumentError(
            f'time_tolerance is {request.time_tolerance}; it must be > 0 [s] and finite, and 0 '
            f'stands for {TIME_TOLERANCE:g}'
        )
    paths = request.path, request.multi_dof_path
    by_joints = any(bool(path.joint_names or path.points) for path in paths)
    by_poses = bool(request.end.frame_names or len(request.end.frame_ids))
    if by_joints == by_poses:
        raise ArgumentError(
            f'end and path are {"both given" if by_joints else "both empty"}; end poses the '
            'frames that move, path and multi_dof_path the joints: give one of them'
        )
    way = along_path(live, request, _question(request)) if by_joints else None
    if way is None:
        view, check = _to_poses(live, request)
    else:
        view, check = way.view, way.check
    _fill(response, check, view)
    view.beside.fill(response)
    response.scene_version = view.moment.version
    response.oldest_pose_age = view.moment.oldest_pose_age
    response.stale_frames = view.stale_frames()
    response.message = view.reservations()
    if way is not None:
        fill_way(response, way)


def _question(request: CheckMotionRequest) -> dict[str, Any]:
    """Return the arguments that both kinds of motion have, as the core names them."""
    return {
        'min_distance': request.min_distance,
        'max_evaluations': request.max_evaluations,
        'accuracy': request.accuracy,
        'ignore_start_contacts': request.ignore_start_contacts,
    }


def _to_poses(live: LiveScene, request: CheckMotionRequest) -> tuple[SceneView, MotionCheck]:
    """Check the motion of frames, whose times go from 0 to 1."""
    for name in OF_JOINTS:
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
        **_question(request),
    )
    return view, check


def _fill(response: Any, check: MotionCheck, view: SceneView) -> None:
    """Fill an answer with the result of a check."""
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
