"""Deviation of joints from a trajectory."""

from __future__ import annotations

import math
from typing import NamedTuple

from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.robot_joints import JointPlace
from drake_geom_ros.live.watching.watched_trajectory import WatchedTrajectory


class Following(NamedTuple):
    """The deviation of joints from a trajectory."""

    deviation: float  # [rad] or [m] of the joint that is farthest from it; nan: no value
    joint: str  # that one
    silent: tuple[str, ...]  # joints whose values are stale or of which none came

    def deviates(self, tolerance: float) -> bool:
        """Return whether a joint is farther from the trajectory than a tolerance."""
        return self.deviation > tolerance


def following(
    scene: HeldScene, watched: WatchedTrajectory, places: list[JointPlace], stale_after: float
) -> Following:
    """Return how well joints follow a trajectory by their last values.

    Each value is compared with the trajectory at the time of its stamp, so the delay of a message
    is no deviation.
    """
    clocks, now = scene.clocks, watched.elapsed(scene.clocks.node())
    farthest, joint, silent = math.nan, '', list[str]()
    for column, place in enumerate(places):
        robot = scene.model.joints.robots[place.robot]
        value = robot.values[place.column]
        if value is None or not _is_fresh(clocks.age(value.since), stale_after):
            silent.append(watched.joint_names[column])
            continue
        at = now if value.since == ALWAYS else watched.elapsed(value.since.held)
        difference = value.position - float(watched.spline.value(at)[column])
        if robot.entries[place.column].type == 'continuous':  # a turn more is the same place
            difference = math.remainder(difference, 2.0 * math.pi)
        if not abs(difference) <= farthest:
            farthest, joint = abs(difference), watched.joint_names[column]
    return Following(farthest, joint, tuple(silent))


def _is_fresh(age: float, stale_after: float) -> bool:
    return age < math.inf and age <= stale_after
