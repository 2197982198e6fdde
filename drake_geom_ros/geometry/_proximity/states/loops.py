"""Compiled loops over states of one world: each state is posed and answered independently.

No answer of one state affects the next, because every pair is computed without a hint. So results
are bitwise equal to those of a fresh query, in any order of the states and any split into batches.
Some work is reused without changing a bit: frames that stand still are not posed again, and the
next state begins with the pair that overlapped.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    NORMAL,
    SEEN,
    SLACK,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.pairs.answer_rows import BATCH_WIDTH, gather_rows
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs
from drake_geom_ros.geometry._proximity.pairs.slots import EVERY_HIT, no_queue
from drake_geom_ros.geometry._proximity.points.point_phase import TableArrays, point_phase
from drake_geom_ros.geometry._proximity.report import COUNTS
from drake_geom_ros.geometry._proximity.runtime.addresses import Addresses
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Indices, Unsigned32
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.states.groups import (
    GroupArrays,
    Groups,
    collect,
    put_boxes,
)
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH, read_poses
from drake_geom_ros.geometry._proximity.world.pose_update import set_poses, update

# A world as passed to compiled loops over states (see ``pairs.slots``): the addresses of kernels,
# the rows (n,) of the frames that a state poses, the world's handle, the unfiltered pairs (k, 2),
# and their groups.
SceneArrays: TypeAlias = tuple[Addresses, Indices, Handle, Indices, GroupArrays]
# Scratch of loops: slots (k,), memory, see ``empty_memory``, and hits (k,).
ScratchArrays: TypeAlias = tuple[Indices, Floats, Indices]


@compiled
def pose_state(poses: Floats, rows: Indices, Xs: Floats, world: WorldArrays) -> bool:
    """Pose the frames of rows (n,) by poses (n, 7); return whether all poses are valid.

    The world is given by its handle; ``Xs`` (n, POSE_WIDTH) is scratch.
    """
    if read_poses(poses, Xs) < rows.size:
        return False
    if set_poses(rows, Xs, world):
        update(world, 1)
    return True


@inlined
def forget(memory: Floats, first: int, last: int) -> None:
    """Clear the last answers and hints of the slots from ``first`` up to ``last``."""
    for s in range(first, last):
        memory[s, SLACK], memory[s, SEEN] = -math.inf, -1.0
        for c in range(3):
            memory[s, NORMAL + c] = 0.0


@inlined
def _list(order: Indices, count: int, pairs: Indices, some: Indices, memory: Floats) -> None:
    """Write the pairs of the first ``count`` numbers of ``order``, and clear their slots."""
    for r in range(count):
        some[r, 0], some[r, 1] = pairs[order[r], 0], pairs[order[r], 1]
    forget(memory, 0, count)


@allocating
def any_overlap(
    scene: SceneArrays,
    scratch: ScratchArrays,
    poses: Floats,
    query: tuple[float, float, bool],
    stop: Indices,
    out: Booleans,
) -> int:
    """Decide for each state (N, n, 7) whether a pair overlaps; return the number of states done.

    ``out`` (N,) gets the answers of ``Engine.finds_overlap``; a state ends at its first overlap.
    """
    kernels, rows, world, pairs, groups = scene
    posed, groups = world_of(world), Groups(*groups)
    (slots, memory, hits), queue = scratch, no_queue()
    Xs = np.empty((rows.size, POSE_WIDTH))
    bounds, order = np.empty(slots.size), np.empty(slots.size, dtype=np.int64)
    counts, some = np.zeros(COUNTS, dtype=np.int64), np.empty_like(pairs)
    last = -1
    for s in range(poses.shape[0]):
        if stop[0] or not pose_state(poses[s], rows, Xs, world):
            return s
        put_boxes(groups, posed)
        everything = (0, groups.separations.size, -1)
        count = collect(groups, everything, 0.0, pairs, posed, order, bounds)
        for r in range(count):
            if order[r] == last:  # a pair in contact usually still is
                order[0], order[r] = last, order[0]
        _list(order, count, pairs, some, memory)
        out[s] = False
        if count > 0 and answer_pairs(
            kernels, some, slots[:count], memory, world, 1, query, (0, 0.0), queue, hits, counts
        ):
            out[s], last = True, order[hits[0]]
    return poses.shape[0]


@allocating
def pairs_within_cutoff(
    scene: SceneArrays,
    scratch: ScratchArrays,
    poses: Floats,
    first: int,
    query: tuple[float, float, bool],
    stop: Indices,
    offsets: Indices,
    answers: tuple[Indices, Floats],
) -> int:
    """Answer for all pairs of each state (N, n, 7) within the cutoff; return the states done.

    ``offsets`` (N + 1,) get the start of each state's ``answers`` in ids (most, 2) and rows
    (most, BATCH_WIDTH). The loop begins at the state ``first``. It ends when answers do not fit,
    ``stop`` (1,) is set, or a state has an invalid pose.
    """
    kernels, rows, world, pairs, groups = scene
    posed, groups = world_of(world), Groups(*groups)
    (slots, memory, hits), queue = scratch, no_queue()
    (level_gap, cutoff, _), (ids, out) = query, answers
    near_cutoff = max(cutoff, 0.0)
    Xs = np.empty((rows.size, POSE_WIDTH))
    bounds, order = np.empty(slots.size), np.empty(slots.size, dtype=np.int64)
    counts, some = np.zeros(COUNTS, dtype=np.int64), np.empty_like(pairs)
    some_ids, full = np.empty_like(pairs), np.empty((pairs.shape[0], BATCH_WIDTH))
    for s in range(first, poses.shape[0]):
        if stop[0] or not pose_state(poses[s], rows, Xs, world):
            return s
        put_boxes(groups, posed)
        everything = (0, groups.separations.size, -1)
        count = collect(groups, everything, near_cutoff, pairs, posed, order, bounds)
        order[:count].sort()
        _list(order, count, pairs, some, memory)
        count = answer_pairs(
            kernels, some, slots[:count], memory, world, 1, query, EVERY_HIT, queue, hits, counts
        )
        start = offsets[s]
        if start + count > ids.shape[0]:
            return s
        gather_rows(hits[:count], some, slots, memory, level_gap, world, some_ids, full)
        for k in range(count):
            ids[start + k, 0], ids[start + k, 1] = some_ids[k, 0], some_ids[k, 1]
            for c in range(BATCH_WIDTH):
                out[start + k, c] = full[k, c]
        offsets[s + 1] = start + count
    return poses.shape[0]


@allocating
def points_within_threshold(
    tables: TableArrays,
    scene: tuple[Indices, Handle],
    poses: Floats,
    first: int,
    query: tuple[Floats, float],
    stop: Indices,
    offsets: Indices,
    answers: tuple[Unsigned32, Indices, Floats],
) -> int:
    """Answer for points (m, 3) and all geometries in each state (N, n, 7), as ``point_phase``.

    ``tables`` are its ``PointTables``, ``scene`` are the rows of frames that are posed and the
    world, ``query`` are points and threshold [m]. Return the number of states done. The rest is as
    in ``pairs_within_cutoff``, with indices of points (most,), ids (most,) and rows
    (most, POINT_WIDTH).
    """
    (rows, world), (p_WQs, threshold), (points, ids, out) = scene, query, answers
    capacity = p_WQs.shape[0] * world_of(world).ids.size
    Xs = np.empty((rows.size, POSE_WIDTH))
    counts = np.zeros(COUNTS, dtype=np.int64)
    full, is_within = np.empty((capacity, POINT_WIDTH)), np.zeros(capacity, dtype=np.bool_)
    some_points, some_ids = np.empty(capacity, dtype=np.uint32), np.empty(capacity, dtype=np.int64)
    for s in range(first, poses.shape[0]):
        if stop[0] or not pose_state(poses[s], rows, Xs, world):
            return s
        is_within[:] = False
        some = (full, is_within, some_points, some_ids, counts)
        count = point_phase(tables, world, p_WQs, threshold, some)
        start = offsets[s]
        if start + count > ids.size:
            return s
        for k in range(count):
            points[start + k], ids[start + k] = some_points[k], some_ids[k]
            for c in range(POINT_WIDTH):
                out[start + k, c] = full[k, c]
        offsets[s + 1] = start + count
    return poses.shape[0]
