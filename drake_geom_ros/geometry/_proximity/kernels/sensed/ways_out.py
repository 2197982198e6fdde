"""How deep a body is in a map: a translation that was verified to part them.

The depth of a union is the length of the shortest translation that parts A from all cells. No
single cell is deeper than that, and any translation that is seen to part them is as long at least.
One is found by pushing A out of the deepest cell, and out of the deepest one there, and so on; if
that leads nowhere, or round, along the axes of the map until A is beside all of it. From where
it is free A is brought back along the straight line for as long as it stays free.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import DISTANCE, NORMAL, WITNESS_B
from drake_geom_ros.geometry._proximity.kernels.sensed.bodies import (
    MapPair,
    box_of_node,
    noise_of,
    towards,
)
from drake_geom_ros.geometry._proximity.kernels.sensed.leaves import LEAST, SKIPPED
from drake_geom_ros.geometry._proximity.kernels.sensed.walks import find_nearest
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    column,
    norm,
    rotate,
    scale,
    sub,
    unit,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined

MOST_PUSHES = 16
MOST_RETURNS = 8
BACK_OFF = 4.0  # roundings that A is moved on beyond touching


class WayOut(NamedTuple):
    """A translation of A that parts it from B, and the point of B that it touches then."""

    is_out: bool
    length: float
    n: Vector  # unit, in World axes
    b: Vector  # from Ao as A stands now, in World axes


NO_WAY = WayOut(False, math.inf, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@compiled
def _room(pair: MapPair, p: Vector, s: Vector, cutoff: float, found: Floats) -> float:
    """Return how far A is from all cells at least [m] when it is moved by s; negative: in some.

    Of what is beyond the cutoff [m] less is told.
    """
    find_nearest(pair, sub(p, s), cutoff, found)
    return min(found[LEAST], found[SKIPPED]) - noise_of(pair)


@compiled
def _back(pair: MapPair, p: Vector, n: Vector, far: float, found: Floats) -> WayOut:
    """Return the way out along the unit n, of no more than ``far`` [m], where A is surely free.

    As far as A is from all cells it may go back, for so far it stays free.
    """
    length, room = far, _room(pair, p, scale(far, n), far, found)
    if room < 0.0:
        return NO_WAY
    b = _touched(p, n, far, found)
    for _ in range(MOST_RETURNS):
        nearer = length - room
        if room <= BACK_OFF * noise_of(pair) or nearer <= 0.0:
            break
        left = _room(pair, p, scale(nearer, n), nearer, found)
        if left < 0.0:
            break
        length, room = nearer, left
        b = _touched(p, n, nearer, found)
    return WayOut(True, length, n, b)


@inlined
def _touched(p: Vector, n: Vector, length: float, found: Floats) -> Vector:
    """Return the point of B that is nearest to A when it is moved so far along n, from Ao now."""
    if found[DISTANCE] == math.inf:
        return p
    return add_scaled(vector_at(found, WITNESS_B), length, n)


@compiled
def _pushed_out(pair: MapPair, p: Vector, depth: float, found: Floats) -> WayOut:
    """Return the way on which A leaves the deepest cell, the deepest there, until it is out.

    ``found`` comes in as the walk left it about A as it stands.
    """
    s, room = (0.0, 0.0, 0.0), min(found[LEAST], found[SKIPPED]) - noise_of(pair)
    for _ in range(MOST_PUSHES):
        s = add_scaled(s, BACK_OFF * noise_of(pair) - room, vector_at(found, NORMAL))
        room = _room(pair, p, s, 0.0, found)
        if room >= 0.0:
            length, n = norm(s), unit(s)
            if length - depth <= 2.0 * BACK_OFF * noise_of(pair):  # nothing is to be gained
                return WayOut(True, length, n, p)
            return _back(pair, p, n, length, found)
    return NO_WAY


@compiled
def _beside(pair: MapPair, p: Vector, k: int, side: float) -> float:
    """Return how far A has to go along axis k of B, or against it, to be beside all cells [m]."""
    A, B, R = pair.A, pair.B, pair.R
    mine, its = box_of_node(A, 0), box_of_node(B, 0)
    middle = sub(rotate(R, mine.middle), unrotate(B.R_W, p))
    h = mine.half
    reach = abs(R[k, 0]) * h[0] + abs(R[k, 1]) * h[1] + abs(R[k, 2]) * h[2] + its.half[k]
    between = side * (its.middle[k] - middle[k])
    return max(between + reach + A.radius + B.radius + BACK_OFF * noise_of(pair), 0.0)


@allocating
def way_out(pair: MapPair, p: Vector, depth: float, found: Floats) -> WayOut:
    """Return a short way out of B, that A is as deep in as ``depth`` [m] at least.

    ``found`` comes in as the walk left it, and is used up.
    """
    best = _pushed_out(pair, p, depth, found)
    if best.is_out:
        return best
    for turn in range(6):
        k, side = turn // 2, 1.0 - 2.0 * (turn % 2)
        n = scale(side, column(pair.B.R_W, k))
        other = _back(pair, p, n, _beside(pair, p, k, side), found)
        if other.is_out and other.length < best.length:
            best = other
    if best.is_out:
        return best
    # As far as the balls around both reach, they are apart in the end: nobody has to look.
    return WayOut(True, pair.size, scale(-1.0, towards(p)), p)
