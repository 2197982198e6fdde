"""The near pairs of many bodies, found by grids: a part of the making of a list.

Boxes go into hashed grids (``grids``), and those that rest are put there, and paired among
themselves, once. All of it is called by its address.
"""

from __future__ import annotations

from numba import types

from drake_geom_ros.geometry._proximity.near.arrays import (
    ACTIVE_THEN,
    FOUND,
    LACKS_RESTING,
    NEEDED,
    RESTING,
    RESTING_CUTOFF,
    SETTLED_AT,
    ListArrays,
    list_of,
)
from drake_geom_ros.geometry._proximity.near.grid_pairs import pairs_between, pairs_within
from drake_geom_ros.geometry._proximity.near.grids import Boxes, put_code, put_in, rows_of
from drake_geom_ros.geometry._proximity.near.keeping import sort
from drake_geom_ros.geometry._proximity.near.skins import PATIENCE
from drake_geom_ros.geometry._proximity.runtime.addresses import address_table, caller
from drake_geom_ros.geometry._proximity.runtime.arrays import Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import address_of, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle, taker
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of

_boxes_of = taker(Boxes)

_handle = types.int64[::1]
_SIGNATURE = types.void(*[_handle] * 4, types.int64, types.float64, types.int64, types.int64)
call_by_grids = caller(_SIGNATURE)
BY_GRIDS = address_table(1)  # compiled once a process, when first needed


def compile_by_grids() -> None:
    """Compile ``find_by_grids``, or load it from the cache."""
    if not BY_GRIDS[0]:
        BY_GRIDS[0] = address_of(find_by_grids, _SIGNATURE)


@compiled
def find_by_grids(
    near_handle: Handle,
    world_handle: Handle,
    boxes_handle: Handle,
    resting_handle: Handle,
    revision: int,
    list_cutoff: float,
    active: int,
    idle: int,
) -> None:
    """Write the number of near pairs to FOUND, and their codes; minus LACKS_RESTING without room.

    The first four are handles. Codes are in order, unless there are more than there is room for.
    """
    near, world = list_of(near_handle), world_of(world_handle)
    boxes, resting = _boxes_of(boxes_handle), _boxes_of(resting_handle)
    n = near.is_plane.size
    changed = _many_have_changed(near.numbers, n, revision, active, idle)
    if list_cutoff > near.lengths[RESTING_CUTOFF] or changed:
        if not _settle(near, world, boxes, resting, revision, list_cutoff):
            near.numbers[FOUND] = -LACKS_RESTING
            return
        active = near.numbers[ACTIVE_THEN]
    rows = part(near.rows, 0, active)
    put_in(boxes, rows, world.p_WGs, world.half_extents, near.paddings)
    count = _find(near, world, boxes, resting)
    if count < near.found.size:
        sort(part(near.found, 0, count), near.sorting, near.tally, n)
    near.numbers[FOUND] = count


@inlined
def _find(near: ListArrays, world: WorldArrays, boxes: Boxes, resting: Boxes) -> int:
    """Do what ``look_at_all`` does by grids; codes come in any order, some of them twice."""
    n, found = near.is_plane.size, near.found
    count = pairs_within(boxes, near.nobody, found, 0)
    # Who woke up since the resting ones were put into their cells is in both.
    count = pairs_between(boxes, resting, near.active, found, count)
    for k in range(near.numbers[RESTING]):
        i, j = rows_of(near.resting[k])
        if not (near.active[i] or near.active[j]):
            count = put_code(found, count, i, j, True)
    for k in range(near.planes.size):
        plane = near.planes[k]
        for g in range(n):
            fixed = world.frames[plane] == 0 and world.frames[g] == 0
            if not (near.is_plane[g] or fixed):
                count = put_code(found, count, plane, g, True)
    return count


@inlined
def _many_have_changed(
    numbers: Indices, bodies: int, revision: int, active: int, idle: int
) -> bool:
    """Tell whether the division into active and resting is out of date."""
    if 8 * (active - numbers[ACTIVE_THEN]) > bodies + 64:
        return True
    return revision - numbers[SETTLED_AT] >= PATIENCE and 2 * (active - idle) < active


@compiled
def _settle(
    near: ListArrays,
    world: WorldArrays,
    boxes: Boxes,
    resting: Boxes,
    revision: int,
    cutoff: float,
) -> bool:
    """Put those that rest into cells, and pair them, for distances up to this one.

    The rows of those that do not rest are put in order. Return False, and count the pairs, where
    there is no room for these.
    """
    numbers, n = near.numbers, near.is_plane.size
    padding = part(near.rest_paddings, 0, n)
    padding[:] = 0.5 * cutoff
    posed = world.p_WGs, world.half_extents, padding
    loose, fixed = 0, 0
    for g in range(n):
        if revision >= PATIENCE and world.stamps[g] <= revision - PATIENCE:
            near.active[g] = False
        if not (near.active[g] or near.is_plane[g]) and world.frames[g] != 0:
            near.rows[loose] = g
            loose += 1
    put_in(boxes, part(near.rows, 0, loose), *posed)
    for g in range(n):
        if not near.is_plane[g] and world.frames[g] == 0:
            near.rows[fixed] = g
            fixed += 1
    # Two that are anchored are no pair.
    put_in(resting, part(near.rows, 0, fixed), *posed)
    count = pairs_within(boxes, near.nobody, near.resting, 0)
    count = pairs_between(boxes, resting, near.nobody, near.resting, count)
    if count >= near.resting.size:
        numbers[NEEDED], near.lengths[RESTING_CUTOFF] = count, -1.0  # to be done again
        return False
    rest, active = 0, 0
    for g in range(n):
        if not (near.active[g] or near.is_plane[g]):
            near.rows[rest] = g
            rest += 1
    put_in(resting, part(near.rows, 0, rest), *posed)
    for g in range(n):
        if near.active[g]:
            near.rows[active] = g
            active += 1
    numbers[RESTING], numbers[SETTLED_AT], numbers[ACTIVE_THEN] = count, revision, active
    near.lengths[RESTING_CUTOFF] = cutoff
    return True
