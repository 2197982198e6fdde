"""Whether a contact surface is what it is close by: of bodies that differ by next to nothing.

Where a face of one body's tetrahedra is just where the pressures are equal, or pressures are equal
all over a volume, an area may jump: on either side of such a pose it is another. What can be asked
of an answer there is that it is one of those around it, or between them: it has no face too many,
and none too few. Elsewhere moving bodies by so little changes an answer as little.

Around a pose are bodies that are moved, and such as press a little more or less: no motion alone
makes the one body's pressure the higher one wherever both are the same.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ContactSurfaceResults

Floats = NDArray[np.float64]
Pose = tuple[Floats, Floats]

SHIFT = 1e-12  # of the size: a hundred times what is taken for rounding
HARDER = 1e-9  # of a modulus: much more than what gradients have to differ by, to be two
ALLOWED = 1e-8  # of numbers of size 1: more than these may change, if nothing jumps
SPREAD = 0.02  # of the range of answers around: as few of them are asked for as this leaves out


def numbers_of(surfaces: ContactSurfaceResults, size: float, modulus: float) -> Floats:
    """Return area, first moment, force and torque on M (10,), of a size of 1 m and 1 Pa."""
    if not len(surfaces):
        return np.zeros(10)
    area, force = surfaces.areas / size**2, surfaces.forces_on_M_W / (modulus * size**2)
    centroids = surfaces.centroids / size
    torque = surfaces.torques_on_M_Wo_W / (modulus * size**3)
    rows = np.column_stack((area, area[:, None] * centroids, force, torque))
    numbers: Floats = rows.sum(axis=0)
    return numbers


def poses_near(pose: Pose, size: float, random: np.random.Generator) -> Iterator[Pose]:
    """Yield a pose shifted and turned by next to nothing: along each axis, and at random."""
    R, p = pose
    moves = np.vstack((np.eye(6), -np.eye(6), random.uniform(-1.0, 1.0, (12, 6))))
    for move in SHIFT * moves:
        x, y, z = move[3:]
        yield R + np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) @ R, p + size * move[:3]


def is_alone(numbers: Floats, around: Floats) -> bool:
    """Tell whether numbers (10,) are not between those of the answers around them (k, 10)."""
    low, high = around.min(axis=0), around.max(axis=0)
    allowed = ALLOWED + SPREAD * (high - low)
    return bool((np.maximum(low - numbers, numbers - high) > allowed).any())
