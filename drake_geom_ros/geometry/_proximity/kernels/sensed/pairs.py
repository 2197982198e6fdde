"""Signed distance of any shape, or of a map, from a map: the walk around a pair's kernel.

The rows of the pair table that have a map name the kernel that answers for one cell, a box or a
ball. Apart, the answer is that about the nearest cell. Overlapping, the union is as deep as its
deepest cell at least, and no deeper than a way out is long (``ways_out``). Where both are the
same to rounding, the answer is that about the deepest cell; else it is the way out, with OPEN as
method, and the error bound tells how much shorter another may be. What leaves a half space leaves
it along its normal, so of that the deepest cell is the answer.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    PAIR_WIDTH,
    UNIQUE,
    Aim,
    OrientedShape,
    write,
)
from drake_geom_ros.geometry._proximity.kernels.sensed.bodies import (
    MapPair,
    map_pair,
    noise_of,
    towards,
)
from drake_geom_ros.geometry._proximity.kernels.sensed.leaves import (
    FOUND_WIDTH,
    LEAST,
    OTHER,
    SKIPPED,
)
from drake_geom_ros.geometry._proximity.kernels.sensed.walks import find_nearest
from drake_geom_ros.geometry._proximity.kernels.sensed.ways_out import BACK_OFF, WayOut, way_out
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    norm,
    scale,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, HALF_SPACE, OPEN
from drake_geom_ros.geometry._proximity.runtime.addresses import Address
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled

LOOSE = 4.0 * BACK_OFF  # roundings that a depth may be off by all the same


@compiled
def _write_beyond(pair: MapPair, p: Vector, lower: float, out: Floats) -> None:
    """Write the row of a pair that is farther apart than ``lower`` [m]."""
    n = towards(p)
    error = max(pair.size - lower, 0.0) + noise_of(pair)
    zero = (0.0, 0.0, 0.0)
    write(out, lower, scale(-1.0, n), zero, scale(lower, n), error, False, BOUND_ONLY)


@compiled
def _write_open(pair: MapPair, found: Floats, way: WayOut, out: Floats) -> None:
    """Write the row of a pair that overlaps by less than a way out is long, or by as much."""
    depth = -found[DISTANCE]
    error = max(way.length - depth, 0.0) + found[ERROR_BOUND] + 2.0 * noise_of(pair)
    a = add_scaled(way.b, -way.length, way.n)
    write(out, -way.length, way.n, a, way.b, error, False, OPEN)


@allocating
def answer_of(pair: MapPair, p: Vector, cutoff: float, out: Floats) -> None:
    """Write the row of a pair; ``p`` is Bo from Ao in World axes, and the cutoff is in metres."""
    found, noise = np.empty(FOUND_WIDTH), noise_of(pair)
    if pair.A.kind != HALF_SPACE:  # a union may be deeper than each of its cells
        cutoff = max(cutoff, 0.0)
    find_nearest(pair, p, cutoff, found)
    if found[DISTANCE] == math.inf:
        _write_beyond(pair, p, found[SKIPPED], out)
        return
    # Another leaf that was told a little farther may be nearer by what its own bound leaves open.
    error = max(found[ERROR_BOUND], found[DISTANCE] - found[LEAST]) + noise
    found[ERROR_BOUND] = error
    found[UNIQUE] *= 1.0 if found[OTHER] > found[DISTANCE] + 2.0 * error else 0.0
    if found[DISTANCE] - error < 0.0 and pair.A.kind != HALF_SPACE:
        way = way_out(pair, p, -found[DISTANCE], found.copy())
        more = way.length + found[DISTANCE]
        is_told = more <= LOOSE * noise + 2.0 * error
        if not is_told and found[DISTANCE] < -error:
            _write_open(pair, found, way, out)
            return
        # No cell surely overlaps: it may touch, however long the way out would be.
        found[ERROR_BOUND] = max(error, more if is_told else more + noise)
    for c in range(PAIR_WIDTH):
        out[c] = found[c]


@allocating
def over_map(
    address: Address, A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the row of a pair whose B is a map; ``address`` is that of the kernel for one cell."""
    p = vector_at(p_AB_W, 0)
    answer_of(map_pair(address, A, B, aim, norm(p)), p, aim.cutoff, out)
