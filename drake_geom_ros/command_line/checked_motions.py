"""Results of ``check-motion``, for a path of joint values, a trajectory or a motion file."""

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.batch import Joints, cartesian_speed, check_path, check_trajectory
from drake_geom_ros.batch.path_profile import (
    PathProfile,
    profile_of_path,
    profile_of_spline,
)
from drake_geom_ros.batch.state_files import read_states
from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.scene_input import load_chosen
from drake_geom_ros.common.times import time_between
from drake_geom_ros.geometry import GeometryId, MotionCheck, SceneGraph
from drake_geom_ros.scene_files import LoadedScene, SceneFileError, files_of
from drake_geom_ros.trajectories import JointSpline, read_trajectory
from drake_geom_ros.trajectories.motion_file import load_motion
from drake_geom_ros.viewing.timeline import (
    Timeline,
    checks_between,
    least_pairs,
    leaves_pieces_by,
)

# The straight pieces of a motion are clear; its curve between their ends is not proved.
CLEAR_IN_PIECES = 'clear in pieces'
_OF_PATHS = ('names', 'ignore_start_contacts', 'ignore_limits', 'max_evaluations')


class CheckedMotion(NamedTuple):
    """Check of a whole motion, and the data for its report."""

    check: MotionCheck
    outcome: str  # that of the check, or CLEAR_IN_PIECES
    profile: Callable[[], PathProfile]  # of its pieces
    name_of: Callable[[GeometryId], str]
    remarks: list[str]  # further lines of the report
    unit: str  # of times
    files: list[Path]  # input files of the scene


def of_path(options: argparse.Namespace) -> CheckedMotion:
    """Check a path of joint values; raises GeometryError or OSError for bad input."""
    scene_graph = SceneGraph()
    loaded = load_chosen(options, scene_graph)
    states = read_states(options.path, options.names)
    if states.are_poses:
        raise SceneFileError('--path takes joint values (k, q), not poses', options.path)
    joints = Joints.of(loaded, states.names)
    path = np.array(states.rows[: len(states.rows)])
    question = {
        **_question(options),
        'ignore_start_contacts': options.ignore_start_contacts,
        'ignore_limits': options.ignore_limits,
    }
    check = check_path(
        scene_graph, joints, path, max_evaluations=options.max_evaluations, **question
    )
    return CheckedMotion(
        check=check,
        outcome=check.outcome,
        profile=lambda: profile_of_path(scene_graph, joints, path, options.pieces, **question),
        name_of=loaded.name_of,
        remarks=[],
        unit='rows of the path',
        files=list(files_of(scene_graph, loaded.robots.values())),
    )


def of_trajectory(options: argparse.Namespace) -> CheckedMotion:
    """Check a trajectory along the splines of controllers; errors as of ``of_path``."""
    if options.names:
        raise OSError('--names goes with --path; a trajectory names its joints itself')
    scene_graph = SceneGraph()
    loaded = load_chosen(options, scene_graph)
    names, trajectory = read_trajectory(options.trajectory)
    joints, spline = Joints.of(loaded, _with_robots(names, loaded)), JointSpline(trajectory)
    question = {
        **_question(options),
        'ignore_start_contacts': options.ignore_start_contacts,
        'ignore_limits': options.ignore_limits,
    }
    check = check_trajectory(
        scene_graph, joints, trajectory, max_evaluations=options.max_evaluations, **question
    )
    speeds = spline.speeds()
    fastest, body = int(np.argmax(speeds)), cartesian_speed(scene_graph, joints, spline)
    return CheckedMotion(
        check=check,
        outcome=check.outcome,
        profile=lambda: profile_of_spline(scene_graph, joints, spline, options.pieces, **question),
        name_of=loaded.name_of,
        remarks=[
            f'fastest joint {joints.names[fastest]}, at most {speeds[fastest]:.6g} rad/s or m/s',
            f'fastest body {loaded.name_of(body.geometry)}, at most {body.speed:.6g} m/s',
        ],
        unit='s',
        files=list(files_of(scene_graph, loaded.robots.values())),
    )


def _with_robots(names: Sequence[str], loaded: LoadedScene) -> list[str]:
    """Return the names of joints with their robots, where only one robot has such a joint."""
    robots: dict[str, list[str]] = {}
    for name in Joints.of(loaded).names:
        robots.setdefault(name.split('::', 1)[1], []).append(name)
    return [full[0] if len(full := robots.get(name, [])) == 1 else name for name in names]


def of_motion(options: argparse.Namespace) -> CheckedMotion:
    """Check a motion file in pieces, straight from pose to pose; errors as of ``of_path``."""
    for name in _OF_PATHS:
        if getattr(options, name):
            option = name.replace('_', '-')
            raise OSError(f'--{option} goes with --path or --trajectory, not with --motion')
    posed, count = (
        OpenedScene(options.scene, options.srdf, options.package_root, options.solid),
        options.pieces,
    )
    motion = load_motion(options.motion, posed.description)
    if count < 1 or not motion.duration > 0.0:
        raise SceneFileError(
            f'a motion of {motion.duration:g} s has no {count} pieces', options.motion
        )
    timeline = Timeline.of_motion(motion, posed.loaded.frames, count + 1)
    question = _question(options)
    # Times of a piece go from 0 to 1.
    question['time_tolerance'] = options.time_tolerance / (motion.duration / count)
    checks = list(checks_between(timeline, posed.context, **question))
    check = _of_pieces(checks, timeline)
    far, turned = leaves_pieces_by(timeline)

    def profile() -> PathProfile:
        distances, bounds = np.array(list(least_pairs(timeline, posed.context))).T
        return PathProfile(
            times=timeline.times,
            outcomes=tuple(check.outcome for check in checks),
            lower_bounds=np.array(
                [check.lower_bound if check.outcome == 'clear' else math.nan for check in checks]
            ),
            distances=distances,
            error_bounds=bounds,
        )

    return CheckedMotion(
        check=check,
        outcome=CLEAR_IN_PIECES if check.outcome == 'clear' else check.outcome,
        profile=profile,
        name_of=posed.names.__getitem__,
        remarks=[
            f'pieces {count}, each straight from pose to pose and proved as such: at quarters of '
            f'their time the motion itself is up to {far:.3g} m and {turned:.3g} rad beside them'
        ],
        unit='s',
        files=list(posed.files()),
    )


def _question(options: argparse.Namespace) -> dict[str, Any]:
    return {
        'min_distance': options.min_distance,
        'time_tolerance': options.time_tolerance,
        'accuracy': options.accuracy,
        'bound_tolerance': options.bound_tolerance,
    }


def _of_pieces(checks: list[MotionCheck], timeline: Timeline) -> MotionCheck:
    """Return one check of all pieces up to the first that is not clear; times in seconds."""
    count = next((k for k, each in enumerate(checks) if each.outcome != 'clear'), len(checks) - 1)
    proved, last = checks[: count + 1], checks[count]
    reported = count
    if last.outcome == 'clear':
        reported = int(np.argmin([check.distance for check in proved]))

    def seconds(piece: int, time: float, towards: float | None = None) -> float:
        begin, end = timeline.times[piece : piece + 2].tolist()
        return time_between(begin, end, time, towards)

    times = last.times
    return replace(
        checks[reported],
        outcome=last.outcome,
        times=(seconds(count, times[0], -math.inf), seconds(count, times[1], math.inf)),
        time=seconds(reported, checks[reported].time),
        lower_bound=min(check.lower_bound for check in proved),
        evaluations=sum(check.evaluations for check in proved),
    )
