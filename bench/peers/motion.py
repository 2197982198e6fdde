"""Random motions: poses for every cycle, made before anything is timed.

At the pace ``slow`` a body creeps, by a hundredth of its radius a cycle. ``robot`` is that of a
link at 1 m/s whose poses come at 100 Hz. At ``jump`` all poses are new, as a planner asks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.math.array_types import Floats
from truth.bodies.arms import SWING, link_poses

PACES = ('slow', 'robot', 'jump')
TURN = 0.01  # [rad] how far a body turns in a slow cycle, at most, about each axis
ROBOT_STEP = 0.01  # [m] standard deviation along each axis
ROBOT_TURN = 0.02  # [rad] likewise, about each axis
ROBOT_JOINT = 0.03  # [rad] of a joint


class Motion(Protocol):
    """Something that moves bodies."""

    def poses(self, cycles: int, seed: int, pace: str = 'slow') -> Floats:
        """Return poses (cycles, n, 7), x y z [m] qx qy qz qw, of n bodies in World."""

    def tenth(self) -> Motion:
        """Return the motion of which only a tenth of the bodies takes part."""


@dataclass(frozen=True)
class Walk:
    """Free bodies that each walk at random in a box of their own, thrown back by its sides.

    ``lower`` and ``upper`` (n, 3) [m] are the boxes' corners; ``step`` (n,) [m] is the most that
    a body moves along each axis in a cycle. ``moving`` is the share of bodies that move.
    """

    lower: Floats
    upper: Floats
    step: Floats
    moving: float = 1.0

    def tenth(self) -> Walk:
        """Return the motion of a tenth of the bodies, chosen at random."""
        return replace(self, moving=0.1)

    def poses(self, cycles: int, seed: int, pace: str = 'slow') -> Floats:
        """Return poses (cycles, n, 7) of the bodies in World."""
        rng = np.random.default_rng(seed)
        count = len(self.lower)
        start = rng.uniform(self.lower, self.upper)
        turned = Rotation.random(count, rng=rng)
        rests = np.ones(count, dtype=bool)
        rests[rng.permutation(count)[: max(1, round(self.moving * count))]] = False
        shape = cycles, count, 3
        poses = np.empty((cycles, count, 7))
        # A body at rest has the same numbers in every cycle, to the last bit.
        poses[..., :3], poses[..., 3:] = start, turned.as_quat()
        if pace == 'jump':
            poses[:, ~rests, :3] = rng.uniform(self.lower, self.upper, shape)[:, ~rests]
            anew = Rotation.random(cycles * count, rng=rng).as_quat().reshape(cycles, count, 4)
            poses[:, ~rests, 3:] = anew[:, ~rests]
            return poses
        if pace == 'robot':
            steps, turns = rng.normal(0, ROBOT_STEP, shape), rng.normal(0, ROBOT_TURN, shape)
        else:
            steps = rng.uniform(-1, 1, shape) * self.step[:, None]
            turns = rng.uniform(-TURN, TURN, shape)
        turns[:, rests] = 0.0
        moved = reflected(start + np.cumsum(steps, axis=0), self.lower, self.upper)
        poses[:, ~rests, :3] = moved[:, ~rests]
        for cycle, turn in enumerate(turns):
            turned = Rotation.from_rotvec(turn) * turned
            poses[cycle, ~rests, 3:] = turned.as_quat()[~rests]
        return poses


@dataclass(frozen=True)
class ArmMotion:
    """Joints that swing at random about a posture (2, 7) [rad]; ``moving`` (2, 7) says which."""

    posture: Floats
    moving: Floats

    def tenth(self) -> ArmMotion:
        """Return the motion of the last joint of one arm: 1 of 14 links moves."""
        moving = np.zeros_like(self.moving)
        moving[0, -1] = 1.0
        return replace(self, moving=moving)

    def poses(self, cycles: int, seed: int, pace: str = 'slow') -> Floats:
        """Return poses (cycles, 14, 7) of the links' centres in World."""
        rng = np.random.default_rng(seed)
        start = self.posture + rng.uniform(-SWING, SWING, (2, 7))
        if pace == 'jump':
            anew = self.posture + rng.uniform(-SWING, SWING, (cycles, 2, 7))
            return link_poses(np.where(self.moving > 0.0, anew, start))
        if pace == 'robot':
            steps = rng.normal(0, ROBOT_JOINT, (cycles, 2, 7))
        else:
            steps = rng.uniform(-TURN, TURN, (cycles, 2, 7))
        angles = start + np.cumsum(steps * self.moving, axis=0)
        return link_poses(reflected(angles, self.posture - SWING, self.posture + SWING))


def swinging(posture: Floats) -> ArmMotion:
    """Return the motion about a posture in which every joint takes part."""
    return ArmMotion(posture, np.ones((2, 7)))


def reflected(values: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return values folded into [lower, upper], as if mirrors stood at both ends."""
    length = np.maximum(upper - lower, np.finfo(float).tiny)
    return lower + length - np.abs((values - lower) % (2 * length) - length)
