"""Narrow phase: one compiled loop per query over the candidate pairs, cheapest test first.

The tests of each pair, in this order:

1. The last distance minus the motion of both bodies since may prove that it is beyond the cutoff.
2. The last answer may still be valid because both bodies rest.
3. Bounding volumes may separate the pair.
4. Coarse hulls may decide it, or answer as well as is wanted (``coarse_hulls``).
5. The kernel of its row in the pair table is called by address, with the last normal as hint.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    LEVEL_GAP,
    METHOD,
    PAIR_WIDTH,
    SEEN,
    SLACK,
    UNIQUE,
    Aim,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOUND_ONLY,
    HALF_SPACE,
    ITERATIVE,
    SOLID,
)
from drake_geom_ros.geometry._proximity.pairs.bounds_alone import bound_pair, raise_lower_end
from drake_geom_ros.geometry._proximity.pairs.coarse_hulls import hit_or_call
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import (
    BoundedBodies,
    apart,
    separation_of_bounds,
)
from drake_geom_ros.geometry._proximity.pairs.error_bounds import (
    hides_contact,
    rounding_of_pair,
    size_of_pair,
    tolerance_of_pair,
)
from drake_geom_ros.geometry._proximity.pairs.kernel_calls import recall
from drake_geom_ros.geometry._proximity.pairs.slots import Query, Queue, Search, Shapes
from drake_geom_ros.geometry._proximity.report import BY_METHOD, CACHED, FAR, POSTPONED, WIDE
from drake_geom_ros.geometry._proximity.runtime.addresses import Addresses
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import row
from drake_geom_ros.geometry._proximity.tolerances import (
    COARSEST_GAP,
    EPS,
    PROMISED_ROUNDING,
    ROUNDING,
    TOUCHING_DEPTH,
)
from drake_geom_ros.geometry._proximity.world.arrays import world_of

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@inlined
def _may_leap(out: Floats, moved: float, type_a: int, type_b: int) -> bool:
    """Return whether the distance can have changed by more than both bodies have ``moved`` [m].

    A peg that turns slightly into the walls of its hole suddenly has to leave the whole hole.
    Motion bounds the change only while bodies stay apart: then the distance is the least distance
    of any two points.
    """
    may_be_hollow = max(type_a, type_b) >= SOLID  # a solid or a map
    return may_be_hollow and out[DISTANCE] - out[ERROR_BOUND] <= moved


@inlined
def _take_narrower(out: Floats, bounds: Floats, moved: float) -> None:
    """Write the bounds as the answer, or widen the last one by the motion of both bodies [m].

    A support value changes by no more than the points move, so the distance of convex bodies
    changes by no more than both have moved. So does that of any bodies that stay apart. A widened
    answer retains its normal and witness points.
    """
    if out[ERROR_BOUND] + moved <= bounds[ERROR_BOUND]:
        out[ERROR_BOUND] += moved
        out[UNIQUE], out[METHOD] = 0.0, BOUND_ONLY
        return
    for c in range(PAIR_WIDTH):
        out[c] = bounds[c]


@inlined
def _slack(least: float, travelled: float, type_a: int, type_b: int) -> float:
    """Return a lower bound of a distance plus the travels at the same time [m], rounded down.

    A turning half space moves by no bounded amount.
    """
    if type_a == HALF_SPACE or type_b == HALF_SPACE:
        return -math.inf
    return least + travelled - 4.0 * EPS * (abs(least) + travelled)


@inlined
def _least(out: Floats, level_gap: float, size: float, rounding: float) -> float:
    """Return a lower bound of the distance [m] from an answer computed for ``level_gap``.

    ``rounding`` [m] is that of the pair's poses, which the error bound includes.
    """
    if out[METHOD] == BOUND_ONLY and not math.isinf(level_gap):
        # A kernel that stopped at the cutoff reports its lower bound.
        return out[DISTANCE] - rounding - 2.0 * ROUNDING * EPS * (size + abs(out[DISTANCE]))
    return out[DISTANCE] - out[ERROR_BOUND]


@inlined
def _postpone(k: int, least: float, waiting: Indices, distances: Floats, counts: Indices) -> None:
    """Put pair k into the queue, with the lower bound of its distance if the queue stores it."""
    waiting[counts[POSTPONED]] = k
    if distances.size > 0:
        distances[counts[POSTPONED]] = least
    counts[POSTPONED] += 1


@inlined
def _is_hit(out: Floats, size: float, cutoff: float, penetrating: bool) -> bool:
    """Return whether a pair may be within the cutoff or, if ``penetrating``, overlaps.

    From bounds alone, a pair that may overlap is a hit. A kernel that stopped early has certified
    that the pair is beyond the cutoff.
    """
    from_bounds = math.isinf(out[LEVEL_GAP])
    least = out[DISTANCE] - out[ERROR_BOUND]
    if penetrating:
        return (least if from_bounds else out[DISTANCE]) < -TOUCHING_DEPTH * size
    return least <= cutoff and (from_bounds or out[METHOD] != BOUND_ONLY)


@inlined
def _stands(out: Floats, level_gap: float, travelled: float, cutoff: float) -> bool:
    """Return whether the last answer of resting bodies is valid at this level and cutoff.

    An answer of a kernel that stopped at its cutoff is valid for smaller cutoffs only.
    """
    stopped = out[METHOD] == BOUND_ONLY and out[SLACK] - travelled <= cutoff
    return out[LEVEL_GAP] == level_gap < math.inf and not stopped


@inlined
def _widen(
    out: Floats, level_gap: float, aimed: float, extent: float, rounding: float, counts: Indices
) -> None:
    """Add the rounding of a pair's poses [m] to its error bound, and count the pair.

    It is counted by its method, and as wide if the bound exceeds the promise. Answers from bounds
    alone and of solids promise no width. ``aimed`` [m] is the gap that iterations aim for.
    """
    promised = aimed if level_gap <= COARSEST_GAP else level_gap
    promised += PROMISED_ROUNDING * EPS * extent
    counts[WIDE] += out[METHOD] <= ITERATIVE and out[ERROR_BOUND] > promised
    counts[BY_METHOD + int(out[METHOD])] += 1
    out[ERROR_BOUND] += rounding


@inlined
def _beyond(cutoff: float, size: float, rounding: float) -> float:
    """Return the kernel's cutoff [m]: beyond it, a pair exceeds ``cutoff`` despite rounding."""
    return cutoff + rounding + 4.0 * ROUNDING * EPS * (size + abs(cutoff))


