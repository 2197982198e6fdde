"""Two arms of seven links over a table: capsules and boxes, joints about z and y, in turn."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.math.array_types import Floats
from truth.tolerances import EASY

LENGTHS = (0.22, 0.24, 0.22, 0.2, 0.2, 0.14, 0.12)  # [m] from each joint to the next
WIDTH = 0.09  # [m] of each link
BASES = np.array([[-0.45, 0.0, 0.06], [0.45, 0.0, 0.06]])  # [m] first joints, above the table
# [rad] where the joints swing about: bent over the table, reaching each other; and upright.
BENT = np.array([[0.0, 1.0, 0.0, 1.0, 0.0, 0.9, 0.0], [0.0, -1.0, 0.0, -1.0, 0.0, -0.9, 0.0]])
APART = np.zeros((2, 7))
SWING = 0.25  # [rad] to either side
BOXES = 20  # on the table


def links() -> list[Body]:
    """Return the shapes of the links, those of one arm after those of the other."""
    shapes = [
        Body('Capsule', (WIDTH / 2, length)) if k % 2 == 0 else Body('Box', (WIDTH, WIDTH, length))
        for k, length in enumerate(LENGTHS)
    ]
    return [*shapes, *shapes]


def link_poses(angles: Floats) -> Floats:
    """Return poses (cycles, 14, 7) of the links' centres in World, for angles (cycles, 2, 7)."""
    return np.concatenate([_chain(base, angles[:, arm]) for arm, base in enumerate(BASES)], axis=1)


def posed_links(angles: Floats) -> list[Body]:
    """Return the links at their poses in World, for angles (2, 7)."""
    (poses,) = link_poses(angles[None])
    return [link.posed(pose) for link, pose in zip(links(), poses, strict=True)]


def _chain(base: Floats, angles: Floats) -> Floats:
    """Return poses (cycles, 7, 7) of one arm, for angles (cycles, 7)."""
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


def table(rng: np.random.Generator) -> list[Body]:
    """Return a table with boxes on it, at their poses in World."""
    bodies = [Body('Box', (2.0, 1.4, 0.1), p=np.array([0.0, 0.0, -0.05]))]
    for angle in rng.uniform(-np.pi, np.pi, BOXES):
        sizes = rng.uniform(0.05, 0.15, 3)
        p = np.array([*rng.uniform((-0.9, -0.6), (0.9, 0.6)), sizes[2] / 2 + EASY])
        R = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix()
        bodies.append(Body('Box', tuple(sizes.tolist()), R, p))
    return bodies
