"""Narrow phase: one compiled loop a query over the near pairs, which does no more than it must.

For each pair, in this order: what it was last time minus what both bodies can have moved since
may prove that it is too far apart; the last answer may still stand because both rest; the bounds
may keep it apart; only then the kernel of its row in the pair table is called, by its address, and
starts from the pair's last normal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.addresses import AT_ONE_METRE, ROWS
from drake_geom_ros.geometry._proximity.kernels.calling.extremes import (
    call_at_one_metre,
    is_extreme,
    vanishes,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    LEVEL_GAP,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    SEEN,
    SLACK,
    UNIQUE,
    WITNESS_A,
    WITNESS_B,
    call_kernel,
)
from drake_geom_ros.geometry._proximity.kernels.pair_table import TYPE_COUNT
from drake_geom_ros.geometry._proximity.kinds import (
    BOUND_ONLY,
    CONVEX,
    HALF_SPACE,
    ITERATIVE,
    SOLID,
)
from drake_geom_ros.geometry._proximity.pairs.bounds_alone import bound_pair, raise_lower_end
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import (
    apart,
    separation_of_bounds,
    separation_of_boxes,
)
from drake_geom_ros.geometry._proximity.pairs.error_bounds import (
    hides_contact,
    rounding_of_pair,
    size_of_pair,
    tolerance_of_pair,
)
from drake_geom_ros.geometry._proximity.pairs.slots import Query, Queue
from drake_geom_ros.geometry._proximity.report import BY_METHOD, CACHED, FAR, POSTPONED, WIDE
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import (
    EPS,
    PROMISED_ROUNDING,
    ROUNDING,
    TOUCHING_DEPTH,
)
from drake_geom_ros.geometry._proximity.world.arrays import world_of

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@inlined
def _code(type_a, type_b):  # type: ignore[no-untyped-def]
    """Return where a pair of types stands in ROW_OF_TYPES."""
    return min(type_a, type_b) * TYPE_COUNT + max(type_a, type_b)


class Shapes(NamedTuple):
    """Type numbers, and where in the pool the parameters are."""

    types: Indices
    starts: Indices
    pool: Floats


class Aim(NamedTuple):
    """What a kernel is to do: the pair's size, tolerance and cutoff [m]."""

    size: float
    tolerance: float
    cutoff: float


@inlined
def _call_in_order(  # type: ignore[no-untyped-def]
    a, b, kernels, shapes, R_WGs, p_WGs, p_AB_W, aim, out
):
    """Call a pair's kernel, the lower type first; the only place where A and B are exchanged."""
    types, starts, pool = shapes.types, shapes.starts, shapes.pool
    swapped = types[a] > types[b]
    if swapped:
        a, b = b, a
        for c in range(3):
            out[NORMAL + c] = -out[NORMAL + c]
    for c in range(3):
        p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
    address = kernels[ROWS[_code(types[a], types[b])]]
    shape_a, shape_b = part(pool, starts[a], starts[a + 1]), part(pool, starts[b], starts[b + 1])
    R_WA, R_WB = row(R_WGs, a), row(R_WGs, b)
    # A solid, the highest type, holds areas and counts too: its kernels take it as it is.
    extreme = is_extreme(aim.size, p_AB_W)
    extreme = extreme or vanishes(types[a], shape_a) or vanishes(types[b], shape_b)
    if extreme and types[b] <= CONVEX:
        call_at_one_metre(
            kernels[AT_ONE_METRE],
            address,
            aim.size,
            types[a],
            shape_a,
            R_WA,
            types[b],
            shape_b,
            R_WB,
            p_AB_W,
            aim.tolerance,
            aim.cutoff,
            out,
        )
    else:
        call_kernel(
            address,
            types[a],
            shape_a,
            R_WA,
            types[b],
            shape_b,
            R_WB,
            p_AB_W,
            aim.tolerance,
            aim.cutoff,
            out,
        )
    if swapped:
        for c in range(3):
            # Measured from the other body's origin from now on.
            p_a = out[WITNESS_A + c] - p_AB_W[c]
            p_b = out[WITNESS_B + c] - p_AB_W[c]
            out[WITNESS_A + c], out[WITNESS_B + c] = p_b, p_a
            out[NORMAL + c] = -out[NORMAL + c]


@inlined
def _may_leap(out, moved, type_a, type_b):  # type: ignore[no-untyped-def]
    """Tell whether the distance can have changed by more than both bodies have moved [m].

    A peg that is turned in its hole by a hair, into the walls, has to leave the hole. Only bodies
    that are apart, and stay so, keep it: then it is the least distance of any two points.
    """
    solid = type_a == SOLID or type_b == SOLID
    return solid and out[DISTANCE] - out[ERROR_BOUND] <= moved


