"""Which pairs are near enough to be looked at, and what is known of each, from cycle to cycle.

A list is made for a little more than the distance that is asked for: the box of each body gets a
margin of as far as the body is expected to come in some updates, and the list stands until a body
leaves its box (Verlet's neighbour list, *Physical Review* 159, 98, 1967, with margins of each
body's own). Only then the broad phase runs again, and only for the bodies that move: those that
rest were put into its cells, and paired among themselves, once. Where somebody moves so fast that
no margin lasts, nobody gets one: the list is made for each update, and has no pair too many.

What was answered for a pair stays in its *slot* for as long as the pair is near: the row of its
last answer, in which revision of the world that was, how sharp, and its *slack*: the certified
least distance then plus the travels of both bodies then. As long as slack minus travels now
exceeds a distance, the pair is farther apart than that, without any look at it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.broadphase import (
    NOBODY,
    pairs_between,
    pairs_within,
    put_code,
    put_in,
    room_for,
)
from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.filter_matrix import may_report
from drake_geom_ros.geometry._proximity.filter_state import FilterState
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import PAIR_WIDTH
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.records import Memory, Plain
from drake_geom_ros.geometry._proximity.world import World

Indices = NDArray[np.int64]

UPDATES_AHEAD = 16.0  # that a margin is made for; fewer lists, more pairs to look at
WIDEST_MARGIN = 0.5  # of a body's radius
LEAST_AHEAD = 4.0  # updates that a margin has to last: it costs as much as a list or two
PATIENCE = 64  # updates without a move after which a body counts as resting


class NearList:
    """The unfiltered pairs of a world within ``reach``, sorted, with a slot each."""

    def __init__(self, world: World) -> None:
        n = world.geometry_count
        self.reach = -1.0  # [m] the list holds every pair this near; below 0: not made yet
        self.considered = 0  # pairs before the filters
        self.has_kernels = False  # those of its pairs are compiled
        self.pairs: Indices = np.zeros((0, 2), dtype=np.int64)  # (k, 2) rows of the world, i < j
        self.slots: Indices = np.zeros(0, dtype=np.int64)  # (k,)
        self._codes: Indices = np.zeros(0, dtype=np.int64)  # (k,) i n + j
        self._version = -1, -1  # of the filters, and of who waits for a first pose
        self.filter_seconds = 0.0  # [s] that the filters took when the list was made
        self._lowers = np.zeros((n, 3))  # (n, 3) [m] the boxes for which the list stands
        self._uppers = np.zeros((n, 3))
        self._checked = 0  # the revision in which everybody was last seen in them
        self._wanted = 0.0  # [m] the largest distance asked for since the list was made
        self._planes = np.flatnonzero(world.geometries.types == HALF_SPACE)
        self._is_plane = world.geometries.types == HALF_SPACE
        self._active = ~world.anchored & ~self._is_plane
        self._resting_within = -1.0  # [m] what the resting pairs were made for
        self._boxes = room_for(n)  # of those that move
        self._resting = room_for(n)
        self._resting_codes: Indices = self._codes
        self._paddings = np.zeros(n)
        self._rows: Indices = np.zeros(n, dtype=np.int64)
        self._found: Indices = np.zeros(64 + 8 * n, dtype=np.int64)  # room for codes
        self._filter_slots: tuple[int, Indices] = -1, self._rows
        self._sorted_at = 0  # the revision in which the resting ones were sorted
        self._active_when_sorted = 0
        self._made = 0  # the revision of the list
        # The slots (m,), in use and free; see ``Memory``.
        self.answers = np.zeros((0, PAIR_WIDTH))
        self.slacks = np.zeros(0)
        self.seen: Indices = np.zeros(0, dtype=np.int64)
        self.gaps = np.zeros(0)
        self.memory: Plain = tuple(Memory(self.answers, self.slacks, self.seen, self.gaps))
        self._free: Indices = np.zeros(0, dtype=np.int64)
        self._free_count = 0

    def bring_up_to_date(self, world: World, filters: FilterState, distance: float) -> bool:
        """Make the list hold every unfiltered pair within ``distance`` [m]; tell if it was made.

        The world is up to date.
        """
        distance = max(distance, 0.0)
        self._wanted = max(self._wanted, distance)
        version = filters.version, world.placings
        stands = distance <= self.reach and version == self._version
        if stands and (self.reach == math.inf or not self._somebody_left(world)):
            return False
        if math.isinf(self._wanted):
            candidates = _all_pairs(world)
        else:
            candidates = self._near_codes(world, self._wanted)
        self.reach, self._wanted, self._version = self._wanted, distance, version
        self._take(world, filters, candidates)
        return True

    def _somebody_left(self, world: World) -> bool:
        """Tell whether a body is no longer in the box that the list was made for."""
        since, self._checked = self._checked, world.revision
        posed = world.movable, world.stamps, world.p_WGs, world.half_extents
        return since != world.revision and bool(_left(since, *posed, self._lowers, self._uppers))

    # Which pairs.

    def _near_codes(self, world: World, distance: float) -> Indices:
        """Return the codes (k,) of the pairs whose padded boxes overlap, in any order."""
        posed = world.p_WGs, world.half_extents
        count, idle = _pad(
            self._active,
            self._is_plane,
            world.stamps,
            self._made,
            world.revision - PATIENCE,
            world.paces,
            world.outer_radii,
            distance,
            *posed,
            self._lowers,
            self._uppers,
            self._paddings,
            self._rows,
        )
        self._made = self._checked = world.revision
        if distance > self._resting_within or self._many_have_changed(world, count, idle):
            count = self._settle(world, distance)
        put_in(self._boxes, self._rows[:count], *posed, self._paddings)
        n = world.geometry_count
        others = self._resting, self._resting_codes, self._active, NOBODY
        planes = self._planes, self._is_plane, world.anchored
        return self._whole(lambda codes: _find(self._boxes, *others, *planes, n, codes))

    def _whole(self, find: Callable[[Indices], int]) -> Indices:
        """Return the codes that are found, again with more room if it was too little."""
        count = find(self._found)
        if count > len(self._found):
            self._found = np.zeros(count + count // 4, dtype=np.int64)
            find(self._found)
        return self._found[:count]

    def _many_have_changed(self, world: World, active: int, idle: int) -> bool:
        """Tell whether the division into active and resting is out of date."""
        woken = active - self._active_when_sorted
        if 8 * woken > len(self._active) + 64:
            return True
        return world.revision - self._sorted_at >= PATIENCE and 2 * (active - idle) < active

    def _settle(self, world: World, distance: float) -> int:
        """Put those that rest into cells, and pair them, for distances up to this one.

        Return how many do not rest; their rows are put in order.
        """
        if world.revision >= PATIENCE:
            self._active &= ~_idle(world)
        n, resting = world.geometry_count, ~self._active & ~self._is_plane
        posed = world.p_WGs, world.half_extents, np.full(n, 0.5 * distance)
        loose, fixed = resting & ~world.anchored, resting & world.anchored
        # Two that are anchored are no pair.
        put_in(self._boxes, np.flatnonzero(loose), *posed)
        put_in(self._resting, np.flatnonzero(fixed), *posed)
        self._resting_codes = self._whole(
            lambda codes: pairs_between(
                self._boxes,
                self._resting,
                NOBODY,
                n,
                codes,
                pairs_within(self._boxes, NOBODY, n, codes, 0),
            )
        ).copy()
        put_in(self._resting, np.flatnonzero(resting), *posed)
        self._resting_within = distance
        self._sorted_at = world.revision
        active = np.flatnonzero(self._active)
        self._rows[: len(active)] = active
        self._active_when_sorted = len(active)
        return len(active)

    # What is known of each.

    def _take(self, world: World, filters: FilterState, candidates: Indices) -> None:
        """Make the list of these codes, less the filtered ones; who stays keeps the slot."""
        self.has_kernels = False
        start = time.perf_counter()
        n = world.geometry_count
        waiting = NOBODY if world.is_whole else world.waiting
        codes = np.sort(candidates)
        self.considered, count = _keep(codes, n, waiting, *self._bits(world, filters))
        self.filter_seconds = time.perf_counter() - start
        codes = codes[:count]
        if count > len(self.answers):
            self._grow_slots(count + count // 4 + 64)
        slots, pairs = np.empty(count, dtype=np.int64), np.empty((count, 2), dtype=np.int64)
        free = self._free, self._free_count
        self._free_count = _carry(
            self._codes, self.slots, codes, slots, n, pairs, *free, self.memory
        )
        self._codes, self.slots, self.pairs = codes, slots, pairs

    def _bits(self, world: World, filters: FilterState) -> tuple[Any, ...]:
        """Return what tells whether a pair of rows is filtered."""
        if self._filter_slots[0] != filters.version:
            self._filter_slots = filters.version, filters.slots(world.geometries.ids)
        return self._filter_slots[1], *filters.matrix

    def _grow_slots(self, capacity: int) -> None:
        """Make room for more pairs; the slots in use keep what they hold."""
        more = capacity - len(self.seen)
        self.answers = np.concatenate((self.answers, np.zeros((more, PAIR_WIDTH))))
        self.slacks = np.concatenate((self.slacks, np.zeros(more)))
        self.seen = np.concatenate((self.seen, np.zeros(more, dtype=np.int64)))
        self.gaps = np.concatenate((self.gaps, np.zeros(more)))
        free = np.empty(capacity, dtype=np.int64)
        free[:more] = np.arange(capacity - 1, capacity - more - 1, -1)
        free[more : more + self._free_count] = self._free[: self._free_count]
        self._free, self._free_count = free, self._free_count + more
        self.memory = tuple(Memory(self.answers, self.slacks, self.seen, self.gaps))


def _idle(world: World) -> NDArray[np.bool_]:
    """Return which bodies have not moved for a while."""
    idle: NDArray[np.bool_] = world.stamps <= world.revision - PATIENCE
    return idle


def _all_pairs(world: World) -> Indices:
    """Return the code of every pair but those of two anchored bodies or of two half spaces."""
    i, j = np.triu_indices(world.geometry_count, k=1)
    plane = world.geometries.types == HALF_SPACE
    apart = ~(world.anchored[i] & world.anchored[j]) & ~(plane[i] & plane[j])
    codes: Indices = i[apart] * world.geometry_count + j[apart]
    return codes


@compiled
def _pad(  # type: ignore[no-untyped-def]
    active,
    is_plane,
    stamps,
    made,
    resting_since,
    paces,
    outer,
    distance,
    p_WGs,
    half_extents,
    lowers,
    uppers,
    paddings,
    rows,
):
    """Wake up who has moved since the list was made, and set margins.

    Return how many are active, and how many of them have rested since a revision. ``lowers`` and
    ``uppers`` (n, 3) [m] get the boxes for which the next list stands, ``paddings`` (n,) margins
    and half the distance, and ``rows`` begins with the active ones.
    """
    count, idle, lasts = 0, 0, True
    for g in range(active.size):
        if made > 0 and stamps[g] > made and not is_plane[g]:
            active[g] = True
        if active[g]:
            rows[count] = g
            count += 1
            idle += stamps[g] <= resting_since
            lasts &= paces[g] * LEAST_AHEAD <= WIDEST_MARGIN * outer[g]
    for g in range(active.size):
        margin = 0.0
        if active[g] and lasts:
            margin = min(UPDATES_AHEAD * paces[g], WIDEST_MARGIN * outer[g])
        paddings[g] = margin + 0.5 * distance
        for k in range(3):
            reach = half_extents[g, k] + margin
            lowers[g, k], uppers[g, k] = p_WGs[g, k] - reach, p_WGs[g, k] + reach
    return count, idle


@compiled
def _find(  # type: ignore[no-untyped-def]
    boxes, resting, resting_codes, active, nobody, planes, is_plane, anchored, n, codes
):
    """Fill in the codes of all near pairs; return how many there are, beyond the room too."""
    count = pairs_within(boxes, nobody, n, codes, 0)
    # Who woke up since the resting ones were put into their cells is in both.
    count = pairs_between(boxes, resting, active, n, codes, count)
    for k in range(resting_codes.size):
        i, j = resting_codes[k] // n, resting_codes[k] % n
        if not (active[i] or active[j]):
            count = put_code(codes, count, i, j, n)
    # Every body is paired with every plane, so that these may move as they like.
    for plane in planes:
        for g in range(n):
            if not (is_plane[g] or (anchored[g] and anchored[plane])):
                count = put_code(codes, count, plane, g, n)
    return count


@compiled
def _keep(codes, n, waiting, slots, bits, bodies):  # type: ignore[no-untyped-def]
    """Keep the sorted codes of pairs that may be reported, in front; return how many were and are.

    Those that stand there twice, or wait for a pose, are not counted; ``waiting`` is empty where
    nobody does.
    """
    considered, count, last = 0, 0, -1
    for k in range(codes.size):
        if codes[k] == last:
            continue
        last = codes[k]
        i, j = last // n, last % n
        if waiting.size > 0 and (waiting[i] or waiting[j]):
            continue
        considered += 1
        if may_report(bits, bodies, slots[i], slots[j]):
            codes[count] = last
            count += 1
    return considered, count


@compiled
def _left(since, movable, stamps, p_WGs, half_extents, lowers, uppers):  # type: ignore[no-untyped-def]
    """Tell whether the box of a body that moved after a revision sticks out of another box."""
    for g in movable:
        if stamps[g] <= since:
            continue
        for k in range(3):
            p, half = p_WGs[g, k], half_extents[g, k]
            if not (p - half >= lowers[g, k] and p + half <= uppers[g, k]):
                return True
    return False


@compiled
def _carry(  # type: ignore[no-untyped-def]
    old_codes, old_slots, codes, slots, n, pairs, free, free_count, memory
):
    """Give each pair its former slot or a free one, and its rows; return how many are free."""
    memory, old = Memory(*memory), 0
    for k in range(codes.size):
        slots[k] = -1
        pairs[k, 0], pairs[k, 1] = codes[k] // n, codes[k] % n
        while old < old_codes.size and old_codes[old] < codes[k]:
            free[free_count] = old_slots[old]
            free_count += 1
            old += 1
        if old < old_codes.size and old_codes[old] == codes[k]:
            slots[k] = old_slots[old]
            old += 1
    for rest in range(old, old_codes.size):
        free[free_count] = old_slots[rest]
        free_count += 1
    for k in range(codes.size):
        if slots[k] < 0:
            free_count -= 1
            slot = free[free_count]
            slots[k] = slot
            memory.answers[slot] = 0.0
            memory.slacks[slot] = -math.inf
            memory.seen[slot] = -1
    return free_count
