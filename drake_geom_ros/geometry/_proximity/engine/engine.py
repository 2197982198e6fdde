"""The cycle of a query, top to bottom: near pairs, what is known of them, kernels, arrays out."""

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
    """Answers queries on a world under the filters, and tells what that took.

    It belongs to one context: what it knows of pairs holds for the world that it saw last.
    """

    def __init__(self) -> None:
        self.detailed = False  # tell the cache's seconds from those of the kernels, for some more
        # The last answer, and what was asked.
        self._last: Prepared | None = None
        self._answers = _NO_ANSWERS
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
        level_gap = GAPS_OF_LEVELS[accuracy]
        return self._queries.prepared(world, filters, level_gap, cutoff, penetrating, mode)

    def candidates_of(self, prepared: Prepared) -> Indices:
        """Return the unfiltered pairs (k, 2) that bounds alone do not keep apart."""
        count = self._run(prepared)
        near = prepared.near
        pairs: Indices = near.arrays.pairs[near.arrays.hits[:count]]
        self._counts[FAR] = near.count - count
        return pairs

    def answer_of(self, prepared: Prepared, time_budget: float = 0.0) -> Floats:
        """Return the unfiltered pairs within a query's cutoff as rows (k, ANSWER_WIDTH).

        Or only those that overlap, if it is about ``penetrating`` ones. Of pairs that are answered
        from bounds alone, by the level or because the narrow phase has spent its ``time_budget``
        [s] (0: none), all that may be.

        What is usual is done here, in one go: in the first cycle after other work, which is what a
        robot has each time, each function in between comes from memory, too.
        """
        world = prepared.world
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
            count: int = run_cycle(prepared.hands, 0, stale, revision, X_PFs, answers)
            world.revision, world.pending_poses, world.is_stale = revision, NO_POSES, False
            if count < 0:
                count = self._go_on(prepared, count, stale, X_PFs, answers)
            if prepared.fewest <= count <= prepared.most:
                answers.setflags(False)  # type: ignore[call-arg]
                answers = answers[:count]
            else:
                answers = self._answer_of_other_length(prepared, count, answers)
        # What was left at its bounds is refined when somebody asks again.
        if not (self._unrefined or prepared.is_long):
            self._last, self._answers, prepared.answered_at = prepared, answers, world.revision
        elif prepared.is_long:
            self._queries.forget_list(prepared.cutoff)
        return answers

    def finds_overlap(self, prepared: Prepared) -> bool:
        """Return whether ``answer_of`` the query would have a pair that overlaps.

        Or one that may, where rounding hides more than UNSEEN_DEPTH.
        """
        return self._run(prepared) > 0

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
            # As of this level: what another one left is not started from.
            memory[0, NORMAL : NORMAL + 3], memory[0, LEVEL_GAP] = hint, GAPS_OF_LEVELS[accuracy]
        if row < 0:
            return batch_of(gathered(world, slots[:0], pair, slots, memory, math.inf))
        self._kernels = compile_rows(rows)
        self._report.told[CONSIDERED] = self._report.told[LISTED_PAIRS] = 1
        self._moments[LISTED] = self._moments[COMPILED] = time.perf_counter()
        level_gap, hits = GAPS_OF_LEVELS[accuracy], np.empty(1, dtype=np.int64)
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
        """Bring the world up to date, without a list."""
        self._moments[:] = time.perf_counter()
        told = self._report.told
        told[FRAMES_MOVED], told[BODIES_MOVED] = world.update()
        told[LIST_MADE] = 0
        self._kernels, self._unrefined = _NO_KERNELS, 0
        self._moments[POSED] = time.perf_counter()
        self._moments[FILTERING] = self._moments[KNOWING] = 0.0

    def _as_before(self, near: NeighbourList) -> Floats:
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
        return self._answers

    def _run(self, prepared: Prepared) -> int:
        """Run a cycle without answers; return how many pairs it is about."""
        world = prepared.world
        self._kernels, self._unrefined = prepared.loaded, 0
        prepared.loaded = _NO_KERNELS
        stale, X_PFs = world.is_stale, world.pending_poses
        revision = world.revision + stale
        count: int = run_cycle(prepared.hands, 0, stale, revision, X_PFs, _NO_ANSWERS)
        world.revision, world.pending_poses, world.is_stale = revision, NO_POSES, False
        return self._go_on(prepared, count, stale, X_PFs, _NO_ANSWERS)

    def _go_on(
        self, prepared: Prepared, count: int, stale: bool, X_PFs: Floats, answers: Floats
    ) -> int:
        """Go on with a cycle until nothing is lacking any more, of which minus the count tells."""
        world = prepared.world
        while count < 0:
            if count == -LACKS_KERNELS:
                self._compile_for(world, prepared.near)
            else:
                prepared.near.make_room(-count)
                prepared.hand_over(prepared.filters)
            count = run_cycle(prepared.hands, -count, stale, world.revision, X_PFs, answers)
        return count

    def _compile_for(self, world: World, near: NeighbourList) -> None:
        """Compile the kernels of the pairs of a list."""
        self._kernels = compile_rows(table_rows(*world.geometries.types[near.pairs].T))
        near.know_kernels()
        self._moments[COMPILED] = time.perf_counter()

    def _answer_of_other_length(self, prepared: Prepared, count: int, answers: Floats) -> Floats:
        """Return so many answers, and expect as many from now on."""
        if count > len(answers):
            answers = self._gathered(prepared, count)
        if count > MANY:
            prepared.seconds = float(self._moments[ANSWERED] - self._moments[COMPILED])
        if not len(answers) // 2 <= count < len(answers):
            prepared.make_room(count)
        answers.flags.writeable = False
        return answers[:count]

    def _gathered(self, prepared: Prepared, count: int) -> Floats:
        """Return so many answers of a cycle that had no room for them."""
        near, world = prepared.near, prepared.world
        hits = near.arrays.hits[:count]
        answers = gathered(world, hits, near.pairs, near.slots, near.memory, prepared.level_gap)
        self._moments[ANSWERED] = time.perf_counter()
        return answers

    def _answer_unusually(self, prepared: Prepared, budget: float) -> Floats:
        """Return the answer by steps, or by threads."""
        if budget > 0.0 or self.detailed:
            return self._answer_in_steps(prepared, 0.0 if prepared.is_bound else budget)
        return self._answer_shared(prepared)

    def _answer_in_steps(self, prepared: Prepared, budget: float) -> Floats:
        """Return the answer, the seconds of its steps told apart or limited by a budget [s]."""
        self._list_pairs(prepared)
        near, world = prepared.near, prepared.world
        hits = self._steps.answer_list(world, near, prepared.query, budget)
        self._unrefined = self._steps.unrefined
        answers = gathered(world, hits, near.pairs, near.slots, near.memory, prepared.level_gap)
        self._moments[ANSWERED] = time.perf_counter()
        return answers

    def _list_pairs(self, prepared: Prepared) -> None:
        """Bring the list of a query up to date, and see that there are kernels for its pairs."""
        listing = *prepared.query, LIST
        self._run(self._queries.prepared(prepared.world, prepared.filters, *listing))

    def _answer_shared(self, prepared: Prepared) -> Floats:
        """Return a long answer, by threads."""
        world = prepared.world
        begun = time.perf_counter()
        moved = world.update_shared()
        spent = time.perf_counter() - begun
        self._list_pairs(prepared)
        self._report.told[[FRAMES_MOVED, BODIES_MOVED]] = moved
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
