"""What kernels of convex pairs hand to one another.

Numba takes named tuples as it takes tuples: inside compiled code a name costs nothing.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.runtime.arrays import Vector

Floats = NDArray[np.float64]


class CorePair(NamedTuple):
    """Two cores as they stand: A at the origin, B at ``p_AB`` from it, in World axes [m]."""

    kind_A: int
    shape_A: Floats
    R_WA: Floats
    kind_B: int
    shape_B: Floats
    R_WB: Floats
    p_AB: Vector


class Overlap(NamedTuple):
    """The width h(n) [m] of the overlap of two cores along a unit n; below 0 they are apart."""

    width: float
    n: Vector


class Separation(NamedTuple):
    """How far two cores are apart: ``lower <= distance <= upper = |b - a|`` [m].

    ``end`` is how the search came to an end (see ``gjk``), n the unit vector from a to b, and
    ``n_lower`` the one along which the cores are ``lower`` apart.
    """

    end: int
    upper: float
    lower: float
    n: Vector
    a: Vector
    b: Vector
    n_lower: Vector


class Depth(NamedTuple):
    """How deep two cores are in each other: ``lower <= depth <= upper`` [m].

    ``upper`` is the width of the overlap along the unit n from A to B. Points a and b, from Ao,
    have ``a - b = upper n`` but for ``aside`` [m]; ``unique`` tells that the bounds exclude every
    clearly different direction.
    """

    upper: float
    lower: float
    n: Vector
    a: Vector
    b: Vector
    aside: float
    unique: bool


class Difference(NamedTuple):
    """The Minkowski difference of two cores that are not hulls, as a sum (see ``sums``).

    The segments of A have rows of ``terms`` below ``first``, those of B below ``last``, which is 0
    if one is a hull; r_A and r_B [m] are the radii of the balls that are taken away.
    """

    terms: Floats
    first: int
    last: int
    r_A: float
    r_B: float


class Minimum(NamedTuple):
    """A local minimum h [m] of the support function of a difference, at the unit n.

    ``kind`` is what was found (see ``normals``), ``margin`` [m] how far the foot of the origin is
    inside the crease or face there.
    """

    kind: int
    n: Vector
    h: float
    margin: float


class Touch(NamedTuple):
    """Points a and b of two cores, from Ao, that touch at the unit n from A to B.

    They have ``a - b = h n``, with the support value h [m] of the difference, but for ``aside``
    [m].
    """

    n: Vector
    h: float
    a: Vector
    b: Vector
    aside: float


class Least(NamedTuple):
    """The least support value h [m] of a difference, at the unit n, by a search of directions.

    Complete if the search came to an end. ``floor`` [m] is what no value is below, and ``unique``
    tells that no clearly different direction is as good.
    """

    complete: bool
    h: float
    floor: float
    n: Vector
    unique: bool


class Bounds(NamedTuple):
    """Bounds of the signed distance phi of two cores: ``lower <= phi <= upper`` [m].

    ``distance`` [m] is the answer; ``b - a = distance n`` for points a of A and b of B, on the
    surface if it is negative, each to within ``miss`` [m]. Along ``n_lower`` they are ``lower``
    apart.
    """

    end: int
    distance: float
    upper: float
    lower: float
    n: Vector
    a: Vector
    b: Vector
    miss: float
    unique: bool
    n_lower: Vector
