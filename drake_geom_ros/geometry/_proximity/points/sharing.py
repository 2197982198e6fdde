"""Large point queries, shared out to threads: each point is answered independently."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.kernels.pair_table import BY_PAIR_KERNEL, POINT_KERNELS
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.pairs.answer_rows import PointBatch
from drake_geom_ros.geometry._proximity.points.point_phase import point_phase, point_tables
from drake_geom_ros.geometry._proximity.report import COUNTS
from drake_geom_ros.geometry._proximity.runtime.threads import LONG, THREADS, share
from drake_geom_ros.geometry._proximity.tolerances import LONG_POINT, SHORT_POINT
from drake_geom_ros.geometry._proximity.world.world import PointShapes, World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def seconds_a_point(shapes: PointShapes) -> float:
    """Return an estimate of the time [s] that one point takes against all geometries."""
    slow = [k for k, name in POINT_KERNELS.items() if name == BY_PAIR_KERNEL or k >= SOLID]
    long_ones = int(np.isin(shapes.types, slow).sum())
    return long_ones * LONG_POINT + (len(shapes.types) - long_ones) * SHORT_POINT


def is_worth_sharing(each: float, count: int) -> bool:
    """Return whether ``count`` points at ``each`` [s] take long enough for threads to help."""
    return THREADS > 1 and count * each > LONG


def shared_point_distances(
    world: World, p_WQs: Floats, threshold: float
) -> tuple[PointBatch, Indices]:
    """Return the answers and counts of ``point_phase`` for an up-to-date world, by threads."""
    n = world.geometry_count
    capacity = len(p_WQs) * n
    rows = np.empty((capacity, POINT_WIDTH))
    points, ids = np.empty(capacity, dtype=np.uint32), np.empty(capacity, dtype=np.int64)
    tables = point_tables(world.point_shapes)

    def answer(first: int, last: int) -> tuple[int, int, Indices]:
        part, counts = slice(first * n, last * n), np.zeros(COUNTS, dtype=np.int64)
        is_within = np.zeros((last - first) * n, dtype=np.bool_)
        answers = rows[part], is_within, points[part], ids[part], counts
        count = point_phase(tables, world.handle, p_WQs[first:last], threshold, answers)
        points[first * n : first * n + count] += np.uint32(first)
        return first * n, count, counts

    parts = share(len(p_WQs), answer)
    total: Indices = np.sum([counts for _, _, counts in parts], axis=0)
    if sum(count for _, count, _ in parts) < capacity:
        there = np.concatenate([np.arange(first, first + count) for first, count, _ in parts])
        rows, points, ids = rows[there], points[there], ids[there]
    return PointBatch(ids, points, rows), total
