"""What kernels of convex pairs hand to one another.

Numba takes named tuples as it takes tuples: inside compiled code a name costs nothing.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.vectors import Vector

Floats = NDArray[np.float64]


class Pair(NamedTuple):
    """Two cores as they stand: A at the origin, B at ``p_AB`` from it, in World axes [m]."""

    kind_A: int
    shape_A: Floats
    R_WA: Floats
    kind_B: int
    shape_B: Floats
    R_WB: Floats
    p_AB: Vector


class Gap(NamedTuple):
    """How far two cores are apart: ``lower <= distance <= upper = |b - a|`` [m].

    ``end`` is how the search came to an end (see ``gjk``), n the unit vector from a to b.
    """

    end: int
    upper: float
    lower: float
    n: Vector
    a: Vector
    b: Vector
