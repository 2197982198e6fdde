"""Which pairs are near enough to be looked at, and what is known of each, from cycle to cycle.

A list is made for a little more than the distance that is asked for: the box of each body gets a
margin of as far as the body is expected to come in some updates, and the list stands until a body
leaves its box (Verlet's neighbour list, *Physical Review* 159, 98, 1967, with margins of each
body's own). Only then the broad phase runs again, and only for the bodies that move: those that
rest were sorted, and paired among themselves, once.

What was answered for a pair stays in its *slot* for as long as the pair is near: the row of its
last answer, in which revision of the world that was, how sharp, and its *slack*: the certified
least distance then plus the travels of both bodies then. As long as slack minus travels now
exceeds a distance, the pair is farther apart than that, without any look at it.
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.broadphase import (
    Boxes,
    pairs_between,
    pairs_within,
    sorted_boxes,
    split_wide,
    widest_axis,
)
from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.filter_state import FilterState
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import PAIR_WIDTH
from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.records import Memory, Plain
from drake_geom_ros.geometry._proximity.world import World

Indices = NDArray[np.int64]

UPDATES_AHEAD = 16.0  # that a margin is made for; fewer sweeps, more pairs to look at
WIDEST_MARGIN = 0.5  # of a body's radius: who moves faster than that is swept for each time
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
        self._resting: list[Boxes] = []
        self._resting_pairs: Indices = self.pairs
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
            candidates = self._near_pairs(world, self._wanted)
        self.reach, self._wanted, self._version = self._wanted, distance, version
        self._take(world, filters, candidates)
        return True

    def _somebody_left(self, world: World) -> bool:
        """Tell whether a body is no longer in the box that the list was made for."""
        since, self._checked = self._checked, world.revision
        posed = world.movable, world.stamps, world.p_WGs, world.half_extents
        return since != world.revision and bool(_left(since, *posed, self._lowers, self._uppers))

    # Which pairs.

    def _near_pairs(self, world: World, distance: float) -> Indices:
        """Return the pairs (k, 2) whose padded boxes overlap, in any order."""
        # Every body is paired with every plane, so that these may move as they like.
        self._active |= (world.stamps > self._made) & ~self._is_plane & (self._made > 0)
        margins = np.minimum(UPDATES_AHEAD * world.paces, WIDEST_MARGIN * world.outer_radii)
        margins[(world.paces >= margins) | ~self._active] = 0.0
        reaches = world.half_extents + margins[:, None]
        self._lowers, self._uppers = world.p_WGs - reaches, world.p_WGs + reaches
        self._made = self._checked = world.revision
        if distance > self._resting_within or self._many_have_changed(world):
            self._sort_resting(world, distance)
        paddings = margins + 0.5 * distance
        axis = self._resting[0].axis
        active = sorted_boxes(
            axis, np.flatnonzero(self._active), world.p_WGs, world.half_extents, paddings
        )
        found = [pairs_within(active)]
        found += [pairs_between(active, boxes, self._active) for boxes in self._resting]
        stay = ~self._active[self._resting_pairs].any(axis=1)
        found.append(self._resting_pairs[stay])
        found.append(self._pairs_of_planes(world))
        return np.concatenate(found)

    def _many_have_changed(self, world: World) -> bool:
        """Tell whether the division into active and resting is out of date."""
        active = int(np.count_nonzero(self._active))
        woken = active - self._active_when_sorted
        if 8 * woken > len(self._active) + 64:
            return True
        if world.revision - self._sorted_at < PATIENCE:
            return False
        return 2 * int(np.count_nonzero(self._active & ~_idle(world))) < active

    def _sort_resting(self, world: World, distance: float) -> None:
        """Sort those that rest, and pair them among themselves, for distances up to this one."""
        if world.revision >= PATIENCE:
            self._active &= ~_idle(world)
        resting = np.flatnonzero(~self._active & ~self._is_plane)
        axis = widest_axis(world.p_WGs[~self._is_plane])
        paddings = np.full(len(self._active), 0.5 * distance)
        self._resting = [
            sorted_boxes(axis, bodies, world.p_WGs, world.half_extents, paddings)
            for bodies in split_wide(resting, world.half_extents, axis)
        ]
        loose = resting[~world.anchored[resting]]
        fixed = np.zeros(len(self._active), dtype=np.bool_)
        fixed[loose] = True
        boxes = sorted_boxes(axis, loose, world.p_WGs, world.half_extents, paddings)
        found = [pairs_within(boxes)]
        found += [pairs_between(boxes, others, fixed) for others in self._resting]
        self._resting_pairs = np.concatenate(found)
        self._resting_within = distance
        self._sorted_at = world.revision
        self._active_when_sorted = int(np.count_nonzero(self._active))

    def _pairs_of_planes(self, world: World) -> Indices:
        """Return every pair of a half space and a body, but of two that are anchored."""
        found = [np.zeros((0, 2), dtype=np.int64)]
        for plane in self._planes:
            apart = ~self._is_plane & ~(world.anchored & world.anchored[plane])
            bodies = np.flatnonzero(apart)
            pairs = np.column_stack((np.full_like(bodies, plane), bodies))
            found.append(np.sort(pairs, axis=1))
        return np.concatenate(found)

    # What is known of each.

    def _take(self, world: World, filters: FilterState, candidates: Indices) -> None:
        """Make the list of these pairs, less the filtered ones; who stays keeps the slot."""
        if not world.is_whole:
            candidates = candidates[~world.waiting[candidates].any(axis=1)]
        self.considered, self.has_kernels = len(candidates), False
        start = time.perf_counter()
        of = filters.slots(world.geometries.ids)
        candidates = candidates[filters.mask(of[candidates[:, 0]], of[candidates[:, 1]])]
        self.filter_seconds = time.perf_counter() - start
        n = world.geometry_count
        codes = candidates[:, 0] * n + candidates[:, 1]
        codes.sort()
        slots = np.empty_like(codes)
        if len(codes) > len(self.answers):
            self._grow_slots(len(codes) + len(codes) // 4 + 64)
        free = self._free, self._free_count
        self._free_count = _carry(self._codes, self.slots, codes, slots, *free, self.memory)
        self._codes, self.slots = codes, slots
        self.pairs = np.column_stack(np.divmod(codes, n)) if n else candidates

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
    """Return every pair but those of two anchored bodies or of two half spaces."""
    i, j = np.triu_indices(world.geometry_count, k=1)
    plane = world.geometries.types == HALF_SPACE
    apart = ~(world.anchored[i] & world.anchored[j]) & ~(plane[i] & plane[j])
    return np.column_stack((i[apart], j[apart])).astype(np.int64)


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
    old_codes, old_slots, codes, slots, free, free_count, memory
):
    """Give each pair its former slot or a free one; return how many slots are free then."""
    memory, old = Memory(*memory), 0
    for k in range(codes.size):
        slots[k] = -1
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
