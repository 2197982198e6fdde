"""Random small motions: poses for every cycle, made before anything is timed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.evidence.arms import SWING, link_poses
from drake_geom_ros.evidence.bodies import Floats

TURN = 0.01  # [rad] how far a body turns in a cycle, at most, about each axis


class Motion(Protocol):
    """Something that moves bodies."""

    def poses(self, cycles: int, seed: int) -> Floats:
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

    def poses(self, cycles: int, seed: int) -> Floats:
        """Return poses (cycles, n, 7) of the bodies in World."""
        rng = np.random.default_rng(seed)
        count = len(self.lower)
        start = rng.uniform(self.lower, self.upper)
        turned = Rotation.random(count, rng=rng)
        rests = np.ones(count, dtype=bool)
        rests[rng.permutation(count)[: max(1, round(self.moving * count))]] = False
        steps = rng.uniform(-1, 1, (cycles, count, 3)) * self.step[:, None]
        steps[:, rests] = 0.0
        turns = rng.uniform(-TURN, TURN, (cycles, count, 3))
        turns[:, rests] = 0.0
        poses = np.empty((cycles, count, 7))
        poses[..., :3] = reflected(start + np.cumsum(steps, axis=0), self.lower, self.upper)
        # A body at rest has the same numbers in every cycle, to the last bit.
        poses[..., 3:] = turned.as_quat()
        for cycle, turn in enumerate(turns):
            turned = Rotation.from_rotvec(turn) * turned
            poses[cycle, ~rests, 3:] = turned.as_quat()[~rests]
        poses[:, rests, :3] = start[rests]
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

    def poses(self, cycles: int, seed: int) -> Floats:
        """Return poses (cycles, 14, 7) of the links' centres in World."""
        rng = np.random.default_rng(seed)
        start = self.posture + rng.uniform(-SWING, SWING, (2, 7))
        steps = rng.uniform(-TURN, TURN, (cycles, 2, 7)) * self.moving
        angles = start + np.cumsum(steps, axis=0)
        return link_poses(reflected(angles, self.posture - SWING, self.posture + SWING))


def swinging(posture: Floats) -> ArmMotion:
    """Return the motion about a posture in which every joint takes part."""
    return ArmMotion(posture, np.ones((2, 7)))


def reflected(values: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return values folded into [lower, upper], as if mirrors stood at both ends."""
    length = np.maximum(upper - lower, np.finfo(float).tiny)
    return lower + length - np.abs((values - lower) % (2 * length) - length)
