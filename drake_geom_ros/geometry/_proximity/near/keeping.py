"""From the codes of near pairs to a list: in order, less the filtered, each with its slot."""

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
def sort(codes: Indices, room: Indices, tally: Indices, n: int) -> None:
    """Put codes of pairs of n bodies in order: by the second row, and then by the first.

    Only rows between the least and the largest are counted: where few bodies move, half of them.
    """
    for turn in range(2):
        unsorted, ordered = (codes, room) if turn == 0 else (room, codes)
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
    """Return the row that a turn of ``sort`` goes by."""
    first, second = rows_of(code)
    return second if turn == 0 else first


@inlined
def keep(
    world: WorldArrays, filters: FilterArrays, codes: Indices, kept: Indices
) -> tuple[int, int]:
    """Write down the sorted codes of pairs that may be reported; return how many were and are.

    Those that stand there twice, or wait for a pose, are not counted.
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
            kept[count] = last
            count += 1
    return considered, count


@inlined
def carry(near: ListArrays, codes: Indices) -> None:
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
    for k in range(codes.size):
        if slots[k] < 0:
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
