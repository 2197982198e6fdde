"""The compiled loops over states with what they need: a world, its pairs, and room."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.addresses import (
    ADDRESSES,
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.pairs.answer_rows import BATCH_WIDTH, PairBatch, PointBatch
from drake_geom_ros.geometry._proximity.pairs.slots import empty_memory
from drake_geom_ros.geometry._proximity.points.point_phase import (
    compile_point_kernels,
    point_tables,
)
from drake_geom_ros.geometry._proximity.points.sharing import (
    is_worth_sharing,
    seconds_a_point,
    shared_point_distances,
)
from drake_geom_ros.geometry._proximity.states.certified import any_near, nearest_pairs
from drake_geom_ros.geometry._proximity.states.groups import (
    GroupArrays,
    groups_of,
    moved_together,
)
from drake_geom_ros.geometry._proximity.states.loops import (
    any_overlap,
    pairs_within_cutoff,
    points_within_threshold,
    pose_state,
)
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH
from drake_geom_ros.geometry._proximity.world.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_FIRST_ROOM = 4  # answers a state that there is room for at first


class StateLoops:
    """Answers about states of a world of its own, for one thread.

    A state is a pose (7,) in its parent of each frame of ``rows`` (n,); all others stay. Each
    method returns how many states it has answered, which are all of them unless ``stop`` (1,) was
    set meanwhile or the next one has a pose that is none.
    """

    def __init__(self, world: World, pairs: Indices, rows: Indices) -> None:
        world.update()
        self._world, self._pairs, self._rows = world, pairs, rows
        arrays: GroupArrays = groups_of(moved_together(world, rows), pairs)[:]
        self._scene = ADDRESSES, rows, world.handle, pairs, arrays
        hits = np.zeros(len(pairs), dtype=np.int64)
        self._room = np.arange(len(pairs)), empty_memory(len(pairs)), hits

    def _compile(self, level_gap: float) -> None:
        """Compile the kernels of the pairs; bounds need none."""
        if level_gap < np.inf:
            compile_rows(table_rows(*self._world.geometries.types[self._pairs].T))

    def overlaps(
        self, poses: Floats, level_gap: float, stop: Indices
    ) -> tuple[int, NDArray[np.bool_]]:
        """Return which states (N,) have a pair that overlaps, at a level gap [m]."""
        self._compile(level_gap)
        out = np.zeros(len(poses), dtype=np.bool_)
        query = level_gap, 0.0, True
        done = any_overlap(self._scene, self._room, poses, query, stop, out)
        return done, out

    def near(
        self, poses: Floats, level_gap: float, cutoff: float, stop: Indices
    ) -> tuple[int, NDArray[np.bool_]]:
        """Return which states (N,) have a pair that is not certified to be beyond a cutoff [m]."""
        self._compile(level_gap)
        out = np.zeros(len(poses), dtype=np.bool_)
        done = any_near(self._scene, poses, (level_gap, cutoff, False), stop, out)
        return done, out

    def nearest(
        self, poses: Floats, level_gap: float, cutoff: float, most: int, stop: Indices
    ) -> tuple[int, Indices, PairBatch]:
        """Return how many pairs (N,) may be within the cutoff [m], at most some, and the nearest.

        Those of each state in the order of their lower bounds, one state after the other.
        """
        self._compile(level_gap)
        found = np.zeros(len(poses), dtype=np.int64)
        ids = np.zeros((len(poses), most, 2), dtype=np.int64)
        out = np.zeros((len(poses), most, BATCH_WIDTH))
        query = level_gap, cutoff, False
        done = nearest_pairs(self._scene, poses, query, stop, (found, ids, out))
        there = np.arange(most) < found[:, None]
        return done, found, PairBatch(ids[there], out[there])

    def within(
        self, poses: Floats, level_gap: float, cutoff: float, stop: Indices
    ) -> tuple[int, Indices, PairBatch]:
        """Return how many pairs (N,) are within the cutoff [m], and these, by their ids."""
        self._compile(level_gap)

        def answer(first: int, offsets: Indices, room: list[Any]) -> int:
            ids, rows = room
            asked = level_gap, cutoff, False
            return pairs_within_cutoff(
                self._scene, self._room, poses, first, asked, stop, offsets, (ids, rows)
            )

        columns = [((2,), np.int64), ((BATCH_WIDTH,), np.float64)]
        done, counts, (ids, rows) = _filled(answer, len(poses), len(self._pairs), columns, stop)
        return done, counts, PairBatch(ids, rows)

    def points(
        self,
        poses: Floats,
        p_WQs: Floats,
        threshold: float,
        stop: Indices,
        *,
        shared: bool = False,
    ) -> tuple[int, Indices, PointBatch]:
        """Return how many geometries (N,) are within a threshold [m] of points (m, 3), and which.

        Sorted by (point, id). A single state may be ``shared`` out to all threads.
        """
        table = self._world.geometries
        shapes = self._world.point_shapes
        compile_point_kernels(shapes.kinds)
        tables = point_tables(shapes)
        if shared and len(poses) == 1 and is_worth_sharing(seconds_a_point(shapes), len(p_WQs)):
            return self._points_of_one(poses[0], p_WQs, threshold, stop)

        def answer(first: int, offsets: Indices, room: list[Any]) -> int:
            points, ids, rows = room
            world, asked = (self._rows, self._world.handle), (p_WQs, threshold)
            return points_within_threshold(
                tables, world, poses, first, asked, stop, offsets, (points, ids, rows)
            )

        columns = [((), np.uint32), ((), np.int64), ((POINT_WIDTH,), np.float64)]
        most = len(p_WQs) * len(table.ids)
        done, counts, (points, ids, rows) = _filled(answer, len(poses), most, columns, stop)
        return done, counts, PointBatch(ids, points, rows)

    def _points_of_one(
        self, poses: Floats, p_WQs: Floats, threshold: float, stop: Indices
    ) -> tuple[int, Indices, PointBatch]:
        """Return what ``points`` does of one state (n, 7), by threads."""
        nothing = PointBatch(
            np.zeros(0, np.int64), np.zeros(0, np.uint32), np.zeros((0, POINT_WIDTH))
        )
        Xs = np.empty((len(self._rows), POSE_WIDTH))
        if stop[0] or not pose_state(poses, self._rows, Xs, self._world.handle):
            return 0, np.zeros(1, dtype=np.int64), nothing
        found, _ = shared_point_distances(self._world, p_WQs, threshold)
        return 1, np.array([len(found.ids)]), found


def _filled(
    answer: Any, states: int, most: int, columns: list[Any], stop: Indices
) -> tuple[int, Indices, list[Any]]:
    """Return states done, counts (N,) and arrays that ``answer`` fills, with room as it needs.

    ``most`` is the number of answers that a state may have, ``columns`` shapes and types.
    """
    offsets = np.zeros(states + 1, dtype=np.int64)
    size, done = states * min(most, _FIRST_ROOM), 0
    room = [np.empty((size, *shape), dtype=dtype) for shape, dtype in columns]
    while True:
        done = answer(done, offsets, room)
        start = int(offsets[done])
        if done == states or stop[0] or len(room[0]) - start >= most:
            break
        # By what states had until now, and at least the one that had too little.
        more = most + start // max(done, 1) * (states - done)
        room = [
            np.concatenate((each[:start], np.empty((more, *each.shape[1:]), dtype=each.dtype)))
            for each in room
        ]
    return done, np.diff(offsets), [each[:start] for each in room]
