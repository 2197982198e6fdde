"""The making of a near list, compiled: who may be near whom, less the filtered, with the slots.

Of few bodies every pair of boxes is looked at (``all_pairs``); else boxes go into hashed grids
(``broadphase``), and those that rest are put there, and paired among themselves, once. The pairs
come in the order of their codes whichever way they were found.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.all_pairs import look_at_all
from drake_geom_ros.geometry._proximity.broadphase import put_code, put_in, rows_of
from drake_geom_ros.geometry._proximity.clock import now
from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.filter_matrix import may_report, prefetch_pair
from drake_geom_ros.geometry._proximity.grid_pairs import pairs_between, pairs_within
from drake_geom_ros.geometry._proximity.handing import (
    BitRows,
    Bits,
    Flags,
    IndexPairs,
    Integers,
    Reals,
    Rows,
    SingleRows,
    Vectors,
    taker,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import SEEN, SLACK, SLOT_WIDTH
from drake_geom_ros.geometry._proximity.kernels.calling.views import part
from drake_geom_ros.geometry._proximity.kernels.prefetch import AHEAD, MANY, prefetch, until
from drake_geom_ros.geometry._proximity.posing import PACE

UPDATES_AHEAD = 16.0  # that a margin is made for; fewer lists, more pairs to look at
WIDEST_MARGIN = 0.5  # of a body's radius
LEAST_AHEAD = 4.0  # updates that a margin has to last: it costs as much as a list or two
PATIENCE = 64  # updates without a move after which a body counts as resting
FEW = 256  # bodies; of these every pair of boxes is looked at

# What ``bring_up_to_date`` tells.
STANDS = 0
MADE = 1
LACKS_CODES = 2  # there are NEEDED of them
LACKS_RESTING = 3
LACKS_SLOTS = 4

# Places of ``ListArrays.numbers``.
PAIRS = 0  # of the list
CONSIDERED = 1  # pairs before the filters
FREE = 2  # slots
NEEDED = 3
HAS_KERNELS = 4  # 1 once those of its pairs are known to be compiled
VERSION, PLACINGS = 5, 6  # of the filters, and of who waits for a first pose
MADE_AT = 7  # revision of the world in which the list was made
CHECKED_AT = 8  # in which everybody was last seen in the boxes
SETTLED_AT = 9  # in which those that rest were put into their cells
ACTIVE_THEN = 10  # how many did not rest
RESTING = 11  # pairs of bodies that rest
NUMBERS = 12
# Places of ``ListArrays.lengths``.
REACH = 0  # [m] the list holds every pair this near; below 0: not made yet
WANTED = 1  # [m] the largest distance asked for since the list was made
RESTING_WITHIN = 2  # [m] what the resting pairs were made for
FILTERING = 3  # [s] that the filters took when the list was made
LENGTHS = 4


class ListArrays(NamedTuple):
    """A near list of n geometries with room for m pairs."""

    numbers: Integers  # (NUMBERS,)
    lengths: Reals  # (LENGTHS,)
    # Of geometries (n,).
    is_plane: Flags
    active: Flags  # neither a plane nor anchored nor known to rest
    lowers: Vectors  # [m] the boxes for which the list stands
    uppers: Vectors
    paddings: Reals  # [m]
    rows: Integers
    rest_paddings: Reals  # [m]
    tally: Integers  # (n + 1,)
    sides: SingleRows  # (6, n + LANES) [m]
    planes: Integers  # (p,) rows
    nobody: Flags  # (0,)
    # Codes of pairs: as they were found (c,), room to sort them, and of those that rest. The
    # last place is none (see ``broadphase.put_code``).
    found: Integers
    sorting: Integers
    resting: Integers
    # Of the list.
    codes: Integers  # (m,)
    pairs: IndexPairs  # (m, 2) rows of the world, i < j
    slots: Integers  # (m,)
    new_slots: Integers  # (m,)
    free: Integers  # (m,) slots
    hits: Integers  # (m,) room for numbers of pairs
    memory: Rows  # (m, SLOT_WIDTH or more) by slots, see ``records.empty_memory``


class FilterArrays(NamedTuple):
    """What tells whether a pair of rows of the world is filtered."""

    slots: Integers  # (n,) of the geometries
    bits: Bits
    bodies: Integers
    bit_rows: BitRows


list_of = taker(ListArrays)
filters_of = taker(FilterArrays)


@compiled
def bring_up_to_date(  # type: ignore[no-untyped-def]
    near, world, boxes, resting, filters, revision, version, placings, distance
):
    """Make the list anew unless it stands; return which, or what it lacks room for.

    The first five are records; with what is asked for by a ``distance`` [m] that is infinite, all
    pairs are listed. Who gives it the room that it lacks calls it again.
    """
    numbers, lengths = near.numbers, near.lengths
    distance = max(distance, 0.0)
    lengths[WANTED] = max(lengths[WANTED], distance)
    stands = distance <= lengths[REACH]
    stands = stands and version == numbers[VERSION] and placings == numbers[PLACINGS]
    if stands and (math.isinf(lengths[REACH]) or not _somebody_left(near, world, revision)):
        return STANDS
    lengths[REACH] = -1.0  # until it is made
    reach, n = lengths[WANTED], near.is_plane.size
    at_once = math.isinf(reach) or n <= FEW
    active, idle = _set_boxes(near, world, revision, reach, at_once)
    if at_once:
        count = look_at_all(near, world, reach)
    else:
        changed = _many_have_changed(numbers, n, revision, active, idle)
        if reach > lengths[RESTING_WITHIN] or changed:
            if not _settle(near, world, boxes, resting, revision, reach):
                return LACKS_RESTING
            active = numbers[ACTIVE_THEN]
        rows = part(near.rows, 0, active)
        put_in(boxes, rows, world.p_WGs, world.half_extents, near.paddings)
        count = _find(near, world, boxes, resting)
        if count < near.found.size:
            _sort(near, n, count)
    if count >= near.found.size:
        numbers[NEEDED] = count
        return LACKS_CODES
    start = now()
    considered, kept = _keep(near, world, filters, part(near.found, 0, count))
    lengths[FILTERING] = now() - start
    if kept > near.slots.size:
        numbers[NEEDED] = kept
        return LACKS_SLOTS
    _carry(near, part(near.found, 0, kept))
    numbers[CONSIDERED], numbers[HAS_KERNELS] = considered, 0
    numbers[VERSION], numbers[PLACINGS] = version, placings
    lengths[REACH], lengths[WANTED] = reach, distance
    return MADE


@inlined
def _somebody_left(near, world, revision):  # type: ignore[no-untyped-def]
    """Tell whether a body is no longer in the box that the list was made for."""
    since = near.numbers[CHECKED_AT]
    near.numbers[CHECKED_AT] = revision
    if since == revision:
        return False
    for k in range(world.movable.size):
        g = world.movable[k]
        if world.stamps[g] <= since:
            continue
        for c in range(3):
            p, half = world.p_WGs[g, c], world.half_extents[g, c]
            if not (p - half >= near.lowers[g, c] and p + half <= near.uppers[g, c]):
                return True
    return False


@inlined
def _set_box(near, world, g, lasts, distance):  # type: ignore[no-untyped-def]
    """Set the margin and the padding of a body, and the box that it is to stay in."""
    margin = 0.0
    if near.active[g] and lasts:
        margin = min(UPDATES_AHEAD * world.kept[g, PACE], WIDEST_MARGIN * world.outer[g])
    near.paddings[g] = margin + 0.5 * distance
    for c in range(3):
        p, side = world.p_WGs[g, c], world.half_extents[g, c] + margin
        near.lowers[g, c], near.uppers[g, c] = p - side, p + side


@inlined
def _set_boxes(near, world, revision, distance, every):  # type: ignore[no-untyped-def]
    """Wake up who has moved since the list was made, and set margins.

    Return how many are active, and how many of them have rested for some time. ``lowers`` and
    ``uppers`` get the boxes for which the next list stands, ``paddings`` margins and half the
    distance [m], of those that are not anchored or of ``every`` body. ``rows`` begins with the
    active ones.
    """
    count, idle, lasts, made = 0, 0, True, near.numbers[MADE_AT]
    stamps, outer, movable = world.stamps, world.outer, world.movable
    for k in range(movable.size):
        g = movable[k]
        if made > 0 and stamps[g] > made and not near.is_plane[g]:
            near.active[g] = True
        if near.active[g]:
            near.rows[count] = g
            count += 1
            idle += stamps[g] <= revision - PATIENCE
            lasts &= world.kept[g, PACE] * LEAST_AHEAD <= WIDEST_MARGIN * outer[g]
    if every or 2 * movable.size > near.active.size:
        for g in range(near.active.size):  # in order, which takes half as long
            _set_box(near, world, g, lasts, distance)
    else:
        for k in range(movable.size):
            _set_box(near, world, movable[k], lasts, distance)
    near.numbers[MADE_AT] = near.numbers[CHECKED_AT] = revision
    return count, idle


@inlined
def _find(near, world, boxes, resting):  # type: ignore[no-untyped-def]
    """Do what ``_look_at_all`` does by grids; codes come in any order, some of them twice."""
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
def _many_have_changed(numbers, bodies, revision, active, idle):  # type: ignore[no-untyped-def]
    """Tell whether the division into active and resting is out of date."""
    if 8 * (active - numbers[ACTIVE_THEN]) > bodies + 64:
        return True
    return revision - numbers[SETTLED_AT] >= PATIENCE and 2 * (active - idle) < active


@compiled
def _settle(near, world, boxes, resting, revision, distance):  # type: ignore[no-untyped-def]
    """Put those that rest into cells, and pair them, for distances up to this one.

    The rows of those that do not rest are put in order. Return False, and count the pairs, where
    there is no room for these.
    """
    numbers, n = near.numbers, near.is_plane.size
    padding = part(near.rest_paddings, 0, n)
    padding[:] = 0.5 * distance
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
        numbers[NEEDED], near.lengths[RESTING_WITHIN] = count, -1.0  # to be done again
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
    near.lengths[RESTING_WITHIN] = distance
    return True


@compiled
def _sort(near, n, count):  # type: ignore[no-untyped-def]
    """Put the codes that were found in order: by the second row, and then by the first.

    Only rows between the least and the largest are counted: where few bodies move, half of them.
    """
    for turn in range(2):
        codes, sorted_codes = (
            (near.found, near.sorting) if turn == 0 else (near.sorting, near.found)
        )
        low, high = n, -1
        for k in range(count):
            digit = _digit(codes[k], turn)
            low, high = min(low, digit), max(high, digit)
        tally = part(near.tally, 0, max(high - low + 2, 0))
        tally[:] = 0
        for k in range(count):
            tally[np.uint64(_digit(codes[k], turn) - low + 1)] += 1
        for k in range(1, tally.size):
            tally[k] += tally[k - 1]
        for k in range(count):
            digit = np.uint64(_digit(codes[k], turn) - low)
            sorted_codes[tally[digit]] = codes[k]
            tally[digit] += 1


@inlined
def _digit(code, turn):  # type: ignore[no-untyped-def]
    """Return the row that a turn of ``_sort`` goes by."""
    first, second = rows_of(code)
    return second if turn == 0 else first


@inlined
def _keep(near, world, filters, codes):  # type: ignore[no-untyped-def]
    """Keep the sorted codes of pairs that may be reported, in front; return how many were and are.

    Those that stand there twice, or wait for a pose, are not counted.
    """
    considered, count, last, ask_until = 0, 0, -1, until(codes.size)
    for k in range(codes.size):
        if k < ask_until:
            i, j = rows_of(codes[k + AHEAD])
            a, b = filters.slots[i], filters.slots[j]
            prefetch_pair(filters.bits, filters.bit_rows, a, b)
        if codes[k] == last:
            continue
        last = codes[k]
        i, j = rows_of(last)
        if world.waiting[i] or world.waiting[j]:
            continue
        considered += 1
        a, b = filters.slots[i], filters.slots[j]
        if may_report(filters.bits, filters.bodies, filters.bit_rows, a, b):
            codes[count] = last
            count += 1
    return considered, count


@inlined
def _carry(near, codes):  # type: ignore[no-untyped-def]
    """Make these codes the list; each pair keeps its former slot or gets a free one."""
    numbers, slots = near.numbers, near.new_slots
    before, old, free = numbers[PAIRS], 0, numbers[FREE]
    for k in range(codes.size):
        slots[k] = -1
        while old < before and near.codes[old] < codes[k]:
            near.free[free] = near.slots[old]
            free += 1
            old += 1
        if old < before and near.codes[old] == codes[k]:
            slots[k] = near.slots[old]
            old += 1
    for rest in range(old, before):
        near.free[free] = near.slots[rest]
        free += 1
    many = codes.size > MANY
    for k in range(codes.size):
        if slots[k] < 0:
            if many and free > AHEAD:
                ahead = near.free[free - AHEAD]
                prefetch(near.memory, (ahead,))
                prefetch(near.memory, (ahead, 8))
            free -= 1
            slot = near.free[free]
            slots[k] = slot
            # The first number of what kernels remember tells whether there is anything.
            for c in range(min(near.memory.shape[1], SLOT_WIDTH + 1)):
                near.memory[slot, c] = 0.0
            near.memory[slot, SLACK], near.memory[slot, SEEN] = -math.inf, -1.0
        near.slots[k], near.codes[k] = slots[k], codes[k]
        near.pairs[k, 0], near.pairs[k, 1] = rows_of(codes[k])
    numbers[PAIRS], numbers[FREE] = codes.size, free
