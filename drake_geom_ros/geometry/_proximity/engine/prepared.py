"""Prepared queries: the handles that a query passes to the compiled cycle, gathered once.

A query is repeated many times over the same arrays. A prepared query takes one compiled call and
hardly any Python around it. This matters in the first cycle after other work, the usual case on a
robot: all code is then fetched from memory, and Python's code costs most.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.engine.pair_query import (
    CANDIDATES,
    CUTOFF,
    LEVEL_GAP,
    MODE,
    PARAMETER_COUNT,
    PENETRATING,
    VERSION,
    CycleHandles,
)
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.addresses import (
    ADDRESSES,
    COMPILED_ROWS,
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.near.following import following
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.report import CONTACT_A, CONTACT_B, ReportArrays
from drake_geom_ros.geometry._proximity.runtime.handles import Handle, handle_of
from drake_geom_ros.geometry._proximity.world.row_change import RowChange
from drake_geom_ros.geometry._proximity.world.world import World

Indices = NDArray[np.int64]

LEAST_ROOM = 16  # rows allocated for the answers of a cycle, at least
MANY = 512  # pairs of an answer from which on its time is measured
_LONG = 2**20  # pairs of a list, 130 bytes each: longer lists are discarded after use
_MOST_MASKED = 2**22  # pairs of two kinds up to which the filters are examined
_MOST = 16  # prepared queries of one scene: there may be any number of cutoffs


class QueryKey(NamedTuple):
    """Parameters that identify a prepared query; ``mode`` is one of ``pair_query``."""

    level_gap: float
    cutoff: float  # [m]
    penetrating: bool
    mode: int


class Prepared:
    """A query of one world, with the handle of all arrays that it works on."""

    __slots__ = (
        '_parameters',
        '_report',
        'answered_at',
        'cutoff',
        'cycle_handle',
        'fewest',
        'filters',
        'handles',
        'is_bound',
        'is_long',
        'level_gap',
        'loaded',
        'most',
        'near',
        'query',
        'room',
        'scene',
        'seconds',
        'version',
        'world',
    )
    filters: FilterState
    version: int  # of the filters
    scene: int  # version of model and filters that its context saw; -1: no longer valid
    loaded: Sequence[str]  # kernels compiled or loaded for it and not yet reported
    seconds: float  # of the last narrow phase of a large answer, by one thread
    answered_at: int  # revision of the world at the last answer under these filters

    def __init__(self, key: QueryKey, world: World, near: NeighbourList, report: Handle) -> None:
        self.level_gap, self.cutoff = key.level_gap, key.cutoff
        self.query = key.level_gap, key.cutoff, key.penetrating
        self.is_bound = math.isinf(key.level_gap)  # answered from bounds alone
        self._parameters = np.zeros(PARAMETER_COUNT)
        self._parameters[[LEVEL_GAP, CUTOFF, PENETRATING, MODE]] = (
            *(key.level_gap, key.cutoff),
            *(key.penetrating, key.mode),
        )
        self.world, self._report, self.near = world, report, near
        self.seconds, self.loaded = 0.0, ()
        self.make_room(0)

    def make_room(self, count: int) -> None:
        """Allocate somewhat more than ``count`` answers in later cycles."""
        self.room = max(LEAST_ROOM, count + count // 4)
        # Numbers of answers that need neither another allocation nor a time measurement.
        self.fewest = 0 if self.room == LEAST_ROOM else self.room // 2
        self.most = min(self.room, MANY)

    def invalidate(self) -> None:
        """Release the neighbour list; a holder of this query has to prepare it again."""
        self.scene = -1
        del self.near, self.handles, self.cycle_handle

    def refresh_handles(self, filters: FilterState) -> None:
        """Make the handles of the current arrays."""
        self.near.look_at(self.world, filters)
        self.filters, self.version, self.answered_at = filters, filters.version, -1
        self._parameters[VERSION] = filters.version
        self.handles = self.near.handles  # kept alive as long as the handle of handles
        handles = CycleHandles(
            self.world.handle, *self.handles, self._report, ADDRESSES, self._parameters
        )
        self.cycle_handle = handle_of(handles)
        self.is_long = len(self.near.arrays.slots) > _LONG


class PreparedQueries:
    """The recent queries of one world, and the neighbour lists that they share."""

    def __init__(self, report: ReportArrays) -> None:
        self._report, self._report_handle = report, handle_of(report)
        self._world: World | None = None
        self._lists: dict[bool, NeighbourList] = {}
        self._queries: dict[tuple[float, float, bool, int], Prepared] = {}
        # The world and filters whose kernels are loaded.
        self._ready: tuple[World, FilterState, int] | None = None

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self._queries, self._report_handle, self._ready = {}, handle_of(self._report), None

    def prepared(
        self,
        world: World,
        filters: FilterState,
        level_gap: float,
        cutoff: float,
        penetrating: bool,
        mode: int,
    ) -> Prepared:
        """Return the prepared query with these parameters, preparing it if necessary."""
        if world is self._world:
            query = self._queries.get((level_gap, cutoff, penetrating, mode))
            if (
                query is not None
                and query.handles is query.near.handles
                and query.filters is filters
                and query.version == filters.version
            ):
                return query
        return self._prepare(world, filters, QueryKey(level_gap, cutoff, penetrating, mode))

    def follow(self, former: World, world: World, change: RowChange) -> None:
        """Keep the neighbour lists of a former world for one with changed rows."""
        if former is not self._world:
            return
        self._lists = {
            unlimited: following(near, world, change) for unlimited, near in self._lists.items()
        }
        for query in self._queries.values():
            query.scene = -1
        self._report.summary[[CONTACT_A, CONTACT_B]] = -1
        self._world, self._queries = world, {}

    def forget_list(self, cutoff: float) -> None:
        """Release the neighbour list of queries with such a cutoff, and all prepared queries."""
        self._lists.pop(math.isinf(cutoff))
        for query in self._queries.values():
            query.invalidate()
        self._queries.clear()

    def _prepare(self, world: World, filters: FilterState, key: QueryKey) -> Prepared:
        """Prepare a query for the first time, or again after its arrays changed."""
        if world is not self._world:
            self._world, self._lists, self._queries = world, {}, {}
            self._report.summary[[CONTACT_A, CONTACT_B]] = -1
        # A list of all pairs would slow down queries with a finite cutoff.
        unlimited = key.cutoff == math.inf
        near = self._lists.get(unlimited)
        if near is None:
            near = self._lists[unlimited] = NeighbourList(world, unlimited)
        query = self._queries.get(key)
        if query is None:
            if len(self._queries) == _MOST:
                self._queries.pop(next(iter(self._queries))).scene = -1
            query = self._queries[key] = Prepared(key, world, near, self._report_handle)
        if key.mode != CANDIDATES and not query.is_bound:
            query.loaded = self._load_kernels(world, filters) or query.loaded
        query.refresh_handles(filters)
        return query

    def _load_kernels(self, world: World, filters: FilterState) -> list[str]:
        """Compile or load the kernels of all unfiltered pairs of kinds; return their names.

        Loading them when two kinds first come near each other would delay that very cycle.
        """
        ready = self._ready
        if ready is not None and ready[0] is world and ready[1:] == (filters, filters.version):
            return []
        table = world.geometries
        moving, kinds = (
            np.flatnonzero(np.bincount(types))
            for types in (table.types[~world.anchored], table.types)
        )
        rows = table_rows(moving[:, None], kinds[None, :])
        missing = (rows >= 0) & ~COMPILED_ROWS[rows]
        if missing.any():
            slots = filters.slots(table.ids)
            for i, j in np.argwhere(missing).tolist():
                of_kinds = (slots[table.types == kind] for kind in (moving[i], kinds[j]))
                missing[i, j] = _may_report(filters, *of_kinds)
        names = compile_rows(rows[missing]) if missing.any() else []
        self._ready = world, filters, filters.version
        return names


def _may_report(filters: FilterState, a: Indices, b: Indices) -> bool:
    """Return whether any pair of a slot in ``a`` and one in ``b`` is unfiltered.

    More than _MOST_MASKED pairs count as unfiltered without being examined.
    """
    if len(a) * len(b) > _MOST_MASKED:
        return True
    return any(filters.mask(np.full(len(b), slot), b).any() for slot in a)
