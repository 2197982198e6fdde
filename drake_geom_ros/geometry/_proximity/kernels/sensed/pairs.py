"""Signed distance of any shape, or of a map, from a map: a tree walk around a pair's kernel.

Rows of the pair table with a map name the kernel for one cell, a box or a ball. If separated, the
answer is that of the nearest cell. If overlapping, the union is at least as deep as its deepest
cell, and at most as deep as the length of a separating translation (``ways_out``). Where both are
equal within rounding, the answer is that of the deepest cell. Otherwise it is the separating
translation, with OPEN as method and an error bound for how much shorter another may be. A half
space is left along its normal, so there the deepest cell is the answer.

With an infinite accuracy any depth will do, and no translation is searched: where a bounded body
plainly overlaps, the answer is the deepest cell, and the error bound how much deeper it may be.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
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
    LEAST,
    NEAREST_WIDTH,
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
from drake_geom_ros.geometry._proximity.tolerances import TOUCHING_DEPTH

LOOSE = 4.0 * BACK_OFF  # roundings within which both depths count as equal


@compiled
def _write_beyond(pair: MapPair, p: Vector, lower: float, out: Floats) -> None:
    """Write the row of a pair certified to be at least ``lower`` [m] apart."""
    n = towards(p)
    error = max(pair.size - lower, 0.0) + noise_of(pair)
    zero = (0.0, 0.0, 0.0)
    write(out, lower, scale(-1.0, n), zero, scale(lower, n), error, False, BOUND_ONLY)


@compiled
def _write_open(pair: MapPair, nearest: Floats, way: WayOut, out: Floats) -> None:
    """Write the row of a pair that overlaps by at most the length of a separating translation."""
    depth = -nearest[DISTANCE]
    error = max(way.length - depth, 0.0) + nearest[ERROR_BOUND] + 2.0 * noise_of(pair)
    a = add_scaled(way.b, -way.length, way.n)
    write(out, -way.length, way.n, a, way.b, error, False, OPEN)


@compiled
def _write_overlap(pair: MapPair, nearest: Floats, out: Floats) -> None:
    """Write the row of a pair that overlaps by at least the depth of its deepest cell."""
    for c in range(PAIR_WIDTH):
        out[c] = nearest[c]
    # Moved by the size of the pair, it is apart.
    deeper = max(pair.size + nearest[DISTANCE], 0.0) + noise_of(pair)
    out[ERROR_BOUND] = nearest[ERROR_BOUND] + deeper
    out[UNIQUE], out[METHOD] = 0.0, OPEN


@allocating
def answer_of(pair: MapPair, p: Vector, cutoff: float, out: Floats) -> None:
    """Write the row of a pair; ``p`` [m] is Bo from Ao in World axes; the cutoff is in metres."""
    nearest, noise = np.empty(NEAREST_WIDTH), noise_of(pair)
    if pair.A.kind != HALF_SPACE:  # a union may be deeper than each of its cells
        cutoff = max(cutoff, 0.0)
    find_nearest(pair, p, cutoff, nearest)
    if nearest[DISTANCE] == math.inf:
        _write_beyond(pair, p, nearest[SKIPPED], out)
        return
    # A leaf that seems slightly farther may be nearer within its own error bound.
    error = max(nearest[ERROR_BOUND], nearest[DISTANCE] - nearest[LEAST]) + noise
    nearest[ERROR_BOUND] = error
    nearest[UNIQUE] *= 1.0 if nearest[OTHER] > nearest[DISTANCE] + 2.0 * error else 0.0
    if nearest[DISTANCE] - error < 0.0 and pair.A.kind != HALF_SPACE:
        plain = error + 2.0 * TOUCHING_DEPTH * pair.aim.size
        if pair.aim.accuracy == math.inf and nearest[DISTANCE] < -plain:
            _write_overlap(pair, nearest, out)
            return
        way = way_out(pair, p, -nearest[DISTANCE], nearest.copy())
        more = way.length + nearest[DISTANCE]
        is_same = more <= LOOSE * noise + 2.0 * error
        if not is_same and nearest[DISTANCE] < -error:
            _write_open(pair, nearest, way, out)
            return
        # No cell certainly overlaps: the pair may touch, however long the translation is.
        nearest[ERROR_BOUND] = max(error, more if is_same else more + noise)
    for c in range(PAIR_WIDTH):
        out[c] = nearest[c]


@allocating
def over_map(
    address: Address, A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the row of a pair whose B is a map; ``address`` is that of the kernel for one cell."""
    p = vector_at(p_AB_W, 0)
    answer_of(map_pair(address, A, B, aim, norm(p)), p, aim.cutoff, out)
