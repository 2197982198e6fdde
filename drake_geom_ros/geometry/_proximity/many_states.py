"""Many states of one world, in compiled loops: each is posed, and answered as if it were alone.

No answer of one state enters the next: every pair is computed without a hint, so what is returned
is, to the bit, what a query tells that has seen no other state, in whatever order the states come
and wherever their row is cut. What a state may leave behind costs no bit: frames that stand still
are not posed again, and a pair that overlapped is the first to be looked at in the next state.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.batches import BATCH_WIDTH
from drake_geom_ros.geometry._proximity.batches import _gather as gather_rows
from drake_geom_ros.geometry._proximity.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    NORMAL,
    PAIR_WIDTH,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.narrow_phase import COUNTS, answer_pairs
from drake_geom_ros.geometry._proximity.pair_gaps import gap_of_balls, gap_of_boxes
from drake_geom_ros.geometry._proximity.point_phase import point_phase
from drake_geom_ros.geometry._proximity.pose_rounding import RADIUS, TILT
from drake_geom_ros.geometry._proximity.poses import read_poses
from drake_geom_ros.geometry._proximity.posing import set_poses, update
from drake_geom_ros.geometry._proximity.records import Memory, Scene
from drake_geom_ros.geometry._proximity.tolerances import EPS, PROMISED_ROUNDING
from drake_geom_ros.math.tolerances import FARTHEST, QUATERNION_NORM


@compiled
def _pose(poses, rows, Rs, ps, arguments):  # type: ignore[no-untyped-def]
    """Pose the frames of rows (n,) by poses (n, 7); return whether all of these are poses.

    ``arguments`` are those of ``posing.update``; ``Rs`` (n, 3, 3) and ``ps`` (n, 3) are room.
    """
    if read_poses(poses, QUATERNION_NORM, FARTHEST, Rs, ps) < rows.size:
        return False
    if set_poses(rows, Rs, ps, arguments[2], arguments[3], arguments[0]):
        update(1, *arguments)
    return True


@inlined
def _forget(memory, first, last):  # type: ignore[no-untyped-def]
    """Forget what is known of some pairs, the hints too."""
    for s in range(first, last):
        memory.slacks[s], memory.seen[s] = -math.inf, -1
        for c in range(3):
            memory.answers[s, NORMAL + c] = 0.0


@inlined
def least_possible(i, j, types, R_WGs, p_WGs, roundings, half_extents, outer):  # type: ignore[no-untyped-def]
    """Return a lower bound [m] of a signed distance, of bodies that overlap too.

    The depth of convex bodies is no more than the overlap of their shadows on any line, so no
    more than that of their boxes along an axis or of their balls along the line of the centres.
    """
    gap = gap_of_boxes(i, j, types, R_WGs, p_WGs, roundings, half_extents)
    if types[i] == HALF_SPACE or types[j] == HALF_SPACE:
        return gap
    if gap == 0.0:
        if types[i] == SOLID or types[j] == SOLID:
            return -math.inf  # how deep a solid is, its hull does not tell
        gap, reach = -math.inf, 0.0
        for k in range(3):
            p, q = p_WGs[i, k], p_WGs[j, k]
            sizes = half_extents[i, k] + half_extents[j, k]
            gap, reach = max(gap, abs(p - q) - sizes), max(reach, abs(p) + abs(q) + sizes)
        gap -= 4.0 * EPS * reach
    return max(gap, gap_of_balls(i, j, p_WGs, roundings, outer))


@inlined
def _most_below(gap, types, p_WGs, roundings, outer):  # type: ignore[no-untyped-def]
    """Return how far any distance may be reported below the true one [m], at a level's gap.

    That is no less than ``promise.promised_bound`` of any pair.
    """
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
    kernels, poses, rows, arguments, scene, posed, pairs, query, stop, found, numbers, out
):
    """Answer for the nearest pairs of each state (N, n, 7); return how many states are done.

    ``found`` (N,) gets how many pairs there are within the cutoff, at most as many as ``numbers``
    (N, most) has room for, which gets their numbers among ``pairs``, the nearest first; ``out``
    (N, most, BATCH_WIDTH) gets their rows. States are done until ``stop`` (1,) is set, or one has
    a pose that is none.

    A kernel runs for the pair of the least bound first, and then only for those that may be as
    near as what was found. What it is told as a cutoff is that distance: a kernel stops when it
    has certified that a pair is farther away, and changes no digit of a pair that is not.
    """
    places = Scene(*scene)
    types, R_WGs, p_WGs, outer = places.types, places.R_WGs, places.p_WGs, places.outer
    roundings, half_extents = places.roundings, places.half_extents
    gap, cutoff, _ = query
    total, most = pairs.shape[0], numbers.shape[1]
    Rs, ps = np.empty((rows.size, 3, 3)), np.empty((rows.size, 3))
    bounds, order = np.empty(total), np.empty(total, dtype=np.int64)
    one, slot, hits = np.empty((1, 2), np.int64), np.zeros(1, np.int64), np.zeros(1, np.int64)
    counts = np.zeros(COUNTS, dtype=np.int64)
    memory = Memory(
        np.zeros((1, PAIR_WIDTH)), np.empty(1), np.empty(1, dtype=np.int64), np.zeros(1)
    )
    plain = (memory.answers, memory.slacks, memory.seen, memory.gaps)
    queue = (np.zeros(0, dtype=np.int64), np.zeros(0))  # in which no pair waits
    best, kept = np.empty(most, dtype=np.int64), np.empty((most, PAIR_WIDTH))
    all_slots, both = np.arange(most), np.empty((most, 2), dtype=np.int64)
    ids, full = np.empty((most, 2), dtype=np.int64), np.empty((most, BATCH_WIDTH))
    for s in range(poses.shape[0]):
        if stop[0] or not _pose(poses[s], rows, Rs, ps, arguments):
            return s
        below = _most_below(gap, types, p_WGs, roundings, outer)
        for k in range(total):
            a, b = pairs[k, 0], pairs[k, 1]
            bounds[k] = least_possible(a, b, types, R_WGs, p_WGs, roundings, half_extents, outer)
            order[k] = k
        left, limit, count = total, cutoff, 0
        while True:
            left = _take_nearest(order, left, bounds, limit + below)
            if left == 0:
                break
            left -= 1
            k = order[left]
            one[0, 0], one[0, 1] = pairs[k, 0], pairs[k, 1]
            _forget(memory, 0, 1)
            # Bounds alone have no running cutoff: what they report is the middle of an interval.
            asked = cutoff if math.isinf(gap) else limit
            query_now = (gap, asked, False)
            if answer_pairs(
                kernels, one, slot, plain, scene, 1, query_now, -1, queue, hits, counts
            ):
                count = _insert(count, k, memory.answers[0], best, kept)
                if count == most:
                    limit = kept[most - 1, DISTANCE]
        found[s] = count
        for r in range(count):
            numbers[s, r] = best[r]
            both[r, 0], both[r, 1] = pairs[best[r], 0], pairs[best[r], 1]
        gather_rows(all_slots[:count], both, all_slots, kept, gap, *posed, ids, full)
        for r in range(count):
            for c in range(BATCH_WIDTH):
                out[s, r, c] = full[r, c]
    return poses.shape[0]


@allocating
def any_overlap(  # type: ignore[no-untyped-def]
    kernels, poses, rows, arguments, scene, pairs, query, slots, memory, stop, hits, out
):
    """Tell of each state (N, n, 7) whether a pair overlaps; return how many states are done.

    ``out`` (N,) gets the answers of ``Engine.has_overlap``; each state ends at its first proof.
    """
    known = Memory(*memory)
    queue = (np.zeros(0, dtype=np.int64), np.zeros(0))  # in which no pair waits
    Rs, ps = np.empty((rows.size, 3, 3)), np.empty((rows.size, 3))
    counts = np.zeros(COUNTS, dtype=np.int64)
    first = 0
    for s in range(poses.shape[0]):
        if stop[0] or not _pose(poses[s], rows, Rs, ps, arguments):
            return s
        _forget(known, 0, slots.size)
        asked = (query[0], query[1], query[2])
        count = answer_pairs(
            kernels, pairs, slots, memory, scene, 1, asked, first, queue, hits, counts
        )
        out[s] = count > 0
        if count > 0:
            first = hits[0]
    return poses.shape[0]


@allocating
def pairs_in_reach(  # type: ignore[no-untyped-def]
    kernels,
    poses,
    first,
    rows,
    arguments,
    scene,
    posed,
    pairs,
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
    known = Memory(*memory)
    queue = (np.zeros(0, dtype=np.int64), np.zeros(0))  # in which no pair waits
    Rs, ps = np.empty((rows.size, 3, 3)), np.empty((rows.size, 3))
    counts = np.zeros(COUNTS, dtype=np.int64)
    some_ids, full = np.empty_like(pairs), np.empty((pairs.shape[0], BATCH_WIDTH))
    for s in range(first, poses.shape[0]):
        if stop[0] or not _pose(poses[s], rows, Rs, ps, arguments):
            return s
        _forget(known, 0, slots.size)
        asked = (query[0], query[1], query[2])
        count = answer_pairs(
            kernels, pairs, slots, memory, scene, 1, asked, -1, queue, hits, counts
        )
        start = offsets[s]
        if start + count > ids.shape[0]:
            return s
        gather_rows(hits[:count], pairs, slots, known.answers, query[0], *posed, some_ids, full)
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
    arguments,
    scene,
    geometry_ids,
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
    room = p_WQs.shape[0] * geometry_ids.size
    Rs, ps = np.empty((rows.size, 3, 3)), np.empty((rows.size, 3))
    counts = np.zeros(COUNTS, dtype=np.int64)
    full, there = np.empty((room, POINT_WIDTH)), np.zeros(room, dtype=np.bool_)
    some_points, some_ids = np.empty(room, dtype=np.uint32), np.empty(room, dtype=np.int64)
    for s in range(first, poses.shape[0]):
        if stop[0] or not _pose(poses[s], rows, Rs, ps, arguments):
            return s
        there[:] = False
        count = point_phase(
            kernels,
            pair_kernels,
            pair_rows,
            geometry_ids,
            scene,
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
