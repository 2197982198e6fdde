"""Nearest pairs of many states, and tests for near pairs, by certified lower bounds.

Pairs are ordered by the lower end of their interval, distance minus error bound. The interval of
the pair with the least lower end contains the least distance of all pairs: every pair is certified
to be at least as far apart as that end, and this pair is no farther than its upper end. Omitted
pairs are certified to be beyond the cutoff, or farther than the pairs returned.

As in ``loops``, no answer of one state affects the next.
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
from drake_geom_ros.geometry._proximity.pairs.slots import EVERY_HIT, no_queue
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
    """Return how far [m] the lower end of an answer may be below another certified bound.

    This is twice the largest ``error_bounds.promised_error_bound`` of all pairs. From bounds alone
    it is rounding, because no box or ball is sharper than such an answer.
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
    """Return the lower end of an answer [m]; infinity for a pair beyond the cutoff.

    Boxes or balls certified that, or a kernel that stopped at the cutoff.
    """
    stopped = out[METHOD] == BOUND_ONLY and not math.isinf(out[LEVEL_GAP])
    if out[SEEN] < 0.0 or stopped:
        return math.inf
    return out[DISTANCE] - out[ERROR_BOUND]


@inlined
def may_be_within(hit_count: int, out: Floats, margin: float) -> bool:
    """Return whether a pair may be within a margin [m], from its slot, cleared before the query.

    A hit without an answer is a solid or a map that plainly overlaps.
    """
    return (hit_count > 0 and out[SEEN] < 0.0) or lower_end(out) <= margin


@inlined
def _take_nearest(order: Indices, left: int, bounds: Floats, most: float) -> int:
    """Move the pair of the least bound to the end of those left; return their number, with it.

    Pairs whose bound is above ``most`` [m] are dropped.
    """
    remaining, least = 0, math.inf
    for r in range(left):
        k = order[r]
        if bounds[k] <= most:
            order[remaining] = k
            if remaining == 0 or bounds[k] < least:
                order[remaining], order[0], least = order[0], k, bounds[k]
            remaining += 1
    if remaining:
        order[0], order[remaining - 1] = order[remaining - 1], order[0]
    return remaining


@inlined
def _insert(
    count: int,
    number: int,
    end: float,
    answer: Floats,
    numbers: Indices,
    ends: Floats,
    answers: Floats,
) -> int:
    """Insert an answer among those (most,) of the least lower ends, in order; return their number.

    Of equal ends, the pair with the lower number comes first.
    """
    most, at = numbers.size, count
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
    return min(count + 1, most)


@allocating
def nearest_pairs(
    scene: SceneArrays,
    poses: Floats,
    query: tuple[float, float, bool],
    stop: Indices,
    answers: tuple[Indices, Indices, Floats],
) -> int:
    """Answer for the nearest pairs of each state (N, n, 7); return the number of states done.

    ``answers`` are filled: counts (N,) of the pairs that may be within the cutoff, at most
    ``most``; and ids (N, most, 2) and rows (N, most, BATCH_WIDTH) of those of the least lower
    ends, in their order. The loop ends when ``stop`` (1,) is set, or at a state with an invalid
    pose.

    Pairs are answered in the order of their bounds from boxes and balls, and only while their
    bounds may be as low as the ends found so far. This limit is the cutoff of kernels, which stop
    once they certify that a pair is farther; the answers of nearer pairs do not depend on
    it.
    """
    kernels, rows, world, pairs, groups = scene
    posed, groups = world_of(world), Groups(*groups)
    (level_gap, cutoff, _), (found_counts, ids, out) = query, answers
    total, most = pairs.shape[0], ids.shape[1]
    Xs = np.empty((rows.size, POSE_WIDTH))
    bounds, order = np.empty(total), np.empty(total, dtype=np.int64)
    one, slot, hits = np.empty((1, 2), np.int64), np.zeros(1, np.int64), np.zeros(1, np.int64)
    counts = np.zeros(COUNTS, dtype=np.int64)
    memory, queue, search = np.zeros((1, SLOT_WIDTH)), no_queue(), EVERY_HIT
    best, ends, best_answers = (
        np.empty(most, np.int64),
        np.empty(most),
        np.empty((most, PAIR_WIDTH)),
    )
    slots, both = np.arange(most), np.empty((most, 2), dtype=np.int64)
    some_ids, full = np.empty((most, 2), dtype=np.int64), np.empty((most, BATCH_WIDTH))
    for s in range(poses.shape[0]):
        if stop[0] or not pose_state(poses[s], rows, Xs, world):
            return s
        put_boxes(groups, posed)
        below = most_below(level_gap, posed)
        limit, count = cutoff, 0
        for turn in range(min(2, groups.separations.size)):
            # The nearest two groups come first, because their pairs exclude most others.
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
                pair_query = (level_gap, limit + below, False)
                answer_pairs(
                    kernels, one, slot, memory, world, 1, pair_query, search, queue, hits, counts
                )
                end = lower_end(memory[0])
                if end <= limit and end < math.inf:
                    count = _insert(count, k, end, memory[0], best, ends, best_answers)
                    if count == most:
                        limit = ends[most - 1]
        found_counts[s] = count
        for r in range(count):
            both[r, 0], both[r, 1] = pairs[best[r], 0], pairs[best[r], 1]
        gather_rows(slots[:count], both, slots, best_answers, level_gap, world, some_ids, full)
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
    """Decide for each state (N, n, 7) whether a pair may be within the cutoff.

    ``out`` (N,) is False where every pair is certified to be farther. A state ends at the first
    pair that is not. The loop ends as in ``nearest_pairs``; return the number of states done.
    """
    kernels, rows, world, pairs, groups = scene
    posed, groups = world_of(world), Groups(*groups)
    level_gap, cutoff, _ = query
    search = (0, cutoff)  # without what is added below to the cutoff of kernels
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
        pair_query = (level_gap, cutoff + below, False)
        everything = (0, groups.separations.size, -1)
        count = collect(groups, everything, cutoff + below, pairs, posed, order, bounds)
        for r in range(count):
            if order[r] == last:  # a pair that was near usually still is
                order[0], order[r] = last, order[0]
        out[s] = False
        for r in range(count):
            k = order[r]
            one[0, 0], one[0, 1] = pairs[k, 0], pairs[k, 1]
            forget(memory, 0, 1)
            hit_count = answer_pairs(
                kernels, one, slot, memory, world, 1, pair_query, search, queue, hits, counts
            )
            if may_be_within(hit_count, memory[0], cutoff):
                out[s], last = True, k
                break
    return poses.shape[0]
