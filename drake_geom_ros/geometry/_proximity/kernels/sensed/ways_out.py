"""Verified separating translations of a body and a map, as upper bounds of the depth.

The depth of a union is the length of the shortest translation that separates A from all cells. It
is at least the depth of each cell, and at most the length of any translation verified to separate
them. One is found by pushing A out of the deepest cell, then out of the deepest one there, and so
on. If that fails or cycles, A is moved along the axes of the map until it is beside the whole map.
From its free position A is moved back along the straight line as long as it stays free.
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
BACK_OFF = 4.0  # roundings by which A is moved beyond touching


class WayOut(NamedTuple):
    """A separating translation of A from B, and the point of B that A then touches."""

    is_out: bool
    length: float
    n: Vector  # unit, in World axes
    b: Vector  # from Ao at the current pose, in World axes


NO_WAY = WayOut(False, math.inf, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@compiled
def _clearance(pair: MapPair, p: Vector, s: Vector, cutoff: float, nearest: Floats) -> float:
    """Return a lower bound [m] of A's distance from all cells when moved by s; negative if inside.

    Beyond the cutoff [m] the bound may be less sharp.
    """
    find_nearest(pair, sub(p, s), cutoff, nearest)
    return min(nearest[LEAST], nearest[SKIPPED]) - noise_of(pair)


@compiled
def _back(pair: MapPair, p: Vector, n: Vector, far: float, nearest: Floats) -> WayOut:
    """Return a separating translation along the unit n, at most ``far`` [m] long.

    From ``far``, A moves back by its clearance repeatedly, because so far it stays free.
    """
    length, clearance = far, _clearance(pair, p, scale(far, n), far, nearest)
    if clearance < 0.0:
        return NO_WAY
    b = _touched(p, n, far, nearest)
    for _ in range(MOST_RETURNS):
        nearer = length - clearance
        if clearance <= BACK_OFF * noise_of(pair) or nearer <= 0.0:
            break
        next_clearance = _clearance(pair, p, scale(nearer, n), nearer, nearest)
        if next_clearance < 0.0:
            break
        length, clearance = nearer, next_clearance
        b = _touched(p, n, nearer, nearest)
    return WayOut(True, length, n, b)


@inlined
def _touched(p: Vector, n: Vector, length: float, nearest: Floats) -> Vector:
    """Return the point of B nearest to A when moved by ``length`` along n, from the current Ao."""
    if nearest[DISTANCE] == math.inf:
        return p
    return add_scaled(vector_at(nearest, WITNESS_B), length, n)


@compiled
def _pushed_out(pair: MapPair, p: Vector, depth: float, nearest: Floats) -> WayOut:
    """Return the translation that pushes A out of the deepest cell repeatedly, until it is out.

    ``nearest`` is the result of the walk at the current pose, and is overwritten.
    """
    s, clearance = (0.0, 0.0, 0.0), min(nearest[LEAST], nearest[SKIPPED]) - noise_of(pair)
    for _ in range(MOST_PUSHES):
        s = add_scaled(s, BACK_OFF * noise_of(pair) - clearance, vector_at(nearest, NORMAL))
        clearance = _clearance(pair, p, s, 0.0, nearest)
        if clearance >= 0.0:
            length, n = norm(s), unit(s)
            if length - depth <= 2.0 * BACK_OFF * noise_of(pair):  # it cannot be shorter
                return WayOut(True, length, n, p)
            return _back(pair, p, n, length, nearest)
    return NO_WAY


@compiled
def _beside(pair: MapPair, p: Vector, k: int, side: float) -> float:
    """Return the move [m] of A along axis k of B, to the given side, to be beside all cells."""
    A, B, R = pair.A, pair.B, pair.R
    root_A, root_B = box_of_node(A, 0), box_of_node(B, 0)
    middle = sub(rotate(R, root_A.middle), unrotate(B.R_W, p))
    h = root_A.half
    reach = abs(R[k, 0]) * h[0] + abs(R[k, 1]) * h[1] + abs(R[k, 2]) * h[2] + root_B.half[k]
    between = side * (root_B.middle[k] - middle[k])
    return max(between + reach + A.radius + B.radius + BACK_OFF * noise_of(pair), 0.0)


@allocating
def way_out(pair: MapPair, p: Vector, depth: float, nearest: Floats) -> WayOut:
    """Return a short separating translation of A from B, given a lower bound ``depth`` [m].

    ``nearest`` is the result of the walk, and is overwritten.
    """
    best = _pushed_out(pair, p, depth, nearest)
    if best.is_out:
        return best
    for turn in range(6):
        k, side = turn // 2, 1.0 - 2.0 * (turn % 2)
        n = scale(side, column(pair.B.R_W, k))
        other = _back(pair, p, n, _beside(pair, p, k, side), nearest)
        if other.is_out and other.length < best.length:
            best = other
    if best.is_out:
        return best
    # Moved by the size of the pair, the bounding balls are separated without a test.
    return WayOut(True, pair.size, scale(-1.0, towards(p)), p)
