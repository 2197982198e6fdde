"""Which pairs are near enough to be looked at, and what is known of each, from cycle to cycle.

A list is made for a little more than the cutoff that is asked for: the box of each body gets a
skin of as far as the body is expected to come in some updates, and the list stands until a body
leaves its box (Verlet's neighbour list, *Physical Review* 159, 98, 1967, with skins of each
body's own). Only then the broad phase runs again, and only for the bodies that move. Where a body
is so fast that no skin lasts, nobody gets one: the list is made for each update, and has no pair
too many.

What was answered for a pair stays in its *slot* for as long as the pair is near: the row of its
last answer, in which revision of the world that was, how sharp, and its *slack*: the certified
least distance then plus the travels of both bodies then. As long as slack minus travels now
exceeds a cutoff, the pair is farther apart than that, without any look at it.

The work is done by ``making``; here are the arrays that it works on, which grow.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import MEMORY_WIDTH, SLOT_WIDTH
from drake_geom_ros.geometry._proximity.kinds import CONVEX, HALF_SPACE
from drake_geom_ros.geometry._proximity.near.arrays import (
    CONSIDERED,
    FREE,
    HAS_KERNELS,
    LACKS_CODES,
    LACKS_GRIDS,
    LACKS_RESTING,
    LENGTHS,
    LIST_CUTOFF,
    MADE,
    NEEDED,
    NUMBERS,
    PAIRS,
    RESTING_CUTOFF,
    FilterArrays,
    ListArrays,
    filters_of,
    list_of,
)
from drake_geom_ros.geometry._proximity.near.box_lanes import empty_sides
from drake_geom_ros.geometry._proximity.near.by_grids import BY_GRIDS, compile_by_grids
from drake_geom_ros.geometry._proximity.near.grids import room_for
from drake_geom_ros.geometry._proximity.near.making import bring_up_to_date
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.runtime.handles import Handle, handle_of
from drake_geom_ros.geometry._proximity.world.arrays import world_of
from drake_geom_ros.geometry._proximity.world.world import World

Indices = NDArray[np.int64]

MOST_REMEMBERED = 128  # geometries, all pairs of which have room to remember a polytope


class NeighbourList:
    """The unfiltered pairs of a world within the cutoff, sorted, with a slot each."""

    def __init__(self, world: World, unlimited: bool = False) -> None:
        n = world.geometry_count
        is_plane = world.geometries.types == HALF_SPACE
        hulls = np.count_nonzero(world.geometries.types == CONVEX)
        # Of all pairs that there are, in a large scene, few overlap, and most are no hulls.
        remembers = hulls > 1 and (n <= MOST_REMEMBERED or not unlimited)
        codes = np.zeros(64 + 8 * n, dtype=np.int64)
        rows, none = np.zeros(n, dtype=np.int64), np.zeros(0, dtype=np.int64)
        self.arrays = ListArrays(
            numbers=np.zeros(NUMBERS, dtype=np.int64),
            lengths=np.zeros(LENGTHS),
            is_plane=is_plane,
            active=~world.anchored & ~is_plane,
            lowers=np.zeros((n, 3)),
            uppers=np.zeros((n, 3)),
            paddings=np.zeros(n),
            rest_paddings=np.zeros(n),
            rows=rows,
            tally=np.zeros(n + 1, dtype=np.int64),
            sides=empty_sides(n),
            planes=np.flatnonzero(is_plane),
            nobody=np.zeros(0, dtype=np.bool_),
            found=codes,
            sorting=codes.copy(),
            resting=np.zeros(1, dtype=np.int64),
            codes=none,
            pairs=np.zeros((0, 2), dtype=np.int64),
            slots=none,
            new_slots=none,
            free=none,
            hits=none,
            by_grids=BY_GRIDS,
            memory=np.zeros((0, SLOT_WIDTH + (MEMORY_WIDTH if remembers else 0))),
        )
        self.arrays.lengths[[LIST_CUTOFF, RESTING_CUTOFF]] = -1.0
        self._boxes = room_for(n), room_for(n)  # of those that move, and of those that rest
        self._told: tuple[FilterState | None, int] = None, -1
        self._filters = FilterArrays(rows, *FilterState().matrix)
        self._hand_over()

    def _hand_over(self) -> None:
        """Make the handles of the arrays that are there now."""
        moving, resting = (handle_of(boxes) for boxes in self._boxes)
        self.handles = handle_of(self.arrays), moving, resting, handle_of(self._filters)

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self.arrays = self.arrays._replace(by_grids=BY_GRIDS)  # of this process
        self._hand_over()  # the arrays of a copy are elsewhere

    @property
    def list_cutoff(self) -> float:
        """The list holds every pair this near [m]; below 0 it was never made."""
        return float(self.arrays.lengths[LIST_CUTOFF])

    @property
    def considered(self) -> int:
        """The number of pairs before the filters."""
        return int(self.arrays.numbers[CONSIDERED])

    @property
    def count(self) -> int:
        """The number of pairs."""
        return int(self.arrays.numbers[PAIRS])

    @property
    def pairs(self) -> Indices:
        """Rows (k, 2) of the world, i < j, ascending, until the list is made anew."""
        return self.arrays.pairs[: self.count]

    @property
    def slots(self) -> Indices:
        """The slot of each pair (k,)."""
        return self.arrays.slots[: self.count]

    @property
    def memory(self) -> NDArray[np.float64]:
        """What is known of the pairs, by slot; see ``pairs.slots.empty_memory``."""
        return self.arrays.memory

    def know_kernels(self) -> None:
        """Note that the kernels of all pairs are compiled."""
        self.arrays.numbers[HAS_KERNELS] = 1

    def bring_up_to_date(self, world: World, filters: FilterState, cutoff: float) -> bool:
        """Make the list hold every unfiltered pair within ``cutoff`` [m]; tell if it was made.

        The world is up to date.
        """
        self.look_at(world, filters)
        state = world.revision, filters.version, world.placings
        while (told := _bring_up_to_date(world.handle, *self.handles, state, cutoff)) > MADE:
            self.make_room(told)
        return bool(told == MADE)

    def look_at(self, world: World, filters: FilterState) -> None:
        """Have the filters handed over as they are now."""
        known, version = self._told
        if known is filters and version == filters.version:
            return
        slots = np.ascontiguousarray(filters.slots(world.geometries.ids), dtype=np.int64)
        self._filters = FilterArrays(slots, *filters.matrix)
        self._told = filters, filters.version
        self.handles = *self.handles[:3], handle_of(self._filters)

    def make_room(self, lacking: int) -> None:
        """Give what ``making`` tells that it lacks; nothing that is held is lost."""
        if lacking == LACKS_GRIDS:
            compile_by_grids()
            return
        needed = int(self.arrays.numbers[NEEDED])
        capacity = needed + needed // 4
        if lacking == LACKS_CODES:
            room, sorting = (np.zeros(capacity + 1, dtype=np.int64) for _ in range(2))
            self.arrays = self.arrays._replace(found=room, sorting=sorting)
        elif lacking == LACKS_RESTING:
            self.arrays = self.arrays._replace(resting=np.zeros(capacity + 1, dtype=np.int64))
        else:
            self._grow_slots(capacity + 64)
        self._hand_over()

    def _grow_slots(self, capacity: int) -> None:
        """Make room for more pairs; the slots in use keep what they hold."""
        arrays = self.arrays
        more = capacity - len(arrays.slots)
        grown = {}
        for name in ('codes', 'pairs', 'slots', 'new_slots', 'hits', 'memory'):
            array = getattr(arrays, name)
            grown[name] = np.concatenate((array, np.zeros((more, *array.shape[1:]), array.dtype)))
        free = np.empty(capacity, dtype=np.int64)
        free[:more] = np.arange(capacity - 1, capacity - more - 1, -1)
        free[more : more + arrays.numbers[FREE]] = arrays.free[: arrays.numbers[FREE]]
        arrays.numbers[FREE] += more
        self.arrays = arrays._replace(free=free, **grown)


@compiled
def _bring_up_to_date(
    world: Handle,
    near: Handle,
    boxes: Handle,
    resting: Handle,
    filters: Handle,
    moment: tuple[int, int, int],
    cutoff: float,
) -> int:
    """Do what ``making.bring_up_to_date`` does, by handles.

    The ``moment`` is told by the world's revision, the filters' version, and its placings.
    """
    return bring_up_to_date(
        list_of(near),
        world_of(world),
        (near, world, boxes, resting),
        filters_of(filters),
        *moment,
        cutoff,
    )
