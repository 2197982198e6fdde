"""Neighbour list: the candidate pairs of a world, and the last answer of each, across cycles.

A list is made for a little more than the requested cutoff: the box of each body gets a skin as
wide as the body is expected to move in some updates, and the list is valid until a body leaves its
box (Verlet's neighbour list, *Physical Review* 159, 98, 1967, with a skin for each body). Only
then does the broad phase run again, and only for moving bodies. If a body is too fast for a skin
to last, no body gets one: the list is made for each update, and has no superfluous pair.

The last answer of a pair stays in its *slot* for as long as the pair is listed: the row of the
answer, the revision of the world, the level gap, and the *slack*, which is the certified least
distance plus the travels of both bodies at that time. While slack minus current travels exceeds a
cutoff, the pair is certified to be beyond it.

``making`` does the work; this file owns the arrays, which grow.
"""

from __future__ import annotations

from typing import Any

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
from drake_geom_ros.geometry._proximity.near.grids import (
    Boxes,
    room_for,
)
from drake_geom_ros.geometry._proximity.near.making import bring_up_to_date
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.runtime.handles import Handle, handle_of
from drake_geom_ros.geometry._proximity.world.arrays import world_of
from drake_geom_ros.geometry._proximity.world.world import World

Indices = NDArray[np.int64]

ROOM_FOR_MORE = 8  # of the geometries: this part of them fits in without another allocation
MOST_REMEMBERED = 128  # geometries up to which all pairs get memory for a polytope

_OF_BODIES = (
    *('lowers', 'uppers', 'paddings', 'rest_paddings', 'rows', 'tally', 'sides'),
    *('candidates', 'sorting'),
)
OF_PAIRS = ('codes', 'pairs', 'slots', 'new_slots', 'hits', 'memory')


