"""Moves after which two bodies are certainly apart: by more than rounding, or without error.

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
    pair: SolidPair, t: Vector, closest: Nearest, ways: Floats, count: int
) -> tuple[bool, Vector, Nearest]:
    """Return (clear, t, closest): A is certainly apart at t, some roundings beside the given t.

    It may overlap at the given t; ``closest`` and ``ways`` are of ``stand_of`` there. Without ways
    contacts provide them.
    """
    here = moved(pair, t)
    noise = noise_of(pair)
    if count == 0:
        count = contacts(here, closest.n, noise, ways, MOST_CONTACTS)
    is_found, step = aside_of(ways, count, ASIDE * noise)
    if not is_found:
        return False, t, closest
    t = add(t, step)
    there = moved(pair, t)
    closest = nearest(there, closest.n, np.inf, touch_of(pair))
    stand, _ = stand_of(there, closest, ways)
    return stand <= TOUCHES, t, closest


@allocating
def cleared(pair: SolidPair, t: Vector, n: Vector) -> tuple[bool, Vector, Nearest]:
    """Return (clear, t, closest): whether A, moved by t, is apart from B, and the nearest points.

    Where it touches, and an overlap cannot be excluded, it is moved aside by some roundings. The
    search has no limit, and so leaves nothing out.
    """
    here = moved(pair, t)
    closest = nearest(here, n, np.inf, touch_of(pair))
    ways = np.empty((MOST_WAYS, WAY_WIDTH))
    stand, count = stand_of(here, closest, ways)
    if stand == MAY_OVERLAP:
        return step_aside(pair, t, closest, ways, count)
    return stand <= TOUCHES, t, closest
