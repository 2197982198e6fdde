"""One compiled call for a point query, as ``pair_query`` has for pairs."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.addresses import ADDRESSES
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.pairs.answer_rows import PointBatch
from drake_geom_ros.geometry._proximity.points.point_phase import (
    POINT_ADDRESSES,
    POINT_ROWS,
    point_phase,
)
from drake_geom_ros.geometry._proximity.points.sharing import (
    is_worth_sharing,
    seconds_a_point,
    shared_point_distances,
)
from drake_geom_ros.geometry._proximity.report import (
    ANSWERED,
    BY_METHOD,
    COMPILED,
    CONSIDERED,
    FAR,
    FILTERING,
    LIST_MADE,
    LISTED,
    LISTED_PAIRS,
    POSED,
    ReportArrays,
    pose_world,
    report_of,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Indices, Unsigned32
from drake_geom_ros.geometry._proximity.runtime.clock import now
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Handle,
    HandleField,
    Integers,
    Reals,
    handle_of,
    taker,
)
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.world.world import NO_POSES, PointShapes, World
from drake_geom_ros.math.tolerances import FARTHEST

Floats = NDArray[np.float64]


class PointQueryHandles(NamedTuple):
    """The handles of all arrays that a point query works on."""

    world: HandleField
    report: HandleField
    kernels: HandleField  # addresses by shape type
    pair_kernels: HandleField  # the addresses of the pair table
    pair_rows: Integers  # (n,) of points to each geometry in that table
    types: Integers  # this and the next two: see ``PointShapes``
    starts: Integers
    pool: Reals


_handles_of = taker(PointQueryHandles)


@compiled
def are_allowed(p_WQs: Floats) -> bool:
    """Return whether points (m, 3) are finite and no coordinate is beyond FARTHEST [m]."""
    allowed = True
    for k in range(p_WQs.shape[0]):
        for c in range(3):
            allowed &= abs(p_WQs[k, c]) <= FARTHEST  # False for NaN
    return allowed


@compiled
def _run_points(
    handles: Handle,
    stale: bool,
    revision: int,
    X_PFs: Floats,
    p_WQs: Floats,
    threshold: float,
    answers: tuple[Floats, Booleans, Unsigned32, Indices],
) -> int:
    """Run a whole point query; return the number of answers.

    ``handles`` is the handle of ``PointQueryHandles``. The world is posed as in ``pair_query``.
    The ``answers`` for points (m, 3) and n geometries are those of ``point_phase`` without counts;
    the flags are cleared here.
    """
    rows, is_within, points, ids = answers
    handles = _handles_of(handles)
    report, capacity = report_of(handles.report), is_within.size
    pose_world(handles.world, report, stale, revision, X_PFs)
    summary, moments, counts = report.summary, report.moments, report.counts
    moments[LISTED] = moments[COMPILED] = moments[POSED]
    moments[FILTERING], counts[:] = 0.0, 0
    is_within[:] = False
    tables = (
        handles.kernels,
        handles.pair_kernels,
        handles.pair_rows,
        handles.types,
        handles.starts,
        handles.pool,
    )
    filled = (rows, is_within, points, ids, part(counts, BY_METHOD, counts.size))
    count = point_phase(tables, handles.world, p_WQs, threshold, filled)
    summary[LIST_MADE], summary[CONSIDERED], summary[LISTED_PAIRS] = 0, capacity, capacity
    counts[FAR] = capacity - count
    moments[ANSWERED] = now()
    return count


def _without_waiting(world: World, batch: PointBatch) -> PointBatch:
    """Return the answers about geometries that do not wait for a first pose."""
    if world.is_whole:
        return batch
    posed = np.flatnonzero(~world.waiting[world.geometry_rows(batch.ids)])
    return PointBatch(batch.ids[posed], batch.points[posed], batch.rows[posed])


class PointDistanceQueries:
    """Point queries of one engine."""

    def __init__(self, report: ReportArrays) -> None:
        self._report = report
        self._world: World | None = None
        self._shapes: PointShapes | None = None

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, '_world': None}  # a copy needs handles of its own

    def answer(self, world: World, p_WQs: Floats, threshold: float) -> PointBatch:
        """Return the signed distances of all geometries to points (m, 3) up to ``threshold``.

        The kernels must be compiled, and the points must satisfy ``are_allowed``.
        """
        if self._world is not world or self._shapes is not world.point_shapes:
            self._prepare(world)
        if is_worth_sharing(self._seconds_a_point, len(p_WQs)):
            return self._answer_shared(world, p_WQs, threshold)
        count, buffer = self._run(world, p_WQs, threshold)
        answers = buffer.ids[:count], buffer.points[:count], buffer.rows[:count]
        return _without_waiting(world, PointBatch(*answers))

    def _run(self, world: World, p_WQs: Floats, threshold: float) -> tuple[int, PointBatch]:
        """Answer in one call; return the number of answers, and a batch that begins with them."""
        capacity = len(p_WQs) * world.geometry_count
        rows = np.empty((capacity, POINT_WIDTH))
        points, ids = np.empty(capacity, dtype=np.uint32), np.empty(capacity, dtype=np.int64)
        stale = world.is_stale
        revision = world.revision + stale
        X_PFs, is_within = world.pending_poses, np.empty(capacity, dtype=np.bool_)
        answers = rows, is_within, points, ids
        count = _run_points(self._handle, stale, revision, X_PFs, p_WQs, threshold, answers)
        world.revision, world.pending_poses, world.is_stale = revision, NO_POSES, False
        return count, PointBatch(ids, points, rows)

    def _answer_shared(self, world: World, p_WQs: Floats, threshold: float) -> PointBatch:
        """Answer by threads, after posing the world."""
        self._run(world, p_WQs[:0], threshold)
        batch, by_method = shared_point_distances(world, p_WQs, threshold)
        report, capacity = self._report, len(p_WQs) * world.geometry_count
        report.summary[[CONSIDERED, LISTED_PAIRS]] = capacity
        report.counts[BY_METHOD:] = by_method[: report.counts.size - BY_METHOD]
        report.counts[FAR] = capacity - len(batch.ids)
        report.moments[ANSWERED] = time.perf_counter()
        return _without_waiting(world, batch)

    def _prepare(self, world: World) -> None:
        """Make the handles for another world or other point shapes."""
        self._shapes = shapes = world.point_shapes
        self._seconds_a_point = seconds_a_point(shapes)  # costs a third of a query of 100 points
        types, starts, pool = shapes.types, shapes.starts, shapes.pool
        pair_rows = POINT_ROWS[types]
        # Kept alive as long as the handle of handles.
        self._kept = handle_of(self._report), world.handle, pair_rows, types, starts, pool
        handles = PointQueryHandles(
            world=world.handle,
            report=self._kept[0],
            kernels=POINT_ADDRESSES,
            pair_kernels=ADDRESSES,
            pair_rows=pair_rows,
            types=types,
            starts=starts,
            pool=pool,
        )
        self._world, self._handle = world, handle_of(handles)
