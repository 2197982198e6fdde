"""What each query hands to the compiled cycle, prepared once: a cycle has no time to gather it.

A query is asked again and again, of the same arrays. Looked up here, it takes one compiled call
and hardly any Python around it: the first cycle after other work, which is what a robot has each
time, brings all code from memory, and that of Python costs most.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.engine.pair_query import (
    ASKED,
    CANDIDATES,
    CUTOFF,
    LEVEL_GAP,
    MODE,
    PENETRATING,
    VERSION,
    Hands,
)
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.addresses import (
    ADDRESSES,
    COMPILED_ROWS,
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.report import CONTACT_A, CONTACT_B, ReportArrays
from drake_geom_ros.geometry._proximity.runtime.handles import Handle, handle_of
from drake_geom_ros.geometry._proximity.world.world import World

Indices = NDArray[np.int64]

LEAST_ROOM = 16  # rows made ready for an answer
MANY = 512  # pairs of an answer, of which it is worth while to know how long they took
_LONG = 2**20  # pairs of a list, 130 bytes each: longer ones are made anew each time
_MOST_MASKED = 2**22  # pairs of two kinds of which it is looked up whether all are filtered
_MOST = 16  # queries of one scene that are kept: cutoffs may come without end


class Asked(NamedTuple):
    """A query: the level's gap [m], what it is about, and a mode of ``pair_query``."""

    level_gap: float
    cutoff: float  # [m]
    penetrating: bool
    mode: int


class Prepared:
    """A query of one world, and the handle of all that it works on."""

    __slots__ = (
        '_asked',
        '_report',
        'answered_at',
        'cutoff',
        'fewest',
        'filters',
        'handles',
        'hands',
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
    scene: int  # tells its context whether it is that of now; -1: it is not kept any more
    loaded: Sequence[str]  # the kernels that were compiled or loaded for it, until it is asked
    seconds: float  # that the narrow phase of a long answer took last, of one thread
    answered_at: int  # the revision of the world for which there is an answer, under these filters

    def __init__(self, asked: Asked, world: World, near: NeighbourList, report: Handle) -> None:
        self.level_gap, self.cutoff = asked.level_gap, asked.cutoff
        self.query = asked.level_gap, asked.cutoff, asked.penetrating
        self.is_bound = math.isinf(asked.level_gap)  # to be answered from bounds alone
        self._asked = np.zeros(ASKED)
        self._asked[[LEVEL_GAP, CUTOFF, PENETRATING, MODE]] = (
            *(asked.level_gap, asked.cutoff),
            *(asked.penetrating, asked.mode),
        )
        self.world, self._report, self.near = world, report, near
        self.seconds, self.loaded = 0.0, ()
        self.make_room(0)

    def make_room(self, count: int) -> None:
        """Have room for so many answers, and some more, from now on."""
        self.room = max(LEAST_ROOM, count + count // 4)
        # As many answers as need no other room, nor a look at how long they took.
        self.fewest = 0 if self.room == LEAST_ROOM else self.room // 2
        self.most = min(self.room, MANY)

    def let_go(self) -> None:
        """Hold no list any more, whoever still has this: it is prepared anew."""
        self.scene = -1
        del self.near, self.handles, self.hands

    def hand_over(self, filters: FilterState) -> None:
        """Take the arrays that are there now."""
        self.near.look_at(self.world, filters)
        self.filters, self.version, self.answered_at = filters, filters.version, -1
        self._asked[VERSION] = filters.version
        self.handles = self.near.handles  # who has the handle of handles keeps these, too
        hands = Hands(self.world.handle, *self.handles, self._report, ADDRESSES, self._asked)
        self.hands = handle_of(hands)
        self.is_long = len(self.near.arrays.slots) > _LONG


class PreparedQueries:
    """The queries of one world that were asked last, and the neighbour lists that they share."""

    def __init__(self, report: ReportArrays) -> None:
        self._report, self._report_handle = report, handle_of(report)
        self._world: World | None = None
        self._lists: dict[bool, NeighbourList] = {}
        self._known: dict[tuple[float, float, bool, int], Prepared] = {}
        # The world and filters whose kernels are there.
        self._ready: tuple[World, FilterState, int] | None = None

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self._known, self._report_handle, self._ready = {}, handle_of(self._report), None

    def prepared(
        self,
        world: World,
        filters: FilterState,
        level_gap: float,
        cutoff: float,
        penetrating: bool,
        mode: int,
    ) -> Prepared:
        """Return a query of this world under these filters."""
        if world is self._world:
            known = self._known.get((level_gap, cutoff, penetrating, mode))
            if (
                known is not None
                and known.handles is known.near.handles
                and known.filters is filters
                and known.version == filters.version
            ):
                return known
        return self._prepare(world, filters, Asked(level_gap, cutoff, penetrating, mode))

    def forget_list(self, cutoff: float) -> None:
        """Give back the list that queries with such a cutoff work on."""
        self._lists.pop(math.isinf(cutoff))
        for known in self._known.values():
            known.let_go()
        self._known.clear()

    def _prepare(self, world: World, filters: FilterState, asked: Asked) -> Prepared:
        """Prepare a query anew, or once more."""
        if world is not self._world:
            self._world, self._lists, self._known = world, {}, {}
            self._report.told[[CONTACT_A, CONTACT_B]] = -1
        # A list of all pairs would be a burden to the queries of near ones.
        unlimited = asked.cutoff == math.inf
        near = self._lists.get(unlimited)
        if near is None:
            near = self._lists[unlimited] = NeighbourList(world, unlimited)
        known = self._known.get(asked)
        if known is None:
            if len(self._known) == _MOST:
                self._known.pop(next(iter(self._known))).scene = -1
            known = self._known[asked] = Prepared(asked, world, near, self._report_handle)
        if asked.mode != CANDIDATES and not known.is_bound:
            known.loaded = self._load_kernels(world, filters) or known.loaded
        known.hand_over(filters)
        return known

    def _load_kernels(self, world: World, filters: FilterState) -> list[str]:
        """Compile or load the kernels of all unfiltered pairs of kinds; return their names.

        Not when two kinds first come near each other: that is the cycle that must not be late.
        """
        ready = self._ready
        if ready is not None and ready[0] is world and ready[1:] == (filters, filters.version):
            return []
        table = world.geometries
        moving, kinds = np.unique(table.types[~world.anchored]), np.unique(table.types)
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
    """Return whether a pair of one of some slots and one of others is unfiltered.

    Of very many true without a look.
    """
    if len(a) * len(b) > _MOST_MASKED:
        return True
    return any(filters.mask(np.full(len(b), slot), b).any() for slot in a)
