"""A point query in one compiled call, as ``pair_query`` is one of pairs."""

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


class PointHands(NamedTuple):
    """The handles of all that a point query works on."""

    world: HandleField
    report: HandleField
    kernels: HandleField  # addresses by shape type
    pair_kernels: HandleField  # the addresses of the pair table
    pair_rows: Integers  # (n,) of points to each geometry in that table
    types: Integers  # these three of ``PointShapes``
    starts: Integers
    pool: Reals


_hands_of = taker(PointHands)


@compiled
def are_allowed(p_WQs: Floats) -> bool:
    """Tell whether points (m, 3) are finite and none of their coordinates beyond FARTHEST."""
    allowed = True
    for k in range(p_WQs.shape[0]):
        for c in range(3):
            allowed &= abs(p_WQs[k, c]) <= FARTHEST  # no NaN is
    return allowed


@compiled
def _run_points(
    hands: Handle,
    stale: bool,
    revision: int,
    X_PFs: Floats,
    p_WQs: Floats,
    threshold: float,
    answers: tuple[Floats, Booleans, Unsigned32, Indices],
) -> int:
    """Do what a point query does; return how many answers there are.

    ``hands`` is the handle of ``PointHands``. The world gets its poses as in ``pair_query``.
    The ``answers`` for points (m, 3) and n geometries are those of ``point_phase``, without
    counts; what found (m n,) comes in as does not matter.
    """
    rows, found, points, ids = answers
    hands = _hands_of(hands)
    report, capacity = report_of(hands.report), found.size
    pose_world(hands.world, report, stale, revision, X_PFs)
    told, moments, counts = report.told, report.moments, report.counts
    moments[LISTED] = moments[COMPILED] = moments[POSED]
    moments[FILTERING], counts[:] = 0.0, 0
    found[:] = False
    tables = (
        hands.kernels,
        hands.pair_kernels,
        hands.pair_rows,
        hands.types,
        hands.starts,
        hands.pool,
    )
    filled = (rows, found, points, ids, part(counts, BY_METHOD, counts.size))
    count = point_phase(tables, hands.world, p_WQs, threshold, filled)
    told[LIST_MADE], told[CONSIDERED], told[LISTED_PAIRS] = 0, capacity, capacity
    counts[FAR] = capacity - count
    moments[ANSWERED] = now()
    return count


def _there(world: World, found: PointBatch) -> PointBatch:
    """Return the answers about geometries that do not wait for a pose."""
    if world.is_whole:
        return found
    there = np.flatnonzero(~world.waiting[world.geometry_rows(found.ids)])
    return PointBatch(found.ids[there], found.points[there], found.rows[there])


class PointDistanceQueries:
    """Answers the point queries of one engine."""

    def __init__(self, report: ReportArrays) -> None:
        self._report = report
        self._world: World | None = None
        self._shapes: PointShapes | None = None

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, '_world': None}  # the handles of a copy are others

    def answer(self, world: World, p_WQs: Floats, threshold: float) -> PointBatch:
        """Return the signed distances of all geometries to points (m, 3) up to ``threshold``.

        The kernels are there, and the points ``are_allowed``.
        """
        if self._world is not world or self._shapes is not world.point_shapes:
            self._hand_over(world)
        if is_worth_sharing(self._seconds_a_point, len(p_WQs)):
            return self._answer_shared(world, p_WQs, threshold)
        count, found = self._run(world, p_WQs, threshold)
        there = found.ids[:count], found.points[:count], found.rows[:count]
        return _there(world, PointBatch(*there))

    def _run(self, world: World, p_WQs: Floats, threshold: float) -> tuple[int, PointBatch]:
        """Answer in one call; return how many answers there are, the first of what is returned."""
        capacity = len(p_WQs) * world.geometry_count
        rows = np.empty((capacity, POINT_WIDTH))
        points, ids = np.empty(capacity, dtype=np.uint32), np.empty(capacity, dtype=np.int64)
        stale = world.is_stale
        revision = world.revision + stale
        X_PFs, found = world.pending_poses, np.empty(capacity, dtype=np.bool_)
        answers = rows, found, points, ids
        count = _run_points(self._hands, stale, revision, X_PFs, p_WQs, threshold, answers)
        world.revision, world.pending_poses, world.is_stale = revision, NO_POSES, False
        return count, PointBatch(ids, points, rows)

    def _answer_shared(self, world: World, p_WQs: Floats, threshold: float) -> PointBatch:
        """Answer by threads, in a world that is posed first."""
        self._run(world, p_WQs[:0], threshold)
        found, by_method = shared_point_distances(world, p_WQs, threshold)
        report, capacity = self._report, len(p_WQs) * world.geometry_count
        report.told[[CONSIDERED, LISTED_PAIRS]] = capacity
        report.counts[BY_METHOD:] = by_method[: report.counts.size - BY_METHOD]
        report.counts[FAR] = capacity - len(found.ids)
        report.moments[ANSWERED] = time.perf_counter()
        return _there(world, found)

    def _hand_over(self, world: World) -> None:
        """Take another world."""
        self._shapes = shapes = world.point_shapes
        self._seconds_a_point = seconds_a_point(shapes)  # a third of what 100 points take
        types, starts, pool = shapes.types, shapes.starts, shapes.pool
        pair_rows = POINT_ROWS[types]
        # By the handle of handles.
        self._kept = handle_of(self._report), world.handle, pair_rows, types, starts, pool
        hands = PointHands(
            world=world.handle,
            report=self._kept[0],
            kernels=POINT_ADDRESSES,
            pair_kernels=ADDRESSES,
            pair_rows=pair_rows,
            types=types,
            starts=starts,
            pool=pool,
        )
        self._world, self._hands = world, handle_of(hands)
