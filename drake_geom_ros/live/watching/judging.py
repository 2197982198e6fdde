"""Judges the rest of a trajectory against the scene of now, and remembers what that rests on."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from drake_geom_ros.batch.joint_trajectories import in_seconds
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.paths import PathChecker
from drake_geom_ros.geometry import MotionCheck
from drake_geom_ros.geometry.queries.scene_mark import SceneMark
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.robot_joints import JointPlace
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.live.services.joint_views import view_of_joints
from drake_geom_ros.live.watching.watched_trajectory import WatchedTrajectory
from drake_geom_ros.math.tolerances import TIME_TOLERANCE


class Basis:
    """The state that a judgement rests on, but for the joints of the trajectory, which go on.

    That is the content of the scene, its filters, the poses of all frames that these joints do not
    move, and the values of the other joints of the same robots.
    """

    def __init__(self, scene: HeldScene, joints: Joints, places: list[JointPlace]) -> None:
        self._mark = SceneMark(scene.model.context, joints.id_values)
        self._context, self._places = scene.model.context, frozenset(places)
        self._robots = sorted({place.robot for place in places})
        self._versions = self._versions_of(scene)
        self._values = self._values_of(scene)

    def holds(self, scene: HeldScene) -> bool:
        """Return whether a judgement of then is one of now."""
        return (
            scene.model.context is self._context
            and self._versions_of(scene) == self._versions
            and self._mark.is_of_now()
            and self._values_of(scene) == self._values
        )

    def _versions_of(self, scene: HeldScene) -> tuple[int, int]:
        return scene.replaced, scene.model.version

    def _values_of(self, scene: HeldScene) -> bytes:
        robots = scene.model.joints.robots
        values = [
            robots[name].positions()[
                [
                    column
                    for column in range(len(robots[name].joint_names))
                    if JointPlace(name, column) not in self._places
                ]
            ]
            for name in self._robots
            if name in robots
        ]
        return b''.join(each.tobytes() for each in values)


@dataclass(frozen=True)
class Judgement:
    """The proof about the rest of a trajectory, and its scene."""

    check: MotionCheck  # times [s] since the start of the trajectory
    begin: float  # [s] since the start, from which on it holds
    view: SceneView
    basis: Basis
    moving: frozenset[int]  # frames that its joints move, by the values of their ids

    def is_unproved(self) -> bool:
        """Return whether a limit of time or evaluations ended it before its end."""
        return self.check.outcome == 'unknown' and self.check.id_A is None

    def missing(self) -> str:
        """Return in words what the proof leaves out, so that nothing is clear."""
        view = self.view
        said = view.waiting().in_words(), view.unknown_ages.in_words()
        return '; '.join(filter(None, said))

    def stale_frames(self, stale: StaleNow) -> str:
        """Return in words whose poses are stale by now; the trajectory's joints have ages too."""
        if not stale.ages:
            return ''
        replaced = self.moving - stale.links
        names = sorted(replace(self.view, stale=stale.ages, replaced=replaced).stale_frames())
        return f'poses are stale: {some_of(names)}' if names else ''


class StaleNow(NamedTuple):
    """Frames and joints that are stale by now."""

    ages: Mapping[int, float]  # [s] of frames, by the values of their ids
    links: frozenset[int]  # frames of links that joints beside those of a trajectory move

    @classmethod
    def of(cls, live: LiveScene, scene: HeldScene, places: list[JointPlace]) -> StaleNow:
        """Return what is stale, beside the joints at ``places``."""
        limit, poses = live.stale_after, scene.poses
        ages = scene.maps.among_stale(poses.ages.stale(limit), poses.since, scene.clocks)
        if not ages:
            return cls({}, frozenset())
        return cls(ages, frozenset(poses.links_of_stale_joints(limit, set(places))))


def judge(live: LiveScene, watched: WatchedTrajectory, must_stop: Callable[[], bool]) -> Judgement:
    """Return what is proved of the rest of a trajectory in the scene of now.

    Raises RuntimeError where it cannot be judged, such as for a robot that is gone, and
    InterruptedError soon after ``must_stop()`` is true.
    """
    started = time.monotonic()
    names = list(watched.joint_names)
    with live.reading() as scene:
        begin = max(float(watched.spline.times[0]), watched.elapsed(live.clocks.node()))
        view, joints, _ = view_of_joints(live, None, names)
        basis = Basis(scene, joints, scene.model.joints.places(names))
    rest = watched.spline.rest(min(begin, np.nextafter(watched.end, -np.inf)))
    longest = float(np.diff(rest.times).max())
    with PathChecker(
        view.context,
        joints,
        watched.min_distance,
        TIME_TOLERANCE / longest,
        accuracy=watched.accuracy,
        ignore_start_contacts=watched.ignore_start_contacts,
        ignore_limits=True,  # they were looked at when the watch began
    ) as checker:
        # Where preparing took all of the time nothing is proved.
        budget = watched.time_budget or math.inf
        seconds = max(budget - (time.monotonic() - started), 0.0)
        check = checker.check_spline_within(rest, seconds, must_stop)
    moving = frozenset(joints.id_values.tolist())
    return Judgement(in_seconds(check, rest.times), begin, view, basis, moving)


def refuse_limits(live: LiveScene, watched: WatchedTrajectory) -> None:
    """Raise ArgumentError for a trajectory that leaves the limits of a joint."""
    if watched.ignore_limits:
        return
    view, joints, _ = view_of_joints(live, None, list(watched.joint_names))
    with PathChecker(view.context, joints) as checker:
        checker.refuse_limits(watched.spline)
