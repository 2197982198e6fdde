"""Forces and areas of contact surfaces: in closed form, and by quadrature of high order."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

RADIUS, MODULUS = 0.05, 1e5  # of balls [m], [Pa]
DEPTH = 0.01  # [m]
SIZE = (0.08, 0.1, 0.06)  # of the box [m]


class Truth(NamedTuple):
    """A surface in a plane, or about an axis, of z = 0: normal to it the force is upward."""

    area: float  # [m^2]
    force: float  # [N]
    height: float  # of the centre of pressure [m]
    width: float  # of the patch, half of it [m]


def ball_in_plane() -> Truth:
    """Return what a soft ball presses on a rigid plane with.

    p = E (1 - r / R) on a disc at the height h above which the middle is: the force is 2 pi E
    times the integral of (1 - sqrt(s^2 + h^2) / R) s ds.
    """
    R, h = RADIUS, RADIUS - DEPTH
    square = R**2 - h**2
    force = 2.0 * math.pi * MODULUS * (0.5 * square - (R**3 - h**3) / (3.0 * R))
    return Truth(math.pi * square, force, 0.0, math.sqrt(square))


def ball_in_ball() -> Truth:
    """Return what a rigid ball presses a soft one with, both of the same radius.

    The patch is a cap of the rigid one, whose middle is the origin; the soft one is above it. The
    pressure at the angle a from the axis is E (1 - |x - c| / R); by Gauss's rule over cos a.
    """
    R, apart = RADIUS, 2.0 * RADIUS - DEPTH
    lowest = apart / (2.0 * R)  # where the surfaces of both meet
    nodes, weights = np.polynomial.legendre.leggauss(60)
    cosines = 0.5 * (1.0 - lowest) * nodes + 0.5 * (1.0 + lowest)
    away = np.sqrt(R**2 + apart**2 - 2.0 * R * apart * cosines)
    # Area is 2 pi R^2 for each step of the cosine.
    pressed = math.pi * R**2 * (1.0 - lowest) * weights * MODULUS * (1.0 - away / R)
    height = R * float((pressed * cosines).sum() / pressed.sum())
    area = 2.0 * math.pi * R**2 * (1.0 - lowest)
    return Truth(area, float((pressed * cosines).sum()), height, R * math.sqrt(1 - lowest**2))


def box_on_plane() -> Truth:
    """Return what a soft box presses on a rigid plane with.

    Its pressure grows from a face by E / (least size / 2), and from the nearest one, so that it
    falls to 0 over the last DEPTH all around: a plateau, and along its rim a roof with corners.
    """
    x, y, z = SIZE
    d = DEPTH
    # Of min(d, distance from the rim): the integral over x by y.
    volume = (x - 2 * d) * (y - 2 * d) * d + (x + y - 4 * d) * d**2 + 4 * d**3 / 3
    return Truth(x * y, MODULUS / (0.5 * z) * volume, 0.0, 0.5 * x)
