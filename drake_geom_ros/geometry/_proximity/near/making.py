"""Compiled construction of a neighbour list: the unfiltered candidate pairs, with slots.

With few bodies every pair of boxes is tested (``all_pairs``). Otherwise boxes go into hashed grids
(``by_grids``), whose code is called by address and compiled when first needed, because small
scenes need none of it. Both ways give the pairs in the order of their codes.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.near.all_pairs import look_at_all
from drake_geom_ros.geometry._proximity.near.arrays import (
    ASKED_CUTOFF,
    CANDIDATE_COUNT,
    CONSIDERED,
    FILTERING,
    HAS_KERNELS,
    LACKS_CODES,
    LACKS_GRIDS,
    LACKS_SLOTS,
    LIST_CUTOFF,
    MADE,
    NEEDED,
    PLACINGS,
    RESTING_CUTOFF,
    STANDS,
    VERSION,
    FilterArrays,
    ListArrays,
)
from drake_geom_ros.geometry._proximity.near.by_grids import call_by_grids
from drake_geom_ros.geometry._proximity.near.keeping import carry, keep
from drake_geom_ros.geometry._proximity.near.skins import set_boxes, somebody_left
from drake_geom_ros.geometry._proximity.runtime.clock import now
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays

FEW = 256  # bodies up to which every pair of boxes is tested


@compiled
def bring_up_to_date(
    near: ListArrays,
    world: WorldArrays,
    handles: tuple[Handle, Handle, Handle, Handle],
    filters: FilterArrays,
    revision: int,
    version: int,
    placings: int,
    cutoff: float,
) -> int:
    """Make the list unless it is still valid; return STANDS, MADE, or the code of what it lacks.

    ``handles`` are those of the list, the world, and the boxes of moving and of resting bodies;
    the other arguments are records. An infinite ``cutoff`` [m] lists all pairs. A caller that gets
    the code of what is lacking provides it and calls again.
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
    at_once = _is_at_once(near, list_cutoff)
    is_placed = placings == numbers[PLACINGS]
    if holds and list_cutoff == before and (is_placed or at_once):
        count = numbers[CANDIDATE_COUNT]  # the same candidates, under other filters
    else:
        if not is_placed:
            lengths[RESTING_CUTOFF] = -1.0  # who was placed is in no grid yet
        count = _find_all(near, world, handles, revision, list_cutoff)
        if count < 0:
            return -count
    if count >= near.candidates.size:
        numbers[NEEDED] = count
        return LACKS_CODES
    numbers[CANDIDATE_COUNT] = count
    start = now()
    considered, unfiltered = keep(world, filters, part(near.candidates, 0, count), near.sorting)
    lengths[FILTERING] = now() - start
    if unfiltered > near.slots.size:
        numbers[NEEDED] = unfiltered
        return LACKS_SLOTS
    carry(near, part(near.sorting, 0, unfiltered))
    numbers[CONSIDERED], numbers[HAS_KERNELS] = considered, 0
    numbers[VERSION], numbers[PLACINGS] = version, placings
    lengths[LIST_CUTOFF], lengths[ASKED_CUTOFF] = list_cutoff, cutoff
    return MADE


@inlined
def _is_at_once(near: ListArrays, list_cutoff: float) -> bool:
    """Return whether every pair of boxes is looked at, of bodies that wait for a pose, too."""
    return math.isinf(list_cutoff) or near.is_plane.size <= FEW


@inlined
def _find_all(
    near: ListArrays,
    world: WorldArrays,
    handles: tuple[Handle, Handle, Handle, Handle],
    revision: int,
    list_cutoff: float,
) -> int:
    """Find the codes of all candidate pairs; return their number, or minus what is lacking.

    They are sorted unless they do not fit.
    """
    at_once = _is_at_once(near, list_cutoff)
    if not (at_once or near.by_grids[0]):
        return -LACKS_GRIDS
    active, idle = set_boxes(near, world, revision, list_cutoff, at_once)
    if at_once:
        return look_at_all(near, world, list_cutoff)
    call_by_grids(near.by_grids[0], *handles, revision, list_cutoff, active, idle)
    return near.numbers[CANDIDATE_COUNT]
