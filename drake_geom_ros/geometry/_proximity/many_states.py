"""Many states of one world, in compiled loops: each is posed, and answered as if it were alone.

No answer of one state enters the next: every pair is computed without a hint, so what is returned
is, to the bit, what a query tells that has seen no other state, in whatever order the states come
and wherever their row is cut. What a state may leave behind costs no bit: frames that stand still
are not posed again, and a pair that overlapped is the first to be looked at in the next state.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.batches import BATCH_WIDTH, gather_rows
from drake_geom_ros.geometry._proximity.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    NORMAL,
    PAIR_WIDTH,
    SEEN,
    SLACK,
    SLOT_WIDTH,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.narrow_phase import COUNTS, answer_pairs
from drake_geom_ros.geometry._proximity.point_phase import point_phase
from drake_geom_ros.geometry._proximity.pose_rounding import RADIUS, TILT
from drake_geom_ros.geometry._proximity.poses import POSE_WIDTH, read_poses
from drake_geom_ros.geometry._proximity.posing import set_poses, update
from drake_geom_ros.geometry._proximity.records import world_of
from drake_geom_ros.geometry._proximity.state_groups import Groups, collect, put_boxes
from drake_geom_ros.geometry._proximity.tolerances import EPS, PROMISED_ROUNDING


@compiled
def _pose(poses, rows, Xs, world):  # type: ignore[no-untyped-def]
    """Pose the frames of rows (n,) by poses (n, 7); return whether all of these are poses.

    The world is given by its handle; ``Xs`` (n, POSE_WIDTH) is room.
    """
    if read_poses(poses, Xs) < rows.size:
        return False
    if set_poses(rows, Xs, world):
        update(world, 1)
    return True


@inlined
def _forget(memory, first, last):  # type: ignore[no-untyped-def]
    """Forget what is known of some pairs, the hints too."""
    for s in range(first, last):
        memory[s, SLACK], memory[s, SEEN] = -math.inf, -1.0
        for c in range(3):
            memory[s, NORMAL + c] = 0.0


@inlined
def _most_below(gap, world):  # type: ignore[no-untyped-def]
    """Return how far any distance may be reported below the true one [m], at a level's gap.

    That is no less than ``promise.promised_bound`` of any pair.
    """
    types, p_WGs, roundings, outer = world.types, world.p_WGs, world.roundings, world.outer
    extent, radius, tilt = 0.0, 0.0, 0.0
    for g in range(types.size):
        size = 0.0 if types[g] == HALF_SPACE else outer[g]
        extent = max(extent, size + abs(p_WGs[g, 0]) + abs(p_WGs[g, 1]) + abs(p_WGs[g, 2]))
        radius, tilt = max(radius, roundings[g, RADIUS]), max(tilt, roundings[g, TILT])
    return gap + 2.0 * (radius + extent * (2.0 * tilt + PROMISED_ROUNDING * EPS))


@inlined
def _take_nearest(order, left, bounds, most):  # type: ignore[no-untyped-def]
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
def _insert(found, number, answer, numbers, answers):  # type: ignore[no-untyped-def]
    """Put an answer among those (most,) that are nearest, in order; return how many there are.

    Of equal distances the pair with the lower number is the first.
    """
    most, at = numbers.size, found
    while at > 0:
        d, e = answers[at - 1, DISTANCE], answer[DISTANCE]
        if d < e or (d == e and numbers[at - 1] < number):
            break
        if at < most:
            numbers[at] = numbers[at - 1]
            for c in range(PAIR_WIDTH):
                answers[at, c] = answers[at - 1, c]
        at -= 1
    if at == most:
        return most
    numbers[at] = number
    for c in range(PAIR_WIDTH):
        answers[at, c] = answer[c]
    return min(found + 1, most)


@allocating
def nearest_pairs(  # type: ignore[no-untyped-def]
    kernels, poses, rows, world, pairs, groups, query, stop, found, ids, out
):
    """Answer for the nearest pairs of each state (N, n, 7); return how many states are done.

    ``found`` (N,) gets how many pairs there are within the cutoff, at most as many as ``ids``
    (N, most, 2) and ``out`` (N, most, BATCH_WIDTH) have room for: their ids and rows, the nearest
    first. States are done until ``stop`` (1,) is set, or one has a pose that is none.

    A kernel runs for the pair of the least bound first, and then only for those that may be as
    near as what was found. What it is told as a cutoff is that distance: a kernel stops when it
    has certified that a pair is farther away, and changes no digit of a pair that is not.
    """
    posed, groups = world_of(world), Groups(*groups)
    gap, cutoff, _ = query
    total, most = pairs.shape[0], ids.shape[1]
    Xs = np.empty((rows.size, POSE_WIDTH))
    bounds, order = np.empty(total), np.empty(total, dtype=np.int64)
    one, slot, hits = np.empty((1, 2), np.int64), np.zeros(1, np.int64), np.zeros(1, np.int64)
    counts = np.zeros(COUNTS, dtype=np.int64)
    memory = np.zeros((1, SLOT_WIDTH))
    queue = (np.zeros(0, dtype=np.int64), np.zeros(0))  # in which no pair waits
    best, kept = np.empty(most, dtype=np.int64), np.empty((most, PAIR_WIDTH))
    slots, both = np.arange(most), np.empty((most, 2), dtype=np.int64)
    some_ids, full = np.empty((most, 2), dtype=np.int64), np.empty((most, BATCH_WIDTH))
    for s in range(poses.shape[0]):
        if stop[0] or not _pose(poses[s], rows, Xs, world):
            return s
        put_boxes(groups, posed)
        below = _most_below(gap, posed)
        limit, count = cutoff, 0
        for turn in range(min(2, groups.gaps.size)):
            # The two groups that are nearest come first: what they hold leaves out most others.
            nearest = np.argmin(groups.gaps)
            span = (nearest, nearest + 1, -1) if turn == 0 else (0, groups.gaps.size, nearest)
            left = collect(groups, *span, limit + below, pairs, posed, order, bounds)
            while True:
                left = _take_nearest(order, left, bounds, limit + below) - 1
                if left < 0:
                    break
                k = order[left]
                one[0, 0], one[0, 1] = pairs[k, 0], pairs[k, 1]
                _forget(memory, 0, 1)
                # Bounds alone have no running cutoff: they report the middle of an interval.
                asked = (gap, cutoff if math.isinf(gap) else limit, False)
                if answer_pairs(
                    kernels, one, slot, memory, world, 1, asked, -1, queue, hits, counts
                ):
                    count = _insert(count, k, memory[0], best, kept)
                    if count == most:
                        limit = kept[most - 1, DISTANCE]
        found[s] = count
        for r in range(count):
            both[r, 0], both[r, 1] = pairs[best[r], 0], pairs[best[r], 1]
        gather_rows(slots[:count], both, slots, kept, gap, world, some_ids, full)
        for r in range(count):
            ids[s, r, 0], ids[s, r, 1] = some_ids[r, 0], some_ids[r, 1]
            for c in range(BATCH_WIDTH):
                out[s, r, c] = full[r, c]
    return poses.shape[0]


@inlined
def _list(order, count, pairs, some, memory):  # type: ignore[no-untyped-def]
    """List the pairs of some numbers, of which nothing is known."""
    for r in range(count):
        some[r, 0], some[r, 1] = pairs[order[r], 0], pairs[order[r], 1]
    _forget(memory, 0, count)


@allocating
def any_overlap(  # type: ignore[no-untyped-def]
    kernels, poses, rows, world, pairs, groups, query, slots, memory, stop, hits, out
):
    """Tell of each state (N, n, 7) whether a pair overlaps; return how many states are done.

    ``out`` (N,) gets the answers of ``Engine.has_overlap``; each state ends at its first proof.
    """
    posed, groups = world_of(world), Groups(*groups)
    queue = (np.zeros(0, dtype=np.int64), np.zeros(0))  # in which no pair waits
    Xs = np.empty((rows.size, POSE_WIDTH))
    bounds, order = np.empty(slots.size), np.empty(slots.size, dtype=np.int64)
    counts, some = np.zeros(COUNTS, dtype=np.int64), np.empty_like(pairs)
    last = -1
    for s in range(poses.shape[0]):
        if stop[0] or not _pose(poses[s], rows, Xs, world):
            return s
        put_boxes(groups, posed)
        everything = (0, groups.gaps.size, -1, 0.0)
        count = collect(groups, *everything, pairs, posed, order, bounds)
        for r in range(count):
            if order[r] == last:  # where there was a contact there still is one, mostly
                order[0], order[r] = last, order[0]
        _list(order, count, pairs, some, memory)
        out[s] = False
        if count > 0 and answer_pairs(
            kernels, some, slots[:count], memory, world, 1, query, 0, queue, hits, counts
        ):
            out[s], last = True, order[hits[0]]
    return poses.shape[0]


@allocating
def pairs_in_reach(  # type: ignore[no-untyped-def]
    kernels,
    poses,
    first,
    rows,
    world,
    pairs,
    groups,
    query,
    slots,
    memory,
    stop,
    hits,
    offsets,
    ids,
    out,
):
    """Answer for all pairs of each state (N, n, 7) within the cutoff; return how many are done.

    ``offsets`` (N + 1,) get where each state's answers begin in ``ids`` (room, 2) and ``out``
    (room, BATCH_WIDTH). States are done from the ``first`` on, until there is no room, ``stop``
    (1,) is set, or one has a pose that is none.
    """
    posed, groups = world_of(world), Groups(*groups)
    gap, cutoff, _ = query
    reach = max(cutoff, 0.0)
    queue = (np.zeros(0, dtype=np.int64), np.zeros(0))  # in which no pair waits
    Xs = np.empty((rows.size, POSE_WIDTH))
    bounds, order = np.empty(slots.size), np.empty(slots.size, dtype=np.int64)
    counts, some = np.zeros(COUNTS, dtype=np.int64), np.empty_like(pairs)
    some_ids, full = np.empty_like(pairs), np.empty((pairs.shape[0], BATCH_WIDTH))
    for s in range(first, poses.shape[0]):
        if stop[0] or not _pose(poses[s], rows, Xs, world):
            return s
        put_boxes(groups, posed)
        everything = (0, groups.gaps.size, -1, reach)
        count = collect(groups, *everything, pairs, posed, order, bounds)
        order[:count].sort()
        _list(order, count, pairs, some, memory)
        count = answer_pairs(
            kernels, some, slots[:count], memory, world, 1, query, -1, queue, hits, counts
        )
        start = offsets[s]
        if start + count > ids.shape[0]:
            return s
        gather_rows(hits[:count], some, slots, memory, gap, world, some_ids, full)
        for k in range(count):
            ids[start + k, 0], ids[start + k, 1] = some_ids[k, 0], some_ids[k, 1]
            for c in range(BATCH_WIDTH):
                out[start + k, c] = full[k, c]
        offsets[s + 1] = start + count
    return poses.shape[0]


@allocating
def points_in_reach(  # type: ignore[no-untyped-def]
    kernels,
    pair_kernels,
    pair_rows,
    poses,
    first,
    rows,
    world,
    p_WQs,
    threshold,
    stop,
    offsets,
    points,
    ids,
    out,
):
    """Answer for points (m, 3) and all geometries, in each state (N, n, 7), as ``point_phase``.

    Returns how many states are done; the rest is as in ``pairs_in_reach``, with ``points``
    (room,) for which point an answer is of, and ``ids`` (room,), ``out`` (room, POINT_WIDTH).
    """
    room = p_WQs.shape[0] * world_of(world).ids.size
    Xs = np.empty((rows.size, POSE_WIDTH))
    counts = np.zeros(COUNTS, dtype=np.int64)
    full, there = np.empty((room, POINT_WIDTH)), np.zeros(room, dtype=np.bool_)
    some_points, some_ids = np.empty(room, dtype=np.uint32), np.empty(room, dtype=np.int64)
    for s in range(first, poses.shape[0]):
        if stop[0] or not _pose(poses[s], rows, Xs, world):
            return s
        there[:] = False
        count = point_phase(
            kernels,
            pair_kernels,
            pair_rows,
            world,
            p_WQs,
            threshold,
            full,
            there,
            some_points,
            some_ids,
            counts,
        )
        start = offsets[s]
        if start + count > ids.size:
            return s
        for k in range(count):
            points[start + k], ids[start + k] = some_points[k], some_ids[k]
            for c in range(POINT_WIDTH):
                out[start + k, c] = full[k, c]
        offsets[s + 1] = start + count
    return poses.shape[0]
