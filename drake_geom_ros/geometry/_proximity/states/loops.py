"""Many states of one world, in compiled loops: each is posed, and answered as if it were alone.

No answer of one state enters the next: every pair is computed without a hint, so what is returned
is, to the bit, what a query tells that has seen no other state, in whatever order the states come
and wherever their row is cut. What a state may leave behind costs no bit: frames that stand still
are not posed again, and a pair that overlapped is the first to be looked at in the next state.
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
from drake_geom_ros.geometry._proximity.pairs.slots import no_queue
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

# A world whose states are asked about, as compiled loops are handed it (see ``pairs.slots``): the
# addresses of kernels, the rows (n,) of the frames that a state poses, the world's handle, the
# pairs (k, 2) that may be reported, and their groups.
SceneArrays: TypeAlias = tuple[Addresses, Indices, Handle, Indices, GroupArrays]
# Room for what loops know of pairs: slots (k,), memory, see ``empty_memory``, and hits (k,).
RoomArrays: TypeAlias = tuple[Indices, Floats, Indices]


@compiled
def pose_state(poses: Floats, rows: Indices, Xs: Floats, world: WorldArrays) -> bool:
    """Pose the frames of rows (n,) by poses (n, 7); return whether all of these are poses.

    The world is given by its handle; ``Xs`` (n, POSE_WIDTH) is room.
    """
    if read_poses(poses, Xs) < rows.size:
        return False
    if set_poses(rows, Xs, world):
        update(world, 1)
    return True


@inlined
def forget(memory: Floats, first: int, last: int) -> None:
    """Forget what is known of some pairs, the hints too."""
    for s in range(first, last):
        memory[s, SLACK], memory[s, SEEN] = -math.inf, -1.0
        for c in range(3):
            memory[s, NORMAL + c] = 0.0


@inlined
def _list(order: Indices, count: int, pairs: Indices, some: Indices, memory: Floats) -> None:
    """List the pairs of some numbers, of which nothing is known."""
    for r in range(count):
        some[r, 0], some[r, 1] = pairs[order[r], 0], pairs[order[r], 1]
    forget(memory, 0, count)


@allocating
def any_overlap(
    scene: SceneArrays,
    room: RoomArrays,
    poses: Floats,
    query: tuple[float, float, bool],
    stop: Indices,
    out: Booleans,
) -> int:
    """Tell of each state (N, n, 7) whether a pair overlaps; return how many states are done.

    ``out`` (N,) gets the answers of ``Engine.finds_overlap``; each state ends at its first proof.
    """
    kernels, rows, world, pairs, groups = scene
    posed, groups = world_of(world), Groups(*groups)
    (slots, memory, hits), queue = room, no_queue()
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
def pairs_within_cutoff(
    scene: SceneArrays,
    room: RoomArrays,
    poses: Floats,
    first: int,
    query: tuple[float, float, bool],
    stop: Indices,
    offsets: Indices,
    answers: tuple[Indices, Floats],
) -> int:
    """Answer for all pairs of each state (N, n, 7) within the cutoff; return how many are done.

    ``offsets`` (N + 1,) get where each state's ``answers`` begin in ids (most, 2) and rows
    (most, BATCH_WIDTH). States are done from the ``first`` on, until there is no room, ``stop``
    (1,) is set, or one has a pose that is none.
    """
    kernels, rows, world, pairs, groups = scene
    posed, groups = world_of(world), Groups(*groups)
    (slots, memory, hits), queue = room, no_queue()
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
            kernels, some, slots[:count], memory, world, 1, query, -1, queue, hits, counts
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
    asked: tuple[Floats, float],
    stop: Indices,
    offsets: Indices,
    answers: tuple[Unsigned32, Indices, Floats],
) -> int:
    """Answer for points (m, 3) and all geometries, in each state (N, n, 7), as ``point_phase``.

    ``tables`` are its own, ``scene`` the rows of frames that are posed, and the world; ``asked``
    are points and threshold [m]. Returns how many states are done; the rest is as in
    ``pairs_within_cutoff``, with points (most,) for which point an answer is of, ids (most,) and
    rows (most, POINT_WIDTH).
    """
    (rows, world), (p_WQs, threshold), (points, ids, out) = scene, asked, answers
    room = p_WQs.shape[0] * world_of(world).ids.size
    Xs = np.empty((rows.size, POSE_WIDTH))
    counts = np.zeros(COUNTS, dtype=np.int64)
    full, there = np.empty((room, POINT_WIDTH)), np.zeros(room, dtype=np.bool_)
    some_points, some_ids = np.empty(room, dtype=np.uint32), np.empty(room, dtype=np.int64)
    for s in range(first, poses.shape[0]):
        if stop[0] or not pose_state(poses[s], rows, Xs, world):
            return s
        there[:] = False
        some = (full, there, some_points, some_ids, counts)
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