@inlined
def _take_narrower(out, bounds, moved):  # type: ignore[no-untyped-def]
    """Write bounds as the answer, or widen the last one by what both bodies can have moved [m].

    A support value changes by no more than the points do, so the distance of convex bodies by no
    more than both have moved; that of any bodies too, for as long as they stay apart. The normal
    and the witness points are those of the last answer then.
    """
    if out[ERROR_BOUND] + moved <= bounds[ERROR_BOUND]:
        out[ERROR_BOUND] += moved
        out[UNIQUE], out[METHOD] = 0.0, BOUND_ONLY
        return
    for c in range(PAIR_WIDTH):
        out[c] = bounds[c]


@inlined
def _slack(least, travelled, type_a, type_b):  # type: ignore[no-untyped-def]
    """Return a least distance plus the travels of the same time [m], rounded down.

    What the turn of a half space moves has no bound.
    """
    if type_a == HALF_SPACE or type_b == HALF_SPACE:
        return -math.inf
    return least + travelled - 4.0 * EPS * (abs(least) + travelled)


@inlined
def _least(out, level_gap, size, rounding):  # type: ignore[no-untyped-def]
    """Return what the distance is at least [m], by an answer that was computed for ``level_gap``.

    ``rounding`` [m] is that of the pair's poses, which an error bound has in it.
    """
    if out[METHOD] == BOUND_ONLY and not math.isinf(level_gap):
        # A kernel that stopped at the cutoff reports its lower bound.
        return out[DISTANCE] - rounding - 2.0 * ROUNDING * EPS * (size + abs(out[DISTANCE]))
    return out[DISTANCE] - out[ERROR_BOUND]


@inlined
def _postpone(k, least, waiting, distances, counts):  # type: ignore[no-untyped-def]
    """Put pair k into the queue, with its least distance if that has room for it."""
    waiting[counts[POSTPONED]] = k
    if distances.size > 0:
        distances[counts[POSTPONED]] = least
    counts[POSTPONED] += 1


@inlined
def _is_hit(out, size, cutoff, penetrating):  # type: ignore[no-untyped-def]
    """Tell whether an answer is within the cutoff; of bounds alone, whether it may be."""
    distance = out[DISTANCE] - (out[ERROR_BOUND] if math.isinf(out[LEVEL_GAP]) else 0.0)
    if penetrating:
        return distance < -TOUCHING_DEPTH * size
    return distance <= cutoff


@inlined
def _rounded(out, a, b, level_gap, size, p_WGs, outer, roundings, counts):  # type: ignore[no-untyped-def]
    """Add the rounding of a pair's poses to its bound and return it [m]; count a wide bound.

    Bounds alone and solids promise nothing.
    """
    extent = size + apart(p_WGs, a, b)
    kept = tolerance_of_pair(level_gap, a, b, outer) + PROMISED_ROUNDING * EPS * extent
    counts[WIDE] += out[METHOD] <= ITERATIVE and out[ERROR_BOUND] > kept
    rounding = rounding_of_pair(a, b, extent, roundings)
    out[ERROR_BOUND] += rounding
    return rounding


@allocating
def answer_pairs(  # type: ignore[no-untyped-def]
    kernels, pairs, slots, memory, world, revision, query, first, queue, hits, counts
):
    """Bring the slots of the pairs up to date that may be within the cutoff; return how many are.

    ``kernels`` are addresses, ``world`` is a handle; ``query`` and ``queue`` are plain tuples of
    ``slots``, ``memory`` is as its ``empty_memory``. ``hits`` gets the
    numbers of the pairs. A level gap that is infinite asks for the bounds of now, for to use what
    is known from before would make the answer depend on what was asked. A ``first`` that is not
    negative is where to begin, and then one hit is enough. A queue with room for all pairs gets
    those for which a kernel would run, with their certified least distance if there is room for
    these too; without any room, kernels run.

    (The records are taken apart first: to hand that of the world on made a pair of spheres take 6
    ns longer, 5 % of the loop, and a tuple of some arrays that is made before the loop half as
    long again, for references are counted. One that is made in a call costs nothing.)
    """
    world, query, queue = world_of(world), Query(*query), Queue(*queue)
    types, R_WGs, p_WGs, roundings = world.types, world.R_WGs, world.p_WGs, world.roundings
    halves, outer, inner = world.half_extents, world.outer, world.inner
    travels, stamps, starts, pool = world.travels, world.stamps, world.starts, world.pool
    level_gap, cutoff, penetrating = query.level_gap, query.cutoff, query.penetrating
    p_AB_W, bounds = np.empty(3), np.empty(PAIR_WIDTH)
    # Not how deep they are: boxes that overlap are 0 apart, and a solid may leap (see above).
    near_cutoff, found = max(cutoff, 0.0), 0
    far_cutoff = math.inf if math.isinf(level_gap) else near_cutoff
    counts[:] = 0
    for turn in range(slots.size):
        k = turn if first < 0 else (first + turn) % slots.size
        a, b, s = pairs[k, 0], pairs[k, 1], slots[k]
        out, travelled = row(memory, s), travels[a] + travels[b]
        if out[SLACK] - travelled > far_cutoff:
            counts[FAR] += 1
            continue
        size, latest = size_of_pair(a, b, types, outer), max(stamps[a], stamps[b])
        rests = latest <= out[SEEN] and 0.0 <= out[LEVEL_GAP] <= level_gap < math.inf
        # What stopped at a cutoff says enough about smaller ones only.
        if rests and (out[METHOD] != BOUND_ONLY or out[DISTANCE] > cutoff):
            counts[CACHED] += 1
        else:
            least = -math.inf
            if cutoff < math.inf:
                least = separation_of_bounds(
                    a, b, types, R_WGs, p_WGs, roundings, halves, outer, near_cutoff
                )
            near = least <= near_cutoff
            if near and queue.waiting.size > 0:
                if queue.distances.size > 0:
                    bound_pair(a, b, types, starts, pool, R_WGs, p_WGs, inner, p_AB_W, bounds)
                    least = max(bounds[DISTANCE] - bounds[ERROR_BOUND], out[SLACK] - travelled)
                _postpone(k, least, queue.waiting, queue.distances, counts)
                continue
            if near:
                if math.isinf(level_gap):
                    bound_pair(a, b, types, starts, pool, R_WGs, p_WGs, inner, p_AB_W, out)
                else:
                    aim = Aim(size, tolerance_of_pair(level_gap, a, b, outer), cutoff)
                    shapes = Shapes(types, starts, pool)
                    _call_in_order(a, b, kernels, shapes, R_WGs, p_WGs, p_AB_W, aim, out)
                rounding = _rounded(out, a, b, level_gap, size, p_WGs, outer, roundings, counts)
                if math.isinf(level_gap):
                    raise_lower_end(a, b, types, R_WGs, p_WGs, roundings, halves, outer, out)
                out[SEEN], out[LEVEL_GAP] = revision, level_gap
                counts[BY_METHOD + int(out[METHOD])] += 1
                least = _least(out, level_gap, size, rounding)
            else:
                counts[FAR], out[SEEN] = counts[FAR] + 1, -1.0  # the slack is no longer its own
            out[SLACK] = _slack(least, travelled, types[a], types[b])
            if not near:
                continue
        hit = _is_hit(out, size, cutoff, penetrating)
        if hit or (first >= 0 and hides_contact(out, a, b, size + apart(p_WGs, a, b), roundings)):
            hits[found], found = k, found + 1
            if first >= 0:
                break
    return found