@inlined
def _as_only_hit(k: int, hits: Indices, counts: Indices) -> int:
    """Write pair k as the only hit, counted as answered from bounds; return 1."""
    hits[0] = k
    counts[BY_METHOD + BOUND_ONLY] += 1
    return 1


@allocating
def answer_pairs(
    kernels: Addresses,
    pairs: Indices,
    slots: Indices,
    memory: Floats,
    world: Handle,
    revision: int,
    query: tuple[float, float, bool],
    search: tuple[int, float],
    queue: tuple[Indices, Floats],
    hits: Indices,
    counts: Indices,
) -> int:
    """Update the slots of the pairs that may be within the cutoff; return the number of hits.

    ``kernels`` are addresses, ``world`` is a handle, ``memory`` is as made by
    ``slots.empty_memory``; ``query``, ``search`` and ``queue`` are plain tuples of the records in
    ``slots``. ``hits`` gets the numbers of the pairs.

    - An infinite level gap uses the current bounds alone: reusing earlier answers would make the
      answer depend on earlier queries.
    - Where one hit will do, the first ends the loop. A pair that is certain to be within
      ``search.enough`` is a hit, and its slot stays unchanged: a solid or a map that plainly
      overlaps, or coarse hulls that are that near.
    - A queue that fits all pairs gets those that need a kernel, with lower bounds of their
      distances if it fits these, too. With an empty queue, kernels run.
    - A cutoff below 0 excludes no pair by its depth: boxes that overlap are 0 apart, and the
      distance of a solid may leap (see ``_may_leap``).

    Records are unpacked before the loop: passing on that of the world made a pair of spheres take
    6 ns longer (5 % of the loop). A tuple of arrays made before the loop cost half as much again,
    because references are counted; one made in a call costs nothing.
    """
    world, query, queue = world_of(world), Query(*query), Queue(*queue)
    types, R_WGs, p_WGs, roundings = world.types, world.R_WGs, world.p_WGs, world.roundings
    halves, outer, inner = world.half_extents, world.outer, world.inner
    travels, stamps, starts, pool = world.travels, world.stamps, world.starts, world.pool
    (level_gap, cutoff, penetrating), (first, enough) = query, Search(*search)
    p_AB_W, now = np.empty(3), np.empty(PAIR_WIDTH)
    limit = max(cutoff, 0.0)
    far_cutoff = math.inf if math.isinf(level_gap) else limit
    counts[:], hit_count = 0, 0
    for turn in range(slots.size):
        k = turn if first < 0 else (first + turn) % slots.size
        a, b, s = pairs[k, 0], pairs[k, 1], slots[k]
        out, travelled = row(memory, s), travels[a] + travels[b]
        if out[SLACK] - travelled > far_cutoff:
            counts[FAR] += 1
            continue
        size = size_of_pair(a, b, types, outer)
        if max(stamps[a], stamps[b]) <= out[SEEN] and _stands(out, level_gap, travelled, cutoff):
            counts[CACHED] += 1
        else:
            bodies = BoundedBodies(types, R_WGs, p_WGs, roundings, halves, outer)
            least = separation_of_bounds(a, b, bodies, limit)
            near = least <= limit
            if near and queue.waiting.size > 0:
                if queue.distances.size > 0:
                    bound_pair(a, b, Shapes(types, starts, pool), R_WGs, p_WGs, inner, p_AB_W, now)
                    least = max(now[DISTANCE] - now[ERROR_BOUND], out[SLACK] - travelled)
                _postpone(k, least, queue.waiting, queue.distances, counts)
                continue
            if near:
                extent = size + apart(p_WGs, a, b)
                tolerance = tolerance_of_pair(level_gap, a, b, outer)
                rounding = rounding_of_pair(a, b, extent, roundings)
                if math.isinf(level_gap):
                    bound_pair(a, b, Shapes(types, starts, pool), R_WGs, p_WGs, inner, p_AB_W, out)
                else:
                    shapes, poses = Shapes(types, starts, pool), (R_WGs, p_WGs)
                    aim = Aim(size, tolerance, _beyond(cutoff, size, rounding), level_gap)
                    recall(out, level_gap, types[a], types[b])
                    if hit_or_call(a, b, kernels, shapes, poses, p_AB_W, aim, enough, out, now):
                        return _as_only_hit(k, hits, counts)
                _widen(out, level_gap, tolerance, extent, rounding, counts)
                if math.isinf(level_gap):
                    raise_lower_end(a, b, bodies, out)
                out[SEEN], out[LEVEL_GAP] = revision, level_gap
                least = _least(out, level_gap, size, rounding)
            else:
                counts[FAR], out[SEEN] = counts[FAR] + 1, -1.0  # the slack is not its answer's
            out[SLACK] = _slack(least, travelled, types[a], types[b])
            if not near:
                continue
        hit = _is_hit(out, size, cutoff, penetrating)
        if hit or (first >= 0 and hides_contact(out, a, b, size + apart(p_WGs, a, b), roundings)):
            hits[hit_count], hit_count = k, hit_count + 1
            if first >= 0:
                break
    return hit_count


