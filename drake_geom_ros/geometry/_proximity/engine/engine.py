"""The cycle of a query, top to bottom: near pairs, what is known of them, kernels, arrays out."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.effects import Effects, seconds_by_step
from drake_geom_ros.geometry._proximity.engine.pair_query import (
    ANSWERS,
    CANDIDATES,
    CONTACT,
    LACKS_KERNELS,
    LIST,
    run_cycle,
)
from drake_geom_ros.geometry._proximity.engine.prepared import Prepared, PreparedQueries
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.addresses import (
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import NORMAL
from drake_geom_ros.geometry._proximity.kinds import Method
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.pairs.answer_rows import (
    BATCH_WIDTH,
    PairBatch,
    PointBatch,
    frozen,
    gather_rows,
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
from drake_geom_ros.geometry._proximity.tolerances import LEVEL_GAPS
from drake_geom_ros.geometry._proximity.world.world import NO_POSES, World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Arrays: TypeAlias = tuple[Indices, Floats]  # of a ``PairBatch``, to make which takes longer

ACCURACY_LEVELS = ('bound', *LEVEL_GAPS)
# How a pair was answered: name and number, as in the messages.
METHODS = {method.name.lower(): method.value for method in Method}
_LEVEL_GAPS = {'bound': math.inf, **LEVEL_GAPS}
_NO_IDS, _NO_ROWS = np.zeros((0, 2), dtype=np.int64), np.zeros((0, BATCH_WIDTH))
_NO_BATCH = _NO_IDS, _NO_ROWS
_NO_KERNELS = ()
MANY = 512  # pairs of an answer, of which it is worth while to know how long they took


class Engine:
    """Answers queries on a world under the filters, and tells what that took.

    It belongs to one context: what it knows of pairs holds for the world that it saw last.
    """

    def __init__(self) -> None:
        self.detailed = False  # tell the cache's seconds from those of the kernels, for some more
        # The last answer, and what was asked.
        self._last: Prepared | None = None
        self._batch: Arrays = _NO_BATCH
        # What the last query did; put in words only for those who ask.
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
        """What the last query did and what it skipped."""
        counts, told = self._counts.tolist(), self._report.told.tolist()
        return Effects(
            frames_moved=told[FRAMES_MOVED],
            geometries_updated=told[BODIES_MOVED],
            broadphase_pairs=told[CONSIDERED],
            filtered_pairs=told[CONSIDERED] - told[LISTED_PAIRS],
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
            near_list_made=bool(told[LIST_MADE]),
            kernels_compiled=list(self._kernels),
            seconds=seconds_by_step(*self._moments.tolist()),
        )

    def prepare(self, world: World, tell: Tell | None = None) -> list[str]:
        """Compile the kernels of the shape pairs that the world can have; return their names."""
        types = world.geometries.types
        moving = np.unique(types[~world.anchored])
        return compile_rows(table_rows(moving[:, None], np.unique(types)[None, :]), tell)

    def prepared(
        self,
        world: World,
        filters: FilterState,
        accuracy: str,
        cutoff: float,
        penetrating: bool,
        mode: int,
    ) -> Prepared:
        """Return a query of a world under filters, in a mode of ``pair_query``, for many asks."""
        level_gap = _LEVEL_GAPS[accuracy]
        return self._queries.prepared(world, filters, level_gap, cutoff, penetrating, mode)

    def candidates(self, world: World, filters: FilterState, distance: float) -> Indices:
        """Return the unfiltered pairs (k, 2) that bounds alone do not keep apart."""
        prepared = self.prepared(world, filters, 'bound', distance, False, CANDIDATES)
        return self.candidates_of(prepared, world)

    def candidates_of(self, prepared: Prepared, world: World) -> Indices:
        """Return ``candidates`` of a prepared query."""
        count = self._run(prepared, world)
        near = prepared.near
        pairs: Indices = near.arrays.pairs[near.arrays.hits[:count]]
        self._counts[FAR] = near.count - count
        return pairs

    def signed_distances(
        self,
        world: World,
        filters: FilterState,
        accuracy: str,
        cutoff: float,
        penetrating: bool = False,
        time_budget: float = 0.0,
    ) -> PairBatch:
        """Return the unfiltered pairs within ``cutoff`` [m], or only those that overlap.

        Of pairs that are answered from bounds alone, by the level or because the narrow phase has
        spent its ``time_budget`` [s] (0: none), all that may be.
        """
        prepared = self.prepared(world, filters, accuracy, cutoff, penetrating, ANSWERS)
        return PairBatch(*self.answer_of(prepared, world, time_budget))

    def answer_of(self, prepared: Prepared, world: World, time_budget: float = 0.0) -> Arrays:
        """Return ids and rows of ``signed_distances`` of a prepared query."""
        stands = self._last is prepared and not world.is_stale
        if stands and prepared.answered_at == world.revision:
            return self._as_before(prepared.near)
        self._last, self._batch = None, _NO_BATCH
        if time_budget > 0.0 or self.detailed:
            limited = not prepared.is_bound
            batch: Arrays = self._answer_in_steps(prepared, world, time_budget if limited else 0.0)
        elif prepared.seconds > LONG and THREADS > 1:
            batch = self._answer_shared(prepared, world)
        else:
            batch = self._answer_alone(prepared, world)
        # What was left at its bounds is refined when somebody asks again.
        if not self._unrefined:
            self._last, self._batch, prepared.answered_at = prepared, batch, world.revision
        if prepared.is_long:
            self._last, self._batch = None, _NO_BATCH
            self._queries.forget_list(prepared.cutoff)
        return batch

    def has_overlap(self, world: World, filters: FilterState, accuracy: str) -> bool:
        """Return whether ``signed_distances`` would return a pair that overlaps.

        Or one that may, where rounding hides more than UNSEEN_DEPTH.
        """
        prepared = self.prepared(world, filters, accuracy, 0.0, True, CONTACT)
        return self.finds_overlap(prepared, world)

    def finds_overlap(self, prepared: Prepared, world: World) -> bool:
        """Return ``has_overlap`` of a prepared query."""
        return self._run(prepared, world) > 0

    def distance_of_pair(
        self, world: World, pair: Indices, accuracy: str, hint: Floats | None = None
    ) -> PairBatch:
        """Return the signed distance of one pair (1, 2), whatever the filters say.

        ``hint`` (3,) is the normal that an iteration starts from. Two half spaces have no
        distance: the batch is empty then.
        """
        self._begin(world)
        (row,) = rows = table_rows(*world.geometries.types[pair].T)
        slots, memory = np.zeros(1, dtype=np.int64), empty_memory(1)
        if hint is not None:
            memory[0, NORMAL : NORMAL + 3] = hint
        if row < 0:
            return gathered(world, slots[:0], pair, slots, memory, math.inf)
        self._kernels = compile_rows(rows)
        self._report.told[CONSIDERED] = self._report.told[LISTED_PAIRS] = 1
        self._moments[LISTED] = self._moments[COMPILED] = time.perf_counter()
        level_gap, hits = _LEVEL_GAPS[accuracy], np.empty(1, dtype=np.int64)
        hits = self._steps.answer(world, pair, slots, memory, (level_gap, math.inf, False), hits)
        self._moments[ANSWERED] = time.perf_counter()
        return gathered(world, hits, pair, slots, memory, level_gap)

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
        """Bring the world up to date, without a list."""
        self._moments[:] = time.perf_counter()
        told = self._report.told
        told[FRAMES_MOVED], told[BODIES_MOVED] = world.update()
        told[LIST_MADE] = 0
        self._kernels, self._unrefined = _NO_KERNELS, 0
        self._moments[POSED] = time.perf_counter()
        self._moments[FILTERING] = self._moments[KNOWING] = 0.0

    def _as_before(self, near: NeighbourList) -> Arrays:
        """Return the last answer, about the pairs of a list, which still stands."""
        self._moments[:] = time.perf_counter()
        told = self._report.told
        told[FRAMES_MOVED] = told[BODIES_MOVED] = told[LIST_MADE] = 0
        told[CONSIDERED], told[LISTED_PAIRS] = near.considered, near.count
        self._counts[:] = 0
        self._counts[CACHED] = near.count
        self._kernels, self._unrefined = _NO_KERNELS, 0
        self._moments[FILTERING], self._moments[ANSWERED] = 0.0, time.perf_counter()
        self._moments[KNOWING] = self._moments[ANSWERED] - self._moments[COMPILED]
        return self._batch

    def _run(
        self, prepared: Prepared, world: World, ids: Indices = _NO_IDS, rows: Floats = _NO_ROWS
    ) -> int:
        """Run a cycle; return how many pairs it is about."""
        self._kernels, self._unrefined = _NO_KERNELS, 0
        stale = world.is_stale
        revision = world.revision + stale
        posed = stale, revision, world.pending_frames.rows, world.pending_poses
        count: int = run_cycle(prepared.hands, 0, *posed, ids, rows)
        world.revision, world.pending_poses, world.is_stale = revision, NO_POSES, False
        while count < 0:
            if count == -LACKS_KERNELS:
                self._compile_for(world, prepared.near)
            else:
                prepared.near.make_room(-count)
                prepared.hand_over(prepared.filters)
            count = run_cycle(prepared.hands, -count, *posed, ids, rows)
        return count

    def _compile_for(self, world: World, near: NeighbourList) -> None:
        """Compile the kernels of the pairs of a list."""
        self._kernels = compile_rows(table_rows(*world.geometries.types[near.pairs].T))
        near.know_kernels()
        self._moments[COMPILED] = time.perf_counter()

    def _answer_alone(self, prepared: Prepared, world: World) -> Arrays:
        """Return the answer in one compiled call, where it is about as long as before."""
        room = prepared.room
        ids, rows = np.empty((room, 2), np.int64), np.empty((room, BATCH_WIDTH))
        count = self._run(prepared, world, ids, rows)
        if count > room:
            return self._gathered(prepared, world, count)
        if count > MANY:
            prepared.seconds = float(self._moments[ANSWERED] - self._moments[COMPILED])
        if count < room // 2:
            prepared.make_room(count)
        return frozen(ids[:count], rows[:count])

    def _gathered(self, prepared: Prepared, world: World, count: int) -> PairBatch:
        """Return so many answers of a cycle that had no room for them."""
        near = prepared.near
        hits = near.arrays.hits[:count]
        prepared.make_room(count)
        batch = gathered(world, hits, near.pairs, near.slots, near.memory, prepared.level_gap)
        self._moments[ANSWERED] = time.perf_counter()
        return batch

    def _answer_in_steps(self, prepared: Prepared, world: World, budget: float) -> PairBatch:
        """Return the answer, the seconds of its steps told apart or limited by a budget [s]."""
        self._list_pairs(prepared, world)
        near = prepared.near
        hits = self._steps.answer_list(world, near, prepared.query, budget)
        self._unrefined = self._steps.unrefined
        batch = gathered(world, hits, near.pairs, near.slots, near.memory, prepared.level_gap)
        self._moments[ANSWERED] = time.perf_counter()
        return batch

    def _list_pairs(self, prepared: Prepared, world: World) -> None:
        """Bring the list of a query up to date, and see that there are kernels for its pairs."""
        self._run(self._queries.prepared(world, prepared.filters, *prepared.query, LIST), world)

    def _answer_shared(self, prepared: Prepared, world: World) -> Arrays:
        """Return a long answer, by threads."""
        begun = time.perf_counter()
        moved = world.update_shared()
        spent = time.perf_counter() - begun
        self._list_pairs(prepared, world)
        self._report.told[[FRAMES_MOVED, BODIES_MOVED]] = moved
        self._moments[BEGUN] -= spent
        near = prepared.near
        hits = self._steps.answer_shared(world, near, prepared.query)
        count = len(hits)
        prepared.make_room(count)
        ids, rows = np.empty((count, 2), np.int64), np.empty((count, BATCH_WIDTH))
        memory = near.pairs, near.slots, near.memory, prepared.level_gap, world.handle

        def gather(first: int, last: int) -> None:
            gather_rows(hits[first:last], *memory, ids[first:last], rows[first:last])

        share(count, gather)
        self._moments[ANSWERED] = time.perf_counter()
        prepared.seconds = THREADS * float(self._moments[ANSWERED] - self._moments[COMPILED])
        return frozen(ids, rows)
