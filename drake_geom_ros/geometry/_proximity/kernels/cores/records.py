"""Records that kernels of convex pairs pass to each other.

Numba treats named tuples as tuples: inside compiled code names cost nothing.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.runtime.arrays import Vector

Floats = NDArray[np.float64]


class CorePair(NamedTuple):
    """Two posed cores: A at the origin, B at ``p_AB`` from it, in World axes [m]."""

    kind_A: int
    shape_A: Floats
    R_WA: Floats
    kind_B: int
    shape_B: Floats
    R_WB: Floats
    p_AB: Vector


class Overlap(NamedTuple):
    """The width h(n) [m] of the overlap of two cores along a unit n; negative if separated."""

    width: float
    n: Vector


class Separation(NamedTuple):
    """Bounds of the distance of two cores: ``lower <= distance <= upper = |b - a|`` [m].

    ``end`` is the end of the search (see ``gjk``), n the unit vector from a to b, and ``n_lower``
    the unit vector along which the cores are separated by ``lower``.
    """

    end: int
    upper: float
    lower: float
    n: Vector
    a: Vector
    b: Vector
    n_lower: Vector


class Depth(NamedTuple):
    """Bounds of the penetration depth of two cores: ``lower <= depth <= upper`` [m].

    ``upper`` is the width of the overlap along the unit n from A to B. Points a and b, from Ao,
    have ``a - b = upper n`` up to ``aside`` [m]. ``unique``: the bounds exclude every clearly
    different direction.
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
    if one is a hull; r_A and r_B [m] are the radii of the balls that are subtracted.
    """

    terms: Floats
    first: int
    last: int
    r_A: float
    r_B: float


class Minimum(NamedTuple):
    """A local minimum h [m] of the support function of a difference, at the unit n.

    ``kind`` is that of ``normals``; ``margin`` [m] is the distance of the foot of the origin from
    the border of the crease or face.
    """

    kind: int
    n: Vector
    h: float
    margin: float


class Touch(NamedTuple):
    """Points a and b of two cores, from Ao, that touch at the unit n from A to B.

    They have ``a - b = h n``, with the support value h [m] of the difference, up to ``aside`` [m].
    """

    n: Vector
    h: float
    a: Vector
    b: Vector
    aside: float


class Least(NamedTuple):
    """The least support value h [m] of a difference, at the unit n, by a search of directions.

    ``complete``: the search was finished. ``floor`` [m] is a lower bound of all values.
    ``unique``: no clearly different direction is as good.
    """

    complete: bool
    h: float
    floor: float
    n: Vector
    unique: bool


class Bounds(NamedTuple):
    """Bounds of the signed distance phi of two cores: ``lower <= phi <= upper`` [m].

    ``distance`` [m] is the answer; ``b - a = distance n`` for points a of A and b of B, on the
    surface if it is negative, each within ``miss`` [m]. The separation along ``n_lower`` is
    ``lower``.
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