@allocating
def bound_pairs(
    pairs: Indices,
    slots: Indices,
    memory: Floats,
    world: Handle,
    revision: int,
    query: tuple[float, float, bool],
    hits: Indices,
    counts: Indices,
) -> int:
    """Update the slots of queued pairs from bounds alone; return the number of hits.

    No kernel runs. The answer is the narrower of the bounding interval and the last answer widened
    by the motion of both bodies since; its level gap, minus infinity, matches no query. This loop
    is separate from ``answer_pairs`` because merging them made sphere kernels 10 % slower.
    """
    world, query = world_of(world), Query(*query)
    types, starts, pool = world.types, world.starts, world.pool
    R_WGs, p_WGs = world.R_WGs, world.p_WGs
    outer, inner, travels, stamps = world.outer, world.inner, world.travels, world.stamps
    cutoff, penetrating = query.cutoff, query.penetrating
    p_AB_W, bounds = np.empty(3), np.empty(PAIR_WIDTH)
    counts[:] = 0
    hit_count = 0
    for k in range(slots.size):
        a, b, s = pairs[k, 0], pairs[k, 1], slots[k]
        out, size = row(memory, s), size_of_pair(a, b, types, outer)
        travelled = travels[a] + travels[b]
        if stamps[a] <= out[SEEN] and stamps[b] <= out[SEEN] and math.isinf(out[LEVEL_GAP]):
            counts[CACHED] += 1
        else:
            shapes = Shapes(types, starts, pool)
            bound_pair(a, b, shapes, R_WGs, p_WGs, inner, p_AB_W, bounds)
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
            hits[hit_count] = k
            hit_count += 1
    return hit_count