class NeighbourList:
    """The unfiltered pairs of a world within the cutoff, sorted, each with a slot."""

    arrays: ListArrays
    boxes: tuple[Boxes, Boxes]  # of moving and of resting bodies
    handles: tuple[
        Handle, Handle, Handle, Handle
    ]  # of the arrays, of both boxes, and of the filters

    def __init__(
        self, world: World, unlimited: bool = False, former: NeighbourList | None = None
    ) -> None:
        """Make a list of no pairs; ``former``, which is not used any more, gives it its room.

        A list with a former one has no handle of its arrays until ``replace`` is called.
        """
        self.unlimited = unlimited
        n = world.geometry_count
        is_plane = world.geometries.types == HALF_SPACE
        hulls = np.count_nonzero(world.geometries.types == CONVEX)
        # Of all pairs of a large scene few overlap, and most are not of hulls.
        remembers = hulls > 1 and (n <= MOST_REMEMBERED or not unlimited)
        none = np.zeros(0, dtype=np.int64)
        if former is not None and n <= len(former.arrays.rows):
            of_bodies = {name: getattr(former.arrays, name) for name in _OF_BODIES}
            self.boxes, (moving, resting) = former.boxes, former.handles[1:3]
        else:
            room = n + n // ROOM_FOR_MORE
            of_bodies = _room_for_bodies(room)
            self.boxes = room_for(room), room_for(room)
            moving, resting = map(handle_of, self.boxes)
        self.arrays = ListArrays(
            numbers=np.zeros(NUMBERS, dtype=np.int64),
            lengths=np.zeros(LENGTHS),
            is_plane=is_plane,
            active=~world.anchored & ~is_plane,
            planes=np.flatnonzero(is_plane),
            no_bodies=np.zeros(0, dtype=np.bool_),
            resting=np.zeros(1, dtype=np.int64),
            codes=none,
            pairs=np.zeros((0, 2), dtype=np.int64),
            slots=none,
            new_slots=none,
            free=none,
            hits=none,
            by_grids=BY_GRIDS,
            memory=np.zeros((0, SLOT_WIDTH + (MEMORY_WIDTH if remembers else 0))),
            **of_bodies,
        )
        self.arrays.lengths[[LIST_CUTOFF, RESTING_CUTOFF]] = -1.0
        self._seen_filters: tuple[FilterState | None, int] = None, -1  # with their version
        if former is None:
            self._filters = FilterArrays(self.arrays.rows, *FilterState().matrix)
            self.handles = handle_of(self.arrays), moving, resting, handle_of(self._filters)
        else:
            self._filters = former._filters
            self.handles = former.handles[0], moving, resting, former.handles[3]

    def replace(self, **arrays: NDArray[Any]) -> None:
        """Replace arrays by others, which handles of the list then refer to."""
        self.arrays = self.arrays._replace(**arrays)
        self.handles = handle_of(self.arrays), *self.handles[1:]

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self.arrays = self.arrays._replace(by_grids=BY_GRIDS)  # of this process
        # The arrays of a copy are elsewhere.
        moving, resting = map(handle_of, self.boxes)
        self.handles = handle_of(self.arrays), moving, resting, handle_of(self._filters)

    @property
    def list_cutoff(self) -> float:
        """The list has every pair within this distance [m]; below 0 it was never made."""
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
        """Rows (k, 2) of the world, i < j, ascending; valid until the list is made again."""
        return self.arrays.pairs[: self.count]

    @property
    def slots(self) -> Indices:
        """The slot of each pair (k,)."""
        return self.arrays.slots[: self.count]

    @property
    def memory(self) -> NDArray[np.float64]:
        """Last answers of the pairs, by slot; see ``pairs.slots.empty_memory``."""
        return self.arrays.memory

    def know_kernels(self) -> None:
        """Mark the kernels of all pairs as compiled."""
        self.arrays.numbers[HAS_KERNELS] = 1

    def bring_up_to_date(self, world: World, filters: FilterState, cutoff: float) -> bool:
        """Ensure that the list has every unfiltered pair within ``cutoff`` [m].

        Return whether the list was made again. The world has to be up to date.
        """
        self.look_at(world, filters)
        state = world.revision, filters.version, world.placings
        while (code := _bring_up_to_date(world.handle, *self.handles, state, cutoff)) > MADE:
            self.make_room(code)
        return bool(code == MADE)

    def look_at(self, world: World, filters: FilterState) -> None:
        """Make the handle of the filters again if they changed."""
        seen, version = self._seen_filters
        if seen is filters and version == filters.version:
            return
        slots = np.ascontiguousarray(filters.slots(world.geometries.ids), dtype=np.int64)
        self._filters = FilterArrays(slots, *filters.matrix)
        self._seen_filters = filters, filters.version
        self.handles = *self.handles[:3], handle_of(self._filters)

    def make_room(self, lacking: int) -> None:
        """Provide what ``making`` lacks, by its code; the content of arrays is preserved."""
        if lacking == LACKS_GRIDS:
            compile_by_grids()
            return
        needed = int(self.arrays.numbers[NEEDED])
        capacity = needed + needed // 4
        if lacking == LACKS_CODES:
            candidates, sorting = (np.zeros(capacity + 1, dtype=np.int64) for _ in range(2))
            self.replace(candidates=candidates, sorting=sorting)
        elif lacking == LACKS_RESTING:
            self.replace(resting=np.zeros(capacity + 1, dtype=np.int64))
        else:
            self._grow_slots(capacity + 64)

    def _grow_slots(self, capacity: int) -> None:
        """Grow the capacity for pairs; slots in use retain their content."""
        arrays = self.arrays
        more = capacity - len(arrays.slots)
        grown = {}
        for name in OF_PAIRS:
            array = getattr(arrays, name)
            grown[name] = np.concatenate((array, np.zeros((more, *array.shape[1:]), array.dtype)))
        free = np.empty(capacity, dtype=np.int64)
        free[:more] = np.arange(capacity - 1, capacity - more - 1, -1)
        free[more : more + arrays.numbers[FREE]] = arrays.free[: arrays.numbers[FREE]]
        arrays.numbers[FREE] += more
        self.replace(free=free, **grown)


def _room_for_bodies(room: int) -> dict[str, Any]:
    """Return the arrays of a list that only a query's own steps read, for so many bodies."""
    codes = np.zeros(64 + 8 * room, dtype=np.int64)
    return {
        'lowers': np.zeros((room, 3)),
        'uppers': np.zeros((room, 3)),
        'paddings': np.zeros(room),
        'rest_paddings': np.zeros(room),
        'rows': np.zeros(room, dtype=np.int64),
        'tally': np.zeros(room + 1, dtype=np.int64),
        'sides': empty_sides(room),
        'candidates': codes,
        'sorting': codes.copy(),
    }


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
    """Call ``making.bring_up_to_date`` with handles.

    The ``moment`` is the world's revision, the filters' version, and the world's placings.
    """
    return bring_up_to_date(
        list_of(near),
        world_of(world),
        (near, world, boxes, resting),
        filters_of(filters),
        *moment,
        cutoff,
    )
