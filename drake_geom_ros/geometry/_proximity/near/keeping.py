"""From the codes of candidate pairs to a neighbour list: sorted, unfiltered, with slots."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.filters.matrix import may_report
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import SEEN, SLACK, SLOT_WIDTH
from drake_geom_ros.geometry._proximity.near.arrays import FREE, PAIRS, FilterArrays, ListArrays
from drake_geom_ros.geometry._proximity.near.grids import rows_of
from drake_geom_ros.geometry._proximity.runtime.arrays import Indices, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays


@compiled
def sort(codes: Indices, scratch: Indices, tally: Indices, n: int) -> None:
    """Sort codes of pairs of n bodies: a radix sort by the second row, then by the first.

    Only rows between the least and the largest are counted: half of them where few bodies move.
    """
    for turn in range(2):
        unsorted, ordered = (codes, scratch) if turn == 0 else (scratch, codes)
        low, high = n, -1
        for k in range(codes.size):
            digit = _digit(unsorted[k], turn)
            low, high = min(low, digit), max(high, digit)
        counts = part(tally, 0, max(high - low + 2, 0))
        counts[:] = 0
        for k in range(codes.size):
            counts[unsigned(_digit(unsorted[k], turn) - low + 1)] += 1
        for k in range(1, counts.size):
            counts[k] += counts[k - 1]
        for k in range(codes.size):
            digit = unsigned(_digit(unsorted[k], turn) - low)
            ordered[counts[digit]] = unsorted[k]
            counts[digit] += 1


@inlined
def _digit(code: int, turn: int) -> int:
    """Return the row by which a turn of ``sort`` orders a code."""
    first, second = rows_of(code)
    return second if turn == 0 else first


@inlined
def keep(
    world: WorldArrays, filters: FilterArrays, codes: Indices, unfiltered: Indices
) -> tuple[int, int]:
    """Write the codes of unfiltered pairs; return the numbers of pairs before and after filtering.

    Duplicates and pairs that wait for a first pose are not counted. ``codes`` are sorted.
    """
    considered, count, last = 0, 0, -1
    for k in range(codes.size):
        if codes[k] == last:
            continue
        last = codes[k]
        i, j = rows_of(last)
        if world.waiting[i] or world.waiting[j]:
            continue
        considered += 1
        a, b = filters.slots[i], filters.slots[j]
        if may_report(filters.bits, filters.bodies, filters.bit_rows, a, b):
            unfiltered[count] = last
            count += 1
    return considered, count


@inlined
def carry(near: ListArrays, codes: Indices) -> None:
    """Make these codes the list; each pair retains its former slot or gets a free one."""
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
    for k in range(codes.size):
        if slots[k] < 0:
            free -= 1
            slot = near.free[free]
            slots[k] = slot
            # The first number of a kernel's memory says whether it has any content.
            for c in range(min(near.memory.shape[1], SLOT_WIDTH + 1)):
                near.memory[slot, c] = 0.0
            near.memory[slot, SLACK], near.memory[slot, SEEN] = -math.inf, -1.0
        near.slots[k], near.codes[k] = slots[k], codes[k]
        near.pairs[k, 0], near.pairs[k, 1] = rows_of(codes[k])
    numbers[PAIRS], numbers[FREE] = codes.size, free
