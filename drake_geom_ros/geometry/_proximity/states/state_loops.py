"""``StateLoops``: the pairs and scratch arrays of a world, and calls of ``loops`` about them."""

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

_FIRST_ANSWERS = 4  # initial capacity per state


class StateLoops:
    """Answers about states of a world of its own, for one thread.

    A state is a pose (7,) in its parent for each frame of ``rows`` (n,); all others stay. Each
    method returns the number of states answered. These are all states unless ``stop`` (1,) was set
    or the next state has an invalid pose.
    """

    def __init__(self, world: World, pairs: Indices, rows: Indices) -> None:
        world.update()
        self._world, self._pairs, self._rows = world, pairs, rows
        arrays: GroupArrays = groups_of(moved_together(world, rows), pairs)[:]
        self._scene = ADDRESSES, rows, world.handle, pairs, arrays
        hits = np.zeros(len(pairs), dtype=np.int64)
        self._scratch = np.arange(len(pairs)), empty_memory(len(pairs)), hits

    def _compile(self, level_gap: float) -> None:
        """Compile the kernels of the pairs, unless bounds alone answer."""
        if level_gap < np.inf:
            compile_rows(table_rows(*self._world.geometries.types[self._pairs].T))

    def overlaps(
        self, poses: Floats, level_gap: float, stop: Indices
    ) -> tuple[int, NDArray[np.bool_]]:
        """Return which states (N,) have a pair that overlaps, at a level gap [m]."""
        self._compile(level_gap)
        out = np.zeros(len(poses), dtype=np.bool_)
        query = level_gap, 0.0, True
        done = any_overlap(self._scene, self._scratch, poses, query, stop, out)
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
        """Return the number of pairs (N,) that may be within a cutoff [m], and the nearest.

        At most ``most`` pairs of each state, in the order of their lower bounds, state by state.
        """
        self._compile(level_gap)
        found_counts = np.zeros(len(poses), dtype=np.int64)
        ids = np.zeros((len(poses), most, 2), dtype=np.int64)
        out = np.zeros((len(poses), most, BATCH_WIDTH))
        query = level_gap, cutoff, False
        done = nearest_pairs(self._scene, poses, query, stop, (found_counts, ids, out))
        is_used = np.arange(most) < found_counts[:, None]
        return done, found_counts, PairBatch(ids[is_used], out[is_used])

    def within(
        self, poses: Floats, level_gap: float, cutoff: float, stop: Indices
    ) -> tuple[int, Indices, PairBatch]:
        """Return the number of pairs (N,) within the cutoff [m], and the pairs sorted by id."""
        self._compile(level_gap)

        def answer(first: int, offsets: Indices, buffers: list[Any]) -> int:
            ids, rows = buffers
            query = level_gap, cutoff, False
            return pairs_within_cutoff(
                self._scene, self._scratch, poses, first, query, stop, offsets, (ids, rows)
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
        """Return the number of answers (N,) within a threshold [m] of points (m, 3), and these.

        They are sorted by (point, id). A single state may be ``shared`` between all threads.
        """
        table = self._world.geometries
        shapes = self._world.point_shapes
        compile_point_kernels(shapes.kinds)
        tables = point_tables(shapes)
        if shared and len(poses) == 1 and is_worth_sharing(seconds_a_point(shapes), len(p_WQs)):
            return self._points_of_one(poses[0], p_WQs, threshold, stop)

        def answer(first: int, offsets: Indices, buffers: list[Any]) -> int:
            points, ids, rows = buffers
            world, query = (self._rows, self._world.handle), (p_WQs, threshold)
            return points_within_threshold(
                tables, world, poses, first, query, stop, offsets, (points, ids, rows)
            )

        columns = [((), np.uint32), ((), np.int64), ((POINT_WIDTH,), np.float64)]
        most = len(p_WQs) * len(table.ids)
        done, counts, (points, ids, rows) = _filled(answer, len(poses), most, columns, stop)
        return done, counts, PointBatch(ids, points, rows)

    def _points_of_one(
        self, poses: Floats, p_WQs: Floats, threshold: float, stop: Indices
    ) -> tuple[int, Indices, PointBatch]:
        """Return the result of ``points`` for one state (n, 7), computed by threads."""
        nothing = PointBatch(
            np.zeros(0, np.int64), np.zeros(0, np.uint32), np.zeros((0, POINT_WIDTH))
        )
        Xs = np.empty((len(self._rows), POSE_WIDTH))
        if stop[0] or not pose_state(poses, self._rows, Xs, self._world.handle):
            return 0, np.zeros(1, dtype=np.int64), nothing
        batch, _ = shared_point_distances(self._world, p_WQs, threshold)
        return 1, np.array([len(batch.ids)]), batch


def _filled(
    answer: Any, states: int, most: int, columns: list[Any], stop: Indices
) -> tuple[int, Indices, list[Any]]:
    """Return states done, counts (N,) and arrays filled by ``answer``, grown as needed.

    ``most`` is the largest number of answers of a state, ``columns`` are shapes and types.
    """
    offsets = np.zeros(states + 1, dtype=np.int64)
    # One state always fits, because to answer it twice costs more than memory that is not touched.
    size, done = most if states == 1 else states * min(most, _FIRST_ANSWERS), 0
    buffers = [np.empty((size, *shape), dtype=dtype) for shape, dtype in columns]
    while True:
        done = answer(done, offsets, buffers)
        start = int(offsets[done])
        if done == states or stop[0] or len(buffers[0]) - start >= most:
            break
        # For as many answers as states had so far, and at least for the state that did not fit.
        more = most + start // max(done, 1) * (states - done)
        buffers = [
            np.concatenate((each[:start], np.empty((more, *each.shape[1:]), dtype=each.dtype)))
            for each in buffers
        ]
    return done, np.diff(offsets), [each[:start] for each in buffers]
