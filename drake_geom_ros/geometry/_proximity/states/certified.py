"""The nearest pairs of many states, and whether any is near: told by certified lower bounds.

A pair counts by the lower end of its interval, distance minus error bound. The pair whose lower
end is the least of all has an interval that holds the least distance of all pairs: no pair is
nearer than that end, and the pair itself is no farther than the other one. What is left out is
certified to be farther than what was asked for, or than what is told.

As in ``loops`` no answer of one state enters the next.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    LEVEL_GAP,
    METHOD,
    PAIR_WIDTH,
    SEEN,
    SLOT_WIDTH,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, HALF_SPACE
from drake_geom_ros.geometry._proximity.pairs.answer_rows import BATCH_WIDTH, gather_rows
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs
from drake_geom_ros.geometry._proximity.pairs.slots import no_queue
from drake_geom_ros.geometry._proximity.report import COUNTS
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.states.groups import Groups, collect, put_boxes
from drake_geom_ros.geometry._proximity.states.loops import SceneArrays, forget, pose_state
from drake_geom_ros.geometry._proximity.tolerances import EPS, PROMISED_ROUNDING
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of
from drake_geom_ros.geometry._proximity.world.pose_rounding import RADIUS, TILT
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH


@inlined
def most_below(level_gap: float, world: WorldArrays) -> float:
    """Return how far [m] the lower end of an answer may be below any certified bound.

    That is twice what ``error_bounds.promised_error_bound`` is of any pair. Of bounds alone it is
    rounding: no box or ball knows more of a pair than they tell.
    """
    types, p_WGs, roundings, outer = world.types, world.p_WGs, world.roundings, world.outer
    extent, radius, tilt = 0.0, 0.0, 0.0
    for g in range(types.size):
        size = 0.0 if types[g] == HALF_SPACE else outer[g]
        extent = max(extent, size + abs(p_WGs[g, 0]) + abs(p_WGs[g, 1]) + abs(p_WGs[g, 2]))
        radius, tilt = max(radius, roundings[g, RADIUS]), max(tilt, roundings[g, TILT])
    promised = 0.0 if math.isinf(level_gap) else level_gap
    promised += 2.0 * (radius + extent * (2.0 * tilt + PROMISED_ROUNDING * EPS))
    return 2.0 * promised


@inlined
def lower_end(out: Floats) -> float:
    """Return the lower end of an answer [m]; infinity for a pair kept apart from what was asked.

    Boxes or balls did that, or a kernel that stopped at the cutoff.
    """
    stopped = out[METHOD] == BOUND_ONLY and not math.isinf(out[LEVEL_GAP])
    if out[SEEN] < 0.0 or stopped:
        return math.inf
    return out[DISTANCE] - out[ERROR_BOUND]


@inlined
def may_be_within(found: int, out: Floats, margin: float) -> bool:
    """Tell whether a pair may be within a margin [m], by its slot, which was forgotten before.

    A solid that was found, and has no answer, was seen to overlap without one.
    """
    return (found > 0 and out[SEEN] < 0.0) or lower_end(out) <= margin


@inlined
def _take_nearest(order: Indices, left: int, bounds: Floats, most: float) -> int:
    """Put the pair of least bound behind those that are left; return how many are, with it.

    Pairs whose bound is above ``most`` [m] are dropped on the way.
    """
    kept, least = 0, math.inf
    for r in range(left):
        k = order[r]
        if bounds[k] <= most:
            order[kept] = k
            if kept == 0 or bounds[k] < least:
                order[kept], order[0], least = order[0], k, bounds[k]
            kept += 1
    if kept:
        order[0], order[kept - 1] = order[kept - 1], order[0]
    return kept


@inlined
def _insert(
    found: int,
    number: int,
    end: float,
    answer: Floats,
    numbers: Indices,
    ends: Floats,
    answers: Floats,
) -> int:
    """Put an answer among those (most,) of the least lower ends, in order; return how many.

    Of equal ends the pair with the lower number is the first.
    """
    most, at = numbers.size, found
    while at > 0:
        if ends[at - 1] < end or (ends[at - 1] == end and numbers[at - 1] < number):
            break
        if at < most:
            numbers[at], ends[at] = numbers[at - 1], ends[at - 1]
            for c in range(PAIR_WIDTH):
                answers[at, c] = answers[at - 1, c]
        at -= 1
    if at == most:
        return most
    numbers[at], ends[at] = number, end
    for c in range(PAIR_WIDTH):
        answers[at, c] = answer[c]
    return min(found + 1, most)


@allocating
def nearest_pairs(
    scene: SceneArrays,
    poses: Floats,
    query: tuple[float, float, bool],
    stop: Indices,
    answers: tuple[Indices, Indices, Floats],
) -> int:
    """Answer for the nearest pairs of each state (N, n, 7); return how many states are done.

    ``answers`` are filled: found (N,), how many pairs may be within the cutoff, at most as many as
    ids (N, most, 2) and out (N, most, BATCH_WIDTH) have room for: their ids and rows, those of the
    least lower ends, in their order. States are done until ``stop`` (1,) is set, or one has a pose
    that is none.

    Pairs are answered in the order of what boxes and balls know of them, and only those that may
    have as low an end as what was found. What a kernel is told as a cutoff is that end: it stops
    when it has certified that a pair is farther away, and changes no digit of a pair that is not.
    """
    kernels, rows, world, pairs, groups = scene
    posed, groups = world_of(world), Groups(*groups)
    (level_gap, cutoff, _), (found, ids, out) = query, answers
    total, most = pairs.shape[0], ids.shape[1]
    Xs = np.empty((rows.size, POSE_WIDTH))
    bounds, order = np.empty(total), np.empty(total, dtype=np.int64)
    one, slot, hits = np.empty((1, 2), np.int64), np.zeros(1, np.int64), np.zeros(1, np.int64)
    counts = np.zeros(COUNTS, dtype=np.int64)
    memory, queue = np.zeros((1, SLOT_WIDTH)), no_queue()
    best, ends, kept = np.empty(most, np.int64), np.empty(most), np.empty((most, PAIR_WIDTH))
    slots, both = np.arange(most), np.empty((most, 2), dtype=np.int64)
    some_ids, full = np.empty((most, 2), dtype=np.int64), np.empty((most, BATCH_WIDTH))
    for s in range(poses.shape[0]):
        if stop[0] or not pose_state(poses[s], rows, Xs, world):
            return s
        put_boxes(groups, posed)
        below = most_below(level_gap, posed)
        limit, count = cutoff, 0
        for turn in range(min(2, groups.separations.size)):
            # The two groups that are nearest come first: what they hold leaves out most others.
            nearest = int(np.argmin(groups.separations))
            first, last, skipped = nearest, nearest + 1, -1
            if turn == 1:
                first, last, skipped = 0, groups.separations.size, nearest
            which = (first, last, skipped)
            left = collect(groups, which, limit + below, pairs, posed, order, bounds)
            while True:
                left = _take_nearest(order, left, bounds, limit + below) - 1
                if left < 0:
                    break
                k = order[left]
                one[0, 0], one[0, 1] = pairs[k, 0], pairs[k, 1]
                forget(memory, 0, 1)
                asked = (level_gap, limit + below, False)
                answer_pairs(kernels, one, slot, memory, world, 1, asked, -1, queue, hits, counts)
                end = lower_end(memory[0])
                if end <= limit and end < math.inf:
                    count = _insert(count, k, end, memory[0], best, ends, kept)
                    if count == most:
                        limit = ends[most - 1]
        found[s] = count
        for r in range(count):
            both[r, 0], both[r, 1] = pairs[best[r], 0], pairs[best[r], 1]
        gather_rows(slots[:count], both, slots, kept, level_gap, world, some_ids, full)
        for r in range(count):
            ids[s, r, 0], ids[s, r, 1] = some_ids[r, 0], some_ids[r, 1]
            for c in range(BATCH_WIDTH):
                out[s, r, c] = full[r, c]
    return poses.shape[0]


@allocating
def any_near(
    scene: SceneArrays,
    poses: Floats,
    query: tuple[float, float, bool],
    stop: Indices,
    out: Booleans,
) -> int:
    """Tell of each state (N, n, 7) whether a pair may be within the cutoff; return how many.

    ``out`` (N,) is False where every pair is certified to be farther. Each state ends at the first
    pair that is not. How many states are done is as in ``nearest_pairs``.
    """
    kernels, rows, world, pairs, groups = scene
    posed, groups = world_of(world), Groups(*groups)
    level_gap, cutoff, _ = query
    Xs = np.empty((rows.size, POSE_WIDTH))
    bounds, order = np.empty(pairs.shape[0]), np.empty(pairs.shape[0], dtype=np.int64)
    one, slot, hits = np.empty((1, 2), np.int64), np.zeros(1, np.int64), np.zeros(1, np.int64)
    counts, memory = np.zeros(COUNTS, dtype=np.int64), np.zeros((1, SLOT_WIDTH))
    queue = no_queue()
    last = -1
    for s in range(poses.shape[0]):
        if stop[0] or not pose_state(poses[s], rows, Xs, world):
            return s
        put_boxes(groups, posed)
        below = most_below(level_gap, posed)
        asked = (level_gap, cutoff + below, False)
        everything = (0, groups.separations.size, -1)
        count = collect(groups, everything, cutoff + below, pairs, posed, order, bounds)
        for r in range(count):
            if order[r] == last:  # what was near still is, mostly
                order[0], order[r] = last, order[0]
        out[s] = False
        for r in range(count):
            k = order[r]
            one[0, 0], one[0, 1] = pairs[k, 0], pairs[k, 1]
            forget(memory, 0, 1)
            found = answer_pairs(
                kernels, one, slot, memory, world, 1, asked, 0, queue, hits, counts
            )
            if may_be_within(found, memory[0], cutoff):
                out[s], last = True, k
                break
    return poses.shape[0]
