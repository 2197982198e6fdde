"""The making of a neighbour list, compiled: who may be near whom, less the filtered, with slots.

Of few bodies every pair of boxes is looked at (``all_pairs``); else boxes go into hashed grids
(``grids``), and those that rest are put there, and paired among themselves, once. The pairs
come in the order of their codes whichever way they were found.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.near.all_pairs import look_at_all
from drake_geom_ros.geometry._proximity.near.arrays import (
    ACTIVE_THEN,
    ASKED_CUTOFF,
    CONSIDERED,
    FILTERING,
    FOUND,
    HAS_KERNELS,
    LACKS_CODES,
    LACKS_RESTING,
    LACKS_SLOTS,
    LIST_CUTOFF,
    MADE,
    NEEDED,
    PLACINGS,
    RESTING,
    RESTING_CUTOFF,
    SETTLED_AT,
    STANDS,
    VERSION,
    FilterArrays,
    ListArrays,
)
from drake_geom_ros.geometry._proximity.near.grid_pairs import pairs_between, pairs_within
from drake_geom_ros.geometry._proximity.near.grids import Boxes, put_code, put_in, rows_of
from drake_geom_ros.geometry._proximity.near.keeping import carry, keep, sort
from drake_geom_ros.geometry._proximity.near.skins import (
    PATIENCE,
    set_boxes,
    somebody_left,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Indices
from drake_geom_ros.geometry._proximity.runtime.clock import now
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays

FEW = 256  # bodies; of these every pair of boxes is looked at


@compiled
def bring_up_to_date(
    near: ListArrays,
    world: WorldArrays,
    boxes: Boxes,
    resting: Boxes,
    filters: FilterArrays,
    revision: int,
    version: int,
    placings: int,
    cutoff: float,
) -> int:
    """Make the list unless it stands; return which, or what it lacks room for.

    The first five are records; with what is asked for by a ``cutoff`` [m] that is infinite, all
    pairs are listed. Who gives it the room that it lacks calls it again.
    """
    numbers, lengths = near.numbers, near.lengths
    cutoff = max(cutoff, 0.0)
    lengths[ASKED_CUTOFF] = max(lengths[ASKED_CUTOFF], cutoff)
    list_cutoff, holds = lengths[ASKED_CUTOFF], cutoff <= lengths[LIST_CUTOFF]
    if holds:
        holds = math.isinf(lengths[LIST_CUTOFF]) or not somebody_left(near, world, revision)
        if holds and version == numbers[VERSION] and placings == numbers[PLACINGS]:
            return STANDS
    lengths[LIST_CUTOFF], before = -1.0, lengths[LIST_CUTOFF]  # until it is made
    if holds and list_cutoff == before:
        count = numbers[FOUND]  # of which others may be reported now
    else:
        count = _find_all(near, world, boxes, resting, revision, list_cutoff)
        if count < 0:
            return LACKS_RESTING
    if count >= near.found.size:
        numbers[NEEDED] = count
        return LACKS_CODES
    numbers[FOUND] = count
    start = now()
    considered, kept = keep(world, filters, part(near.found, 0, count), near.sorting)
    lengths[FILTERING] = now() - start
    if kept > near.slots.size:
        numbers[NEEDED] = kept
        return LACKS_SLOTS
    carry(near, part(near.sorting, 0, kept))
    numbers[CONSIDERED], numbers[HAS_KERNELS] = considered, 0
    numbers[VERSION], numbers[PLACINGS] = version, placings
    lengths[LIST_CUTOFF], lengths[ASKED_CUTOFF] = list_cutoff, cutoff
    return MADE


@inlined
def _find_all(
    near: ListArrays,
    world: WorldArrays,
    boxes: Boxes,
    resting: Boxes,
    revision: int,
    list_cutoff: float,
) -> int:
    """Find the codes of all near pairs; return how many, or -1 without room for who rests.

    They are in order, unless there are more than there is room for.
    """
    n = near.is_plane.size
    at_once = math.isinf(list_cutoff) or n <= FEW
    active, idle = set_boxes(near, world, revision, list_cutoff, at_once)
    if at_once:
        return look_at_all(near, world, list_cutoff)
    changed = _many_have_changed(near.numbers, n, revision, active, idle)
    if list_cutoff > near.lengths[RESTING_CUTOFF] or changed:
        if not _settle(near, world, boxes, resting, revision, list_cutoff):
            return -1
        active = near.numbers[ACTIVE_THEN]
    rows = part(near.rows, 0, active)
    put_in(boxes, rows, world.p_WGs, world.half_extents, near.paddings)
    count = _find(near, world, boxes, resting)
    if count < near.found.size:
        sort(part(near.found, 0, count), near.sorting, near.tally, n)
    return count


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
