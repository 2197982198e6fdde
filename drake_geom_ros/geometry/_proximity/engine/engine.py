"""Query engine: broad phase, cached answers, narrow-phase kernels, and arrays of answers."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.effects import Effects, seconds_by_step
from drake_geom_ros.geometry._proximity.engine.pair_query import (
    LACKS_KERNELS,
    LIST,
    run_cycle,
)
from drake_geom_ros.geometry._proximity.engine.prepared import MANY, Prepared, PreparedQueries
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.addresses import (
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import LEVEL_GAP, NORMAL
from drake_geom_ros.geometry._proximity.kinds import Method
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.pairs.answer_rows import (
    ANSWER_WIDTH,
    PairBatch,
    PointBatch,
    batch_of,
    gather_answers,
    gathered,
)
from drake_geom_ros.geometry._proximity.pairs.budgeted import BudgetedAnswers
from drake_geom_ros.geometry._proximity.pairs.slots import empty_memory
from drake_geom_ros.geometry._proximity.points.point_phase import (
    POINTS_COMPILED,
    compile_point_kernels,
)
from drake_geom_ros.geometry._proximity.points.point_query import PointDistanceQueries
from drake_geom_ros.geometry._proximity.report import (
    ANSWERED,
    BEGUN,
    BODIES_MOVED,
    BY_METHOD,
    CACHED,
    COMPILED,
    CONSIDERED,
    FAR,
    FILTERING,
    FRAMES_MOVED,
    KNOWING,
    LIST_MADE,
    LISTED,
    LISTED_PAIRS,
    POSED,
    WIDE,
    empty_report,
)
from drake_geom_ros.geometry._proximity.runtime.compiled import Tell
from drake_geom_ros.geometry._proximity.runtime.threads import LONG, THREADS, share
from drake_geom_ros.geometry._proximity.tolerances import GAPS_OF_LEVELS
from drake_geom_ros.geometry._proximity.world.row_change import RowChange
from drake_geom_ros.geometry._proximity.world.world import NO_POSES, World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

ACCURACY_LEVELS = tuple(GAPS_OF_LEVELS)
# How a pair was answered: name and number, as in the messages.
METHODS = {method.name.lower(): method.value for method in Method}
_NO_ANSWERS = np.zeros((0, ANSWER_WIDTH))
_NO_KERNELS = ()
_empty = np.empty


class Engine:
    """Answers queries on a world under its filters, and reports the work that this took.

    An engine belongs to one context: its cached answers hold for the world that it saw last.
    """

    def __init__(self) -> None:
        self.detailed = False  # measure cache and kernels separately, which takes a little longer
        # The last query and its answers.
        self._last: Prepared | None = None
        self._answers = _NO_ANSWERS
        # The work of the last query; converted to ``Effects`` only on request.
        self._report = empty_report()
        self._queries = PreparedQueries(self._report)
        self._steps = BudgetedAnswers(self._report)
        self._points = PointDistanceQueries(self._report)
        self._unrefined = 0
        self._kernels: Sequence[str] = _NO_KERNELS

    @property
    def _counts(self) -> Indices:
        return self._report.counts

    @property
    def _moments(self) -> Floats:
        return self._report.moments

    @property
    def effects(self) -> Effects:
        """The work that the last query did and skipped."""
        counts, summary = self._counts.tolist(), self._report.summary.tolist()
        return Effects(
            frames_moved=summary[FRAMES_MOVED],
            geometries_updated=summary[BODIES_MOVED],
            broadphase_pairs=summary[CONSIDERED],
            filtered_pairs=summary[CONSIDERED] - summary[LISTED_PAIRS],
            far_pairs=counts[FAR],
            cached_pairs=counts[CACHED],
            narrowphase_pairs=sum(counts[BY_METHOD:]),
            wide_pairs=counts[WIDE],
            unrefined_pairs=self._unrefined,
            pairs_by_method={
                name: counts[BY_METHOD + number]
                for name, number in METHODS.items()
                if counts[BY_METHOD + number]
            },
            near_list_made=bool(summary[LIST_MADE]),
            kernels_compiled=list(self._kernels),
            seconds=seconds_by_step(*self._moments.tolist()),
        )

    def prepare(self, world: World, tell: Tell | None = None) -> list[str]:
        """Compile the kernels of all shape pairs that the world can have; return their names."""
        types = world.geometries.types
        moving = np.unique(types[~world.anchored])
        return compile_rows(table_rows(moving[:, None], np.unique(types)[None, :]), tell)

    def prepared(
        self,
        world: World,
        filters: FilterState,
        level_gap: float,
        cutoff: float,
        penetrating: bool,
        mode: int,
    ) -> Prepared:
        """Return a reusable query of a world under filters; ``mode`` is one of ``pair_query``."""
        return self._queries.prepared(world, filters, level_gap, cutoff, penetrating, mode)

    def follow(self, former: World, world: World, change: RowChange) -> None:
        """Keep what is remembered of a former world for one with changed rows."""
        self._queries.follow(former, world, change)
        self._last, self._answers = None, _NO_ANSWERS

    def candidates_of(self, prepared: Prepared) -> Indices:
        """Return the unfiltered pairs (k, 2) that bounding volumes do not separate."""
        count = self._run(prepared)
        near = prepared.near
        pairs: Indices = near.arrays.pairs[near.arrays.hits[:count]]
        self._counts[FAR] = near.count - count
        return pairs

    def answer_of(self, prepared: Prepared, time_budget: float = 0.0) -> Floats:
        """Return the unfiltered pairs within a query's cutoff as rows (k, ANSWER_WIDTH).

        A query of ``penetrating`` pairs returns only those that overlap. Pairs that are answered
        from bounds alone, because of the level or because the narrow phase has spent its
        ``time_budget`` [s] (0: no limit), are returned if they may qualify.

        The common path is inlined: in the first cycle after other work, the usual case on a robot,
        every call is a cache miss.
        """
        world = prepared.world
        if prepared.cutoff == -math.inf:
            return self._answer_of_none(world)
        stale, revision = world.is_stale, world.revision
        if not stale and self._last is prepared and prepared.answered_at == revision:
            return self._as_before(prepared.near)
        self._last, self._answers = None, _NO_ANSWERS
        if time_budget > 0.0 or self.detailed or (prepared.seconds > LONG and THREADS > 1):
            answers = self._answer_unusually(prepared, time_budget)
        else:
            self._kernels, self._unrefined = prepared.loaded, 0
            prepared.loaded = _NO_KERNELS
            if stale:
                revision += 1
            X_PFs = world.pending_poses
            answers = _empty((prepared.room, ANSWER_WIDTH))
            count: int = run_cycle(prepared.cycle_handle, 0, stale, revision, X_PFs, answers)
            world.revision, world.pending_poses, world.is_stale = revision, NO_POSES, False
            if count < 0:
                count = self._go_on(prepared, count, stale, X_PFs, answers)
            if prepared.fewest <= count <= prepared.most:
                answers.setflags(False)  # type: ignore[call-arg]
                answers = answers[:count]
            else:
                answers = self._answer_of_other_length(prepared, count, answers)
        # Pairs left at their bounds are refined when the query is repeated.
        if not (self._unrefined or prepared.is_long):
            self._last, self._answers, prepared.answered_at = prepared, answers, world.revision
        elif prepared.is_long:
            self._queries.forget_list(prepared.cutoff)
        return answers

    def finds_overlap(self, prepared: Prepared) -> bool:
        """Return whether the answer of a query would contain a pair that overlaps.

        A pair that may overlap counts where rounding hides more than UNSEEN_DEPTH.
        """
        return self._run(prepared) > 0

    def distance_of_pair(
        self, world: World, pair: Indices, level_gap: float, hint: Floats | None = None
    ) -> PairBatch:
        """Return the signed distance of one pair (1, 2), regardless of the filters.

        ``hint`` (3,) is the normal that an iteration starts from. Two half spaces have no
        distance: the batch is empty then.
        """
        self._begin(world)
        (row,) = rows = table_rows(*world.geometries.types[pair].T)
        slots, memory = np.zeros(1, dtype=np.int64), empty_memory(1)
        if hint is not None:
            # Marked with this level, because kernels ignore the hint of another one.
            memory[0, NORMAL : NORMAL + 3], memory[0, LEVEL_GAP] = hint, level_gap
        if row < 0:
            return batch_of(gathered(world, slots[:0], pair, slots, memory, math.inf))
        self._kernels = compile_rows(rows)
        self._report.summary[CONSIDERED] = self._report.summary[LISTED_PAIRS] = 1
        self._moments[LISTED] = self._moments[COMPILED] = time.perf_counter()
        hits = np.empty(1, dtype=np.int64)
        hits = self._steps.answer(world, pair, slots, memory, (level_gap, math.inf, False), hits)
        self._moments[ANSWERED] = time.perf_counter()
        return batch_of(gathered(world, hits, pair, slots, memory, level_gap))

    def point_distances(self, world: World, p_WQs: Floats, threshold: float) -> PointBatch:
        """Return the signed distances of all geometries to points (m, 3) up to ``threshold``."""
        self._kernels, self._unrefined = _NO_KERNELS, 0
        if world.point_shapes.kinds <= POINTS_COMPILED:
            return self._points.answer(world, p_WQs, threshold)
        begun = time.perf_counter()
        self._kernels = compile_point_kernels(world.point_shapes.kinds)
        spent = time.perf_counter() - begun
        batch = self._points.answer(world, p_WQs, threshold)
        self._moments[:COMPILED] -= spent
        return batch

    # Steps.

    def _begin(self, world: World) -> None:
        """Bring the world up to date, without a neighbour list."""
        self._moments[:] = time.perf_counter()
        summary = self._report.summary
        summary[FRAMES_MOVED], summary[BODIES_MOVED] = world.update()
        summary[LIST_MADE] = 0
        self._kernels, self._unrefined = _NO_KERNELS, 0
        self._moments[POSED] = time.perf_counter()
        self._moments[FILTERING] = self._moments[KNOWING] = 0.0

    def _answer_of_none(self, world: World) -> Floats:
        """Return the answer where no pair is near enough: none is measured for its depth."""
        self._begin(world)
        self._last, self._answers = None, _NO_ANSWERS
        self._report.summary[CONSIDERED] = self._report.summary[LISTED_PAIRS] = 0
        self._counts[:] = 0
        self._moments[LISTED] = self._moments[COMPILED] = self._moments[POSED]
        self._moments[ANSWERED] = self._moments[POSED]
        return _NO_ANSWERS

    def _as_before(self, near: NeighbourList) -> Floats:
        """Return the last answer, which is still valid, and report its pairs as cached."""
        self._moments[:] = time.perf_counter()
        summary = self._report.summary
        summary[FRAMES_MOVED] = summary[BODIES_MOVED] = summary[LIST_MADE] = 0
        summary[CONSIDERED], summary[LISTED_PAIRS] = near.considered, near.count
        self._counts[:] = 0
        self._counts[CACHED] = near.count
        self._kernels, self._unrefined = _NO_KERNELS, 0
        self._moments[FILTERING], self._moments[ANSWERED] = 0.0, time.perf_counter()
        self._moments[KNOWING] = self._moments[ANSWERED] - self._moments[COMPILED]
        return self._answers

    def _run(self, prepared: Prepared) -> int:
        """Run a cycle that gathers no answers; return the number of its hits."""
        world = prepared.world
        self._kernels, self._unrefined = prepared.loaded, 0
        prepared.loaded = _NO_KERNELS
        stale, X_PFs = world.is_stale, world.pending_poses
        revision = world.revision + stale
        count: int = run_cycle(prepared.cycle_handle, 0, stale, revision, X_PFs, _NO_ANSWERS)
        world.revision, world.pending_poses, world.is_stale = revision, NO_POSES, False
        return self._go_on(prepared, count, stale, X_PFs, _NO_ANSWERS)

    def _go_on(
        self, prepared: Prepared, count: int, stale: bool, X_PFs: Floats, answers: Floats
    ) -> int:
        """Resume a cycle until it is done, providing what its negative count says is lacking."""
        world = prepared.world
        while count < 0:
            if count == -LACKS_KERNELS:
                self._compile_for(world, prepared.near)
            else:
                prepared.near.make_room(-count)
                prepared.refresh_handles(prepared.filters)
            count = run_cycle(prepared.cycle_handle, -count, stale, world.revision, X_PFs, answers)
        return count

    def _compile_for(self, world: World, near: NeighbourList) -> None:
        """Compile the kernels of the pairs of a list."""
        self._kernels = compile_rows(table_rows(*world.geometries.types[near.pairs].T))
        near.know_kernels()
        self._moments[COMPILED] = time.perf_counter()

    def _answer_of_other_length(self, prepared: Prepared, count: int, answers: Floats) -> Floats:
        """Return ``count`` answers, and prepare an array for as many in later cycles."""
        if count > len(answers):
            answers = self._gathered(prepared, count)
        if count > MANY:
            prepared.seconds = float(self._moments[ANSWERED] - self._moments[COMPILED])
        if not len(answers) // 2 <= count < len(answers):
            prepared.make_room(count)
        answers.flags.writeable = False
        return answers[:count]

    def _gathered(self, prepared: Prepared, count: int) -> Floats:
        """Return ``count`` answers of a cycle whose array was too small for them."""
        near, world = prepared.near, prepared.world
        hits = near.arrays.hits[:count]
        answers = gathered(world, hits, near.pairs, near.slots, near.memory, prepared.level_gap)
        self._moments[ANSWERED] = time.perf_counter()
        return answers

    def _answer_unusually(self, prepared: Prepared, budget: float) -> Floats:
        """Return the answers computed in steps, or by threads."""
        if budget > 0.0 or self.detailed:
            return self._answer_in_steps(prepared, 0.0 if prepared.is_bound else budget)
        return self._answer_shared(prepared)

    def _answer_in_steps(self, prepared: Prepared, budget: float) -> Floats:
        """Return the answers, with steps measured separately or limited by a time budget [s]."""
        self._list_pairs(prepared)
        near, world = prepared.near, prepared.world
        hits = self._steps.answer_list(world, near, prepared.query, budget)
        self._unrefined = self._steps.unrefined
        answers = gathered(world, hits, near.pairs, near.slots, near.memory, prepared.level_gap)
        self._moments[ANSWERED] = time.perf_counter()
        return answers

    def _list_pairs(self, prepared: Prepared) -> None:
        """Bring the neighbour list of a query up to date, and compile the kernels of its pairs."""
        listing = *prepared.query, LIST
        self._run(self._queries.prepared(prepared.world, prepared.filters, *listing))

    def _answer_shared(self, prepared: Prepared) -> Floats:
        """Return the answers of a large query, computed by threads."""
        world = prepared.world
        begun = time.perf_counter()
        moved = world.update_shared()
        spent = time.perf_counter() - begun
        self._list_pairs(prepared)
        self._report.summary[[FRAMES_MOVED, BODIES_MOVED]] = moved
        self._moments[BEGUN] -= spent
        near = prepared.near
        hits = self._steps.answer_shared(world, near, prepared.query)
        count = len(hits)
        prepared.make_room(count)
        answers = np.empty((count, ANSWER_WIDTH))
        memory = near.pairs, near.slots, near.memory, prepared.level_gap, world.handle

        def gather(first: int, last: int) -> None:
            gather_answers(hits[first:last], *memory, answers[first:last])

        share(count, gather)
        self._moments[ANSWERED] = time.perf_counter()
        prepared.seconds = THREADS * float(self._moments[ANSWERED] - self._moments[COMPILED])
        answers.flags.writeable = False
        return answers
