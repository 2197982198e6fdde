"""Moves after which two bodies are apart, seen to be so: by more than rounding, or without error.

Bodies are given as in ``distance``.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.solids.contacts import aside_of, contacts
from drake_geom_ros.geometry._proximity.kernels.solids.containment import (
    MAY_OVERLAP,
    TOUCHES,
    stand_of,
    touch_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.distance import Nearest, nearest
from drake_geom_ros.geometry._proximity.kernels.solids.solid import SolidPair, moved, noise_of
from drake_geom_ros.geometry._proximity.kernels.solids.touching import MOST_WAYS, WAY_WIDTH
from drake_geom_ros.geometry._proximity.kernels.vectors import add
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating

MOST_CONTACTS = 64  # pairs of leaves that ways apart are taken from
ASIDE = 3.0  # roundings from what it touches that A is moved, to be apart by more than one


@allocating
def step_aside(
    pair: SolidPair, t: Vector, found: Nearest, ways: Floats, count: int
) -> tuple[bool, Vector, Nearest]:
    """Return (clear, t, found): A is seen to be apart at t, some roundings from a t where it may.

    ``found`` and ``ways`` are of ``stand_of`` there; without ways contacts are looked for.
    """
    here = moved(pair, t)
    noise = noise_of(pair)
    if count == 0:
        count = contacts(here, found.n, noise, ways, MOST_CONTACTS)
    is_found, step = aside_of(ways, count, ASIDE * noise)
    if not is_found:
        return False, t, found
    t = add(t, step)
    there = moved(pair, t)
    found = nearest(there, found.n, np.inf, touch_of(pair))
    stand, _ = stand_of(there, found, ways)
    return stand <= TOUCHES, t, found


@allocating
def cleared(pair: SolidPair, t: Vector, n: Vector) -> tuple[bool, Vector, Nearest]:
    """Return (clear, t, found): whether A, moved by t, is apart from B, and what is nearest then.

    Where it touches, and nobody can tell that it is no overlap, it is moved aside by some
    roundings. Nothing is asked within a limit, and so nothing is left out.
    """
    here = moved(pair, t)
    found = nearest(here, n, np.inf, touch_of(pair))
    ways = np.empty((MOST_WAYS, WAY_WIDTH))
    stand, count = stand_of(here, found, ways)
    if stand == MAY_OVERLAP:
        return step_aside(pair, t, found, ways, count)
    return stand <= TOUCHES, t, found
