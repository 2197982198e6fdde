"""Broad phase by hashed grids, for many bodies: the candidate pairs of a neighbour list.

Boxes are put into hashed grids (``grids``). Resting bodies are put there, and paired with each
other, only once. Bodies that wait for a pose are in no grid: all of them are at the origin, where
any two would be a pair. All of it is called by address.
"""

from __future__ import annotations

from numba import types

from drake_geom_ros.geometry._proximity.near.arrays import (
    ACTIVE_THEN,
    CANDIDATE_COUNT,
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
BY_GRIDS = address_table(1)  # compiled once per process, when first needed


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
    """Write the codes of candidate pairs, and their number to CANDIDATE_COUNT.

    The number is -LACKS_RESTING where the array of resting pairs is too small. Codes are sorted
    unless they do not fit. The first four arguments are handles.
    """
    near, world = list_of(near_handle), world_of(world_handle)
    boxes, resting = _boxes_of(boxes_handle), _boxes_of(resting_handle)
    n = near.is_plane.size
    changed = _many_have_changed(near.numbers, n, revision, active, idle)
    if list_cutoff > near.lengths[RESTING_CUTOFF] or changed:
        if not _settle(near, world, boxes, resting, revision, list_cutoff):
            near.numbers[CANDIDATE_COUNT] = -LACKS_RESTING
            return
        active = near.numbers[ACTIVE_THEN]
    rows = part(near.rows, 0, active)
    put_in(boxes, rows, world.p_WGs, world.half_extents, near.paddings)
    count = _find(near, world, boxes, resting)
    if count < near.candidates.size:
        sort(part(near.candidates, 0, count), near.sorting, near.tally, n)
    near.numbers[CANDIDATE_COUNT] = count


@inlined
def _find(near: ListArrays, world: WorldArrays, boxes: Boxes, resting: Boxes) -> int:
    """Write the codes that ``look_at_all`` does, by grids: unsorted, some of them twice."""
    n, codes = near.is_plane.size, near.candidates
    count = pairs_within(boxes, near.no_bodies, codes, 0)
    # Bodies that woke up since the resting ones were put into their cells are in both grids.
    count = pairs_between(boxes, resting, near.active, codes, count)
    for k in range(near.numbers[RESTING]):
        i, j = rows_of(near.resting[k])
        if not (near.active[i] or near.active[j]):
            count = put_code(codes, count, i, j, True)
    for k in range(near.planes.size):
        plane = near.planes[k]
        for g in range(n):
            fixed = world.frames[plane] == 0 and world.frames[g] == 0
            if not (near.is_plane[g] or fixed):
                count = put_code(codes, count, plane, g, True)
    return count


@inlined
def _many_have_changed(
    numbers: Indices, bodies: int, revision: int, active: int, idle: int
) -> bool:
    """Return whether the division into active and resting is out of date."""
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
    """Put resting bodies into cells, and pair them, for distances up to a cutoff [m].

    The rows of active bodies are then listed in order. Return False, with the number of pairs in
    NEEDED, where the pairs do not fit.
    """
    numbers, n = near.numbers, near.is_plane.size
    padding = part(near.rest_paddings, 0, n)
    padding[:] = 0.5 * cutoff
    posed = world.p_WGs, world.half_extents, padding
    loose, fixed = 0, 0
    for g in range(n):
        if revision >= PATIENCE and world.stamps[g] <= revision - PATIENCE:
            near.active[g] = False
        rests = not (near.active[g] or near.is_plane[g] or world.waiting[g])
        if rests and world.frames[g] != 0:
            near.rows[loose] = g
            loose += 1
    put_in(boxes, part(near.rows, 0, loose), *posed)
    for g in range(n):
        if not near.is_plane[g] and world.frames[g] == 0:
            near.rows[fixed] = g
            fixed += 1
    # Two anchored bodies are no pair.
    put_in(resting, part(near.rows, 0, fixed), *posed)
    count = pairs_within(boxes, near.no_bodies, near.resting, 0)
    count = pairs_between(boxes, resting, near.no_bodies, near.resting, count)
    if count >= near.resting.size:
        numbers[NEEDED], near.lengths[RESTING_CUTOFF] = count, -1.0  # to be repeated
        return False
    rest, active = 0, 0
    for g in range(n):
        if not (near.active[g] or near.is_plane[g] or world.waiting[g]):
            near.rows[rest] = g
            rest += 1
    put_in(resting, part(near.rows, 0, rest), *posed)
    for g in range(n):
        if near.active[g] and not world.waiting[g]:
            near.rows[active] = g
            active += 1
    numbers[RESTING], numbers[SETTLED_AT], numbers[ACTIVE_THEN] = count, revision, active
    near.lengths[RESTING_CUTOFF] = cutoff
    return True
