"""Large point queries, shared out to threads: each point is answered independently."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.kernels.pair_table import BY_PAIR_KERNEL, POINT_KERNELS
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.pairs.answer_rows import PointBatch
from drake_geom_ros.geometry._proximity.points.point_phase import point_phase, point_tables
from drake_geom_ros.geometry._proximity.report import COUNTS
from drake_geom_ros.geometry._proximity.runtime.threads import LONG, share
from drake_geom_ros.geometry._proximity.tolerances import LONG_POINT, SHORT_POINT
from drake_geom_ros.geometry._proximity.world.world import PointShapes, World

ROWS_A_BLOCK = 1 << 17  # some 20 MB: answers of 4096 points to 32 geometries
Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def seconds_a_point(shapes: PointShapes) -> float:
    """Return an estimate of the time [s] that one point takes against all geometries."""
    slow = [k for k, name in POINT_KERNELS.items() if name == BY_PAIR_KERNEL or k >= SOLID]
    long_ones = int(np.isin(shapes.types, slow).sum())
    return long_ones * LONG_POINT + (len(shapes.types) - long_ones) * SHORT_POINT


def is_worth_sharing(each: float, count: int) -> bool:
    """Return whether ``count`` points at ``each`` [s] take long: then threads and blocks help."""
    return count * each > LONG


def shared_point_distances(
    world: World, p_WQs: Floats, threshold: float
) -> tuple[PointBatch, Indices]:
    """Return the answers and counts of ``point_phase`` for an up-to-date world, by threads.

    With a threshold most pairs are left out, so each thread works in blocks and keeps the answers
    alone: 10^6 points near two arms take 121 MB, where all their pairs would take 9 GB.
    """
    n = world.geometry_count
    tables = point_tables(world.point_shapes)
    in_blocks = bool(n) and np.isfinite(threshold)
    step = max(1, ROWS_A_BLOCK // n if in_blocks else len(p_WQs))
    whole = _room(0 if in_blocks else len(p_WQs) * n)

    def answer(first: int, last: int) -> tuple[list[PointBatch], Indices]:
        batches, counts = list[PointBatch](), np.zeros(COUNTS, dtype=np.int64)
        room = (
            _room(min(step, last - first) * n) if in_blocks else _part(whole, first * n, last * n)
        )
        for begin in range(first, last, step):
            end = min(begin + step, last)
            is_within = np.zeros((end - begin) * n, dtype=np.bool_)
            answers = room.rows, is_within, room.points, room.ids, counts
            count = point_phase(tables, world.handle, p_WQs[begin:end], threshold, answers)
            some = _part(room, 0, count)
            some.points[:] += np.uint32(begin)
            batches.append(_joined([some]) if in_blocks else some)
        return batches, counts

    shares = share(len(p_WQs), answer)
    total: Indices = np.sum([counts for _, counts in shares], axis=0)
    parts = [part for batches, _ in shares for part in batches]
    if not in_blocks and sum(len(part.ids) for part in parts) == len(whole.ids):
        return whole, total  # all are in place
    return _joined(parts), total


def _room(capacity: int) -> PointBatch:
    """Return room for so many answers."""
    ids, points = np.empty(capacity, dtype=np.int64), np.empty(capacity, dtype=np.uint32)
    return PointBatch(ids, points, np.empty((capacity, POINT_WIDTH)))


def _part(batch: PointBatch, first: int, last: int) -> PointBatch:
    """Return the answers from ``first`` to ``last``, not copied."""
    some = slice(first, last)
    return PointBatch(batch.ids[some], batch.points[some], batch.rows[some])


def _joined(parts: Sequence[PointBatch]) -> PointBatch:
    """Return the answers of several batches, copied."""
    return PointBatch(
        np.concatenate([part.ids for part in parts]),
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.rows for part in parts]),
    )
