"""The cycle of a query, top to bottom: near pairs, what is known of them, kernels, arrays out."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.batches import PairBatch, PointBatch, gathered
from drake_geom_ros.geometry._proximity.budget import Pace
from drake_geom_ros.geometry._proximity.compiled import Tell
from drake_geom_ros.geometry._proximity.effects import Effects, Moments
from drake_geom_ros.geometry._proximity.filter_state import FilterState
from drake_geom_ros.geometry._proximity.kernel_table import (
    ADDRESSES,
    are_compiled,
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import NORMAL, PAIR_WIDTH
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_WIDTH
from drake_geom_ros.geometry._proximity.kinds import SPHERE, Method
from drake_geom_ros.geometry._proximity.narrow_phase import (
    BY_METHOD,
    CACHED,
    COUNTS,
    FAR,
    POSTPONED,
    WIDE,
    answer_pairs,
    bound_pairs,
    near_pairs,
)
from drake_geom_ros.geometry._proximity.near_list import NearList
from drake_geom_ros.geometry._proximity.point_phase import (
    POINT_ADDRESSES,
    compile_point_kernels,
    point_phase,
)
from drake_geom_ros.geometry._proximity.records import Plain, empty_memory
from drake_geom_ros.geometry._proximity.tolerances import LEVEL_GAPS
from drake_geom_ros.geometry._proximity.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

ACCURACY_LEVELS = ('bound', *LEVEL_GAPS)
# How a pair was answered: name and number, as in the messages.
METHODS = {method.name.lower(): method.value for method in Method}
_GAPS = {'bound': math.inf, **LEVEL_GAPS}
_AT_ONCE = np.zeros(0, dtype=np.int64), np.zeros(0)  # a queue in which no pair waits
_KEPT_PAIRS = 2**20  # of a list of all pairs, 130 bytes each: longer ones are made anew each time


class Engine:
    """Answers queries on a world under the filters, and tells what that took.

    It belongs to one context: what it knows of pairs holds for the world that it saw last.
    """

    def __init__(self) -> None:
        self.detailed = False  # tell the cache's seconds from those of the kernels, for some more
        self._world: World | None = None
        self._lists: dict[bool, NearList] = {}
        self._hits: Indices = np.zeros(0, dtype=np.int64)
        self._last: tuple[tuple[object, ...], PairBatch] | None = None
        self._last_contact = 0
        self._pace = Pace()
        # What the last query did; put in words only for those who ask.
        self._counts = np.zeros(COUNTS, dtype=np.int64)
        self._moved = 0, 0
        self._considered = self._filtered = self._unrefined = 0
        self._list_made = False
        self._kernels: list[str] = []
        self._moments = Moments()
        self._filter_seconds = self._cache_seconds = 0.0

    @property
    def effects(self) -> Effects:
        """What the last query did and what it skipped."""
        counts, at = self._counts.tolist(), self._moments
        return Effects(
            frames_moved=self._moved[0],
            geometries_updated=self._moved[1],
            broadphase_pairs=self._considered,
            filtered_pairs=self._filtered,
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
            near_list_made=self._list_made,
            kernels_compiled=list(self._kernels),
            seconds=at.seconds(self._filter_seconds, self._cache_seconds),
        )

    def prepare(self, world: World, tell: Tell | None = None) -> list[str]:
        """Compile the kernels of the shape pairs that the world can have; return their names."""
        types = world.geometries.types
        moving = np.unique(types[~world.anchored])
        return compile_rows(table_rows(moving[:, None], np.unique(types)[None, :]), tell)

    def candidates(self, world: World, filters: FilterState, distance: float) -> Indices:
        """Return the unfiltered pairs (k, 2) that bounds alone do not keep apart."""
        near = self._near(world, filters, distance)
        count = near_pairs(near.pairs, world.scene, distance, self._hits)
        self._counts[:] = 0
        self._counts[FAR] = len(near.pairs) - count
        self._moments.answered = time.perf_counter()
        pairs: Indices = near.pairs[self._hits[:count]]
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
        near = self._near(world, filters, cutoff)
        query = _GAPS[accuracy], cutoff, penetrating
        moment = (world.revision, world.placings, filters.version, query)
        if self._last is not None and self._last[0] == moment:
            self._counts[:] = 0
            self._counts[CACHED] = len(near.pairs)
            self._moments.answered = time.perf_counter()
            self._cache_seconds = self._moments.answered - self._moments.compiled
            return self._last[1]
        self._compile_for(world, near, accuracy)
        limited = time_budget > 0.0 and accuracy != 'bound'
        if limited and not self._pace.fits(len(near.pairs), time_budget):
            hits = self._answer_within(world, near, query, time_budget)
        elif self.detailed:
            hits = self._answer_apart(world, near, query)
        else:
            hits = self._answer(world, near.pairs, near.slots, near.memory, query)
            if limited:
                computed = int(self._counts[BY_METHOD:].sum())
                self._pace.learn(computed, time.perf_counter() - self._moments.compiled)
        batch = gathered(world, hits, near.pairs, near.slots, near.answers, query[0])
        self._moments.answered = time.perf_counter()
        # What was left at its bounds is refined when somebody asks again.
        self._last = None if self._unrefined else (moment, batch)
        if len(near.pairs) > _KEPT_PAIRS:
            self._last = None
            self._lists.pop(math.isinf(cutoff))
        return batch

    def has_overlap(self, world: World, filters: FilterState, accuracy: str) -> bool:
        """Return whether ``signed_distances`` would return a pair that overlaps.

        Or one that may, where rounding hides more than UNSEEN_DEPTH.
        """
        near = self._near(world, filters, 0.0)
        self._compile_for(world, near, accuracy)
        query = _GAPS[accuracy], 0.0, True
        # Where there was a contact there still is one, mostly.
        first = min(self._last_contact, len(near.pairs))
        hits = self._answer(world, near.pairs, near.slots, near.memory, query, first)
        self._moments.answered = time.perf_counter()
        if len(hits):
            self._last_contact = int(hits[0])
        return len(hits) > 0

    def distance_of_pair(
        self, world: World, pair: Indices, accuracy: str, hint: Floats | None = None
    ) -> PairBatch:
        """Return the signed distance of one pair (1, 2), whatever the filters say.

        ``hint`` (3,) is the normal that an iteration starts from. Two half spaces have no
        distance: the batch is empty then.
        """
        self._begin(world)
        types = world.geometries.types[pair]
        rows = table_rows(types[:, 0], types[:, 1])
        slots, answers = np.zeros(1, dtype=np.int64), np.zeros((1, PAIR_WIDTH))
        if hint is not None:
            answers[0, NORMAL : NORMAL + 3] = hint
        if rows[0] < 0:
            return gathered(world, slots[:0], pair, slots, answers, math.inf)
        self._kernels = compile_rows(rows)
        self._considered, self._filtered = 1, 0
        self._moments.listed = self._moments.compiled = time.perf_counter()
        self._make_room(1)
        memory = empty_memory(answers)
        query = _GAPS[accuracy], math.inf, False
        hits = self._answer(world, pair, slots, memory, query)
        self._moments.answered = time.perf_counter()
        return gathered(world, hits, pair, slots, answers, query[0])

    def point_distances(self, world: World, p_WQs: Floats, threshold: float) -> PointBatch:
        """Return the signed distances of all geometries to points (m, 3) up to ``threshold``."""
        self._begin(world)
        self._moments.listed = time.perf_counter()
        table = world.geometries
        self._kernels = compile_point_kernels(table.types)
        self._moments.compiled = time.perf_counter()
        pair_rows = table_rows(np.full_like(table.types, SPHERE), table.types)
        capacity = len(p_WQs) * len(table.types)
        rows, found = np.empty((capacity, POINT_WIDTH)), np.zeros(capacity, dtype=np.bool_)
        points, ids = np.empty(capacity, np.uint32), np.empty(capacity, np.int64)
        self._counts[:] = 0
        count = point_phase(
            POINT_ADDRESSES,
            ADDRESSES,
            pair_rows,
            table.ids,
            world.scene,
            p_WQs,
            threshold,
            rows,
            found,
            points,
            ids,
            self._counts[BY_METHOD:],
        )
        self._considered, self._filtered = capacity, 0
        self._counts[FAR] = capacity - count
        self._moments.answered = time.perf_counter()
        if world.is_whole:
            return PointBatch(ids[:count], points[:count], rows[:count])
        there = np.flatnonzero(~world.waiting[np.searchsorted(table.ids, ids[:count])])
        return PointBatch(ids[there], points[there], rows[there])

    # Steps.

    def _begin(self, world: World) -> None:
        """Bring the world up to date."""
        self._moments.begun = time.perf_counter()
        if world is not self._world:
            self._world, self._lists, self._last = world, {}, None
        self._moved = world.update()
        self._list_made, self._kernels, self._unrefined = False, [], 0
        self._filter_seconds = self._cache_seconds = 0.0
        self._moments.posed = time.perf_counter()

    def _near(self, world: World, filters: FilterState, distance: float) -> NearList:
        """Return the list of the unfiltered pairs within ``distance``, the world up to date."""
        self._begin(world)
        # A list of all pairs would be a burden to the queries of near ones.
        unlimited = distance == math.inf
        near = self._lists.get(unlimited)
        if near is None:
            near = self._lists[unlimited] = NearList(world)
        self._list_made = near.bring_up_to_date(world, filters, distance)
        if self._list_made:
            self._make_room(len(near.pairs))
            self._filter_seconds = near.filter_seconds
        self._considered = near.considered
        self._filtered = near.considered - len(near.pairs)
        self._moments.listed = self._moments.compiled = time.perf_counter()
        return near

    def _compile_for(self, world: World, near: NearList, accuracy: str) -> None:
        """Compile the kernels of the pairs of a list, once in its life; bounds need none."""
        if not near.has_kernels and accuracy != 'bound':
            types = world.geometries.types
            if not are_compiled(types, near.pairs):
                of_pairs = types[near.pairs]
                self._kernels = compile_rows(table_rows(of_pairs[:, 0], of_pairs[:, 1]))
            near.has_kernels = True
            self._moments.compiled = time.perf_counter()

    def _make_room(self, pairs: int) -> None:
        if len(self._hits) < pairs:
            self._hits = np.empty(2 * pairs, dtype=np.int64)

    def _answer(
        self,
        world: World,
        pairs: Indices,
        slots: Indices,
        memory: Plain,
        query: tuple[float, float, bool],
        first: int = -1,
        queue: tuple[Indices, Floats] = _AT_ONCE,
    ) -> Indices:
        """Return the numbers of the pairs that ``query`` is about, their slots up to date.

        With a ``queue`` for all pairs, those that need a kernel are put there instead.
        """
        found = answer_pairs(
            ADDRESSES,
            pairs,
            slots,
            memory,
            world.scene,
            world.revision,
            query,
            first,
            queue,
            self._hits,
            self._counts,
        )
        return self._hits[:found]

    def _answer_apart(
        self, world: World, near: NearList, query: tuple[float, float, bool]
    ) -> Indices:
        """Return what ``_answer`` does: first what is known, then what kernels have to compute."""
        queue = np.empty(len(near.pairs), dtype=np.int64), _AT_ONCE[1]
        asked = near.pairs, near.slots, near.memory, query
        known = self._answer(world, *asked, queue=queue).copy()
        total = self._counts.copy()
        if total[CACHED]:
            self._cache_seconds = time.perf_counter() - self._moments.compiled
        some = queue[0][: total[POSTPONED]]
        total[POSTPONED] = 0
        hits = some[self._answer(world, near.pairs[some], near.slots[some], *asked[2:])]
        self._counts += total
        return np.sort(np.concatenate((known, hits)))

    def _answer_within(
        self, world: World, near: NearList, query: tuple[float, float, bool], seconds: float
    ) -> Indices:
        """Return what ``_answer`` does, kernels for the nearest pairs only as time lasts."""
        room = len(near.pairs)
        waiting, distances = queue = np.empty(room, dtype=np.int64), np.empty(room)
        start = self._moments.compiled
        known = self._answer(world, near.pairs, near.slots, near.memory, query, queue=queue)
        hits, total = [known.copy()], self._counts.copy()
        count = int(total[POSTPONED])
        total[POSTPONED] = 0

        def compute(block: Indices) -> None:
            some = waiting[block]
            asked = near.pairs[some], near.slots[some], near.memory, query
            hits.append(some[self._answer(world, *asked)])
            total[:] += self._counts

        # What is left is bounded once more, as all that wait were just now.
        reserve = (time.perf_counter() - start) / max(1, count)
        left = self._pace.spend(distances[:count], compute, start + seconds, reserve)
        if len(left):
            some = waiting[left]
            found = bound_pairs(
                near.pairs[some],
                near.slots[some],
                near.memory,
                world.scene,
                world.revision,
                query,
                self._hits,
                self._counts,
            )
            hits.append(some[self._hits[:found]])
            total += self._counts
            self._unrefined = found
        self._counts[:] = total
        return np.sort(np.concatenate(hits))
