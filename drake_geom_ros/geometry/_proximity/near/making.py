"""The making of a neighbour list, compiled: who may be near whom, less the filtered, with slots.

Of few bodies every pair of boxes is looked at (``all_pairs``); else boxes go into hashed grids
(``by_grids``), whose code is called by its address and compiled when first needed: two boxes need
none of it. The pairs come in the order of their codes whichever way they were found.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.near.all_pairs import look_at_all
from drake_geom_ros.geometry._proximity.near.arrays import (
    CONSIDERED,
    FILTERING,
    FOUND,
    HAS_KERNELS,
    LACKS_CODES,
    LACKS_GRIDS,
    LACKS_SLOTS,
    MADE,
    NEEDED,
    PLACINGS,
    REACH,
    STANDS,
    VERSION,
    WANTED,
)
from drake_geom_ros.geometry._proximity.near.by_grids import call_by_grids
from drake_geom_ros.geometry._proximity.near.keeping import carry, keep
from drake_geom_ros.geometry._proximity.near.margins import set_boxes, somebody_left
from drake_geom_ros.geometry._proximity.runtime.clock import now
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part

FEW = 256  # bodies; of these every pair of boxes is looked at


@compiled
def bring_up_to_date(  # type: ignore[no-untyped-def]
    near, world, handles, filters, revision, version, placings, distance
):
    """Make the list unless it stands; return which, or what it lacks.

    ``handles`` are those of the list, the world and the boxes that move and that rest; the others
    are records. With a ``distance`` [m] that is infinite, all pairs are listed. Who gives it what
    it lacks calls it again.
    """
    numbers, lengths = near.numbers, near.lengths
    distance = max(distance, 0.0)
    lengths[WANTED] = max(lengths[WANTED], distance)
    reach, holds = lengths[WANTED], distance <= lengths[REACH]
    if holds:
        holds = math.isinf(lengths[REACH]) or not somebody_left(near, world, revision)
        if holds and version == numbers[VERSION] and placings == numbers[PLACINGS]:
            return STANDS
    lengths[REACH], before = -1.0, lengths[REACH]  # until it is made
    if holds and reach == before:
        count = numbers[FOUND]  # of which others may be reported now
    else:
        count = _find_all(near, world, handles, revision, reach)
        if count < 0:
            return -count
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
    lengths[REACH], lengths[WANTED] = reach, distance
    return MADE


@inlined
def _find_all(near, world, handles, revision, reach):  # type: ignore[no-untyped-def]
    """Find the codes of all near pairs; return how many, or minus what is lacking.

    They are in order, unless there are more than there is room for.
    """
    n = near.is_plane.size
    at_once = math.isinf(reach) or n <= FEW
    if not (at_once or near.by_grids[0]):
        return -LACKS_GRIDS
    active, idle = set_boxes(near, world, revision, reach, at_once)
    if at_once:
        return look_at_all(near, world, reach)
    call_by_grids(near.by_grids[0], *handles, revision, reach, active, idle)
    return near.numbers[FOUND]