@allocating
def bound_pairs(pairs, slots, memory, world, revision, query, hits, counts):  # type: ignore[no-untyped-def]
    """Bring slots up to date as ``answer_pairs`` does for pairs that it put into a queue.

    No kernel runs: the answer is the narrower of what bounding volumes say and the last answer,
    widened by what both bodies can have moved since, and its level gap that of no question. (Not
    in ``answer_pairs``, whose kernels of spheres took 10 % longer beside this, measured.)
    """
    world, query = world_of(world), Query(*query)
    types, starts, pool = world.types, world.starts, world.pool
    R_WGs, p_WGs = world.R_WGs, world.p_WGs
    outer, inner, travels, stamps = world.outer, world.inner, world.travels, world.stamps
    cutoff, penetrating = query.cutoff, query.penetrating
    p_AB_W, bounds = np.empty(3), np.empty(PAIR_WIDTH)
    counts[:] = 0
    found = 0
    for k in range(slots.size):
        a, b, s = pairs[k, 0], pairs[k, 1], slots[k]
        out, size = row(memory, s), size_of_pair(a, b, types, outer)
        travelled = travels[a] + travels[b]
        if stamps[a] <= out[SEEN] and stamps[b] <= out[SEEN] and math.isinf(out[LEVEL_GAP]):
            counts[CACHED] += 1
        else:
            bound_pair(a, b, types, starts, pool, R_WGs, p_WGs, inner, p_AB_W, bounds)
            moved = math.inf
            if out[SEEN] >= 0.0:
                moved = travelled - (out[SLACK] - _least(out, out[LEVEL_GAP], size, 0.0))
            if _may_leap(out, moved, types[a], types[b]):
                moved = math.inf
            _take_narrower(out, bounds, moved)
            rounding = rounding_of_pair(a, b, size + apart(p_WGs, a, b), world.roundings)
            out[ERROR_BOUND] += rounding
            out[SEEN], out[LEVEL_GAP] = revision, -math.inf
            counts[BY_METHOD + BOUND_ONLY] += 1
            least = _least(out, out[LEVEL_GAP], size, rounding)
            out[SLACK] = _slack(least, travelled, types[a], types[b])
        if _is_hit(out, size, cutoff, penetrating):
            hits[found] = k
            found += 1
    return found


@compiled
def near_pairs(pairs, world, cutoff, hits):  # type: ignore[no-untyped-def]
    """Write the numbers of the pairs whose boxes are within ``cutoff``; return how many."""
    world, found = world_of(world), 0
    types, R_WGs, p_WGs = world.types, world.R_WGs, world.p_WGs
    roundings, half_extents = world.roundings, world.half_extents
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        separation = separation_of_boxes(i, j, types, R_WGs, p_WGs, roundings, half_extents)
        if separation <= cutoff:
            hits[found] = k
            found += 1
    return found
