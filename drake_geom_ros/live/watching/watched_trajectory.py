"""A trajectory that a controller executes, as a request of ``watch_trajectory`` states it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from drake_geom_ros.geometry import ArgumentError, accuracy_of
from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.conversions.message_types import TrajectoryMessage
from drake_geom_ros.live.conversions.request_types import WatchTrajectoryRequest
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.services.joint_paths import PathOfJoints, for_the_scene, timed_path
from drake_geom_ros.live.services.joint_views import JointsNow, view_of_joints
from drake_geom_ros.trajectories import JointSpline

DEVIATION_TOLERANCE = 0.05  # [rad] or [m]
_FARTHEST_AHEAD = 60.0  # [s] a start that is later is the time of another clock
_LONGEST_NAME = 200  # characters


@dataclass(frozen=True)
class WatchedTrajectory:
    """A spline of joints with the time of its start, and how its rest is judged."""

    name: str
    joint_names: tuple[str, ...]
    spline: JointSpline  # times [s] since the start
    start: float  # [s] of the node's time
    epoch: int  # of the node's clocks, in which the start holds
    min_distance: float = 0.0  # [m]
    deviation_tolerance: float = DEVIATION_TOLERANCE  # [rad] or [m]
    time_budget: float = 0.0  # [s] of a judgement; 0: no limit
    accuracy: str = ''
    ignore_start_contacts: bool = False
    ignore_limits: bool = False
    foreign_joints: tuple[str, ...] = ()  # of the request, left out

    def elapsed(self, node_time: float) -> float:
        """Return how long [s] it runs at a time [s] of the node; negative: it begins later."""
        return node_time - self.start

    @property
    def end(self) -> float:
        """The time [s] of the last point since the start."""
        return float(self.spline.times[-1])


def watched_trajectory(
    live: LiveScene, request: WatchTrajectoryRequest, name: str
) -> WatchedTrajectory:
    """Return the trajectory of a request; raises RuntimeError for what cannot be watched.

    A first point that comes later than now is reached from where the joints are now.
    """
    _refuse_numbers(request)
    if len(name) > _LONGEST_NAME:
        raise ArgumentError(f'name has {len(name)} characters; at most {_LONGEST_NAME} are taken')
    epoch, node_time = live.clocks.epoch, live.clocks.node()
    if not node_time:
        raise ArgumentError(
            'the time of the node is 0: use_sim_time is set and no message of /clock came yet, so '
            'nobody knows when the trajectory runs'
        )
    start = seconds_of(request.path.header.stamp) or node_time
    elapsed = node_time - start
    if -elapsed > _FARTHEST_AHEAD:
        raise ArgumentError(
            f'path.header.stamp is {-elapsed:.3f} s after the time of the node; at most '
            f'{_FARTHEST_AHEAD:g} s are taken. Is it the time of another clock? 0 stands for now'
        )
    trajectory, foreign = for_the_scene(live, request.path, request.ignore_foreign_joints)
    _, joints, now = view_of_joints(live, None, list(trajectory.joint_names))
    spline = _spline_of(trajectory, joints.names, now, request.profile, max(0.0, elapsed))
    if spline.times[-1] <= elapsed:
        raise ArgumentError(
            f'the last point of path was reached {elapsed - spline.times[-1]:.3f} s ago: nothing '
            'of it is left to be watched. Its header.stamp is the time of its start, 0: now'
        )
    return WatchedTrajectory(
        name=name,
        joint_names=tuple(joints.names),
        spline=spline,
        start=start,
        epoch=epoch,
        min_distance=request.min_distance,
        deviation_tolerance=request.deviation_tolerance or DEVIATION_TOLERANCE,
        time_budget=request.time_budget,
        accuracy=request.accuracy,
        ignore_start_contacts=request.ignore_start_contacts,
        ignore_limits=request.ignore_limits,
        foreign_joints=tuple(foreign),
    )


def _spline_of(
    trajectory: TrajectoryMessage | PathOfJoints,
    joint_names: Sequence[str],
    now: JointsNow,
    profile: str,
    elapsed: float,
) -> JointSpline:
    points = trajectory.points
    if len(points) and not any(seconds_of(point.time_from_start) for point in points):
        raise ArgumentError(
            'no point of path has a time_from_start > 0; a trajectory that runs has times'
        )
    return timed_path(trajectory, joint_names, now, profile, elapsed).as_spline()


def _refuse_numbers(request: WatchTrajectoryRequest) -> None:
    """Raise ArgumentError for numbers that cannot be meant."""
    for name, what in (
        ('min_distance', '[m]'),
        ('deviation_tolerance', f'[rad] or [m], and 0 stands for {DEVIATION_TOLERANCE:g}'),
        ('time_budget', '[s], and 0 is no limit'),
    ):
        value = getattr(request, name)
        if not 0.0 <= value < math.inf:
            raise ArgumentError(f'{name} is {value}; it must be finite and >= 0 {what}')
    if request.accuracy:
        accuracy_of(request.accuracy)
