"""Two arms of seven links: capsules and boxes in turn, joints about z and y in turn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bench.peers.motion import TURN, reflected

Floats = NDArray[np.float64]

LENGTHS = (0.22, 0.24, 0.22, 0.2, 0.2, 0.14, 0.12)  # [m] from each joint to the next
WIDTH = 0.09  # [m] of each link
BASES = np.array([[-0.45, 0.0, 0.06], [0.45, 0.0, 0.06]])  # [m] first joints, above the table
# [rad] where the joints swing about: bent over the table, reaching each other; and upright.
BENT = np.array([[0.0, 1.0, 0.0, 1.0, 0.0, 0.9, 0.0], [0.0, -1.0, 0.0, -1.0, 0.0, -0.9, 0.0]])
APART = np.zeros((2, 7))
SWING = 0.25  # [rad] to either side


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
        angles = reflected(angles, self.posture - SWING, self.posture + SWING)
        return np.concatenate(
            [chain(base, angles[:, arm]) for arm, base in enumerate(BASES)], axis=1
        )


def chain(base: Floats, angles: Floats) -> Floats:
    """Return poses (cycles, 7, 7) of the links' centres of one arm, for angles (cycles, 7)."""
    cycles = len(angles)
    turned = Rotation.from_quat(np.tile([0.0, 0.0, 0.0, 1.0], (cycles, 1)))
    joint = np.tile(base, (cycles, 1))
    poses = np.empty((cycles, 7, 7))
    for k, length in enumerate(LENGTHS):
        axis = np.array([0.0, 0.0, 1.0]) if k % 2 == 0 else np.array([0.0, 1.0, 0.0])
        turned = turned * Rotation.from_rotvec(angles[:, k, None] * axis)
        along = turned.apply([0.0, 0.0, length])
        poses[:, k] = np.concatenate((joint + 0.5 * along, turned.as_quat()), axis=1)
        joint = joint + along
    return poses


def arms(posture: Floats) -> ArmMotion:
    """Return the motion about a posture in which every joint takes part."""
    return ArmMotion(posture, np.ones((2, 7)))


def links() -> list[tuple[str, tuple[float, ...]]]:
    """Return the kind and the sizes [m] of the shape of each of the 14 links."""
    kinds = [
        ('Capsule', (WIDTH / 2, length)) if k % 2 == 0 else ('Box', (WIDTH, WIDTH, length))
        for k, length in enumerate(LENGTHS)
    ]
    return [*kinds, *kinds]
