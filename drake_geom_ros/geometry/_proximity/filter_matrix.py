"""The excluded pairs as packed bits: written a row at a time, read a pair at a time.

``bits[layer, i, j >> 3]`` has bit ``j & 7`` set where the pair of slots (i, j) is excluded, and
the same for (j, i), so that everything that concerns a slot stands in its own row. ``BASE`` is
the persistent configuration, ``CURRENT`` the one that transient declarations have led to. Both
take n * n / 4 bytes: 6.3 MB for 5000 slots.

The invariant pairs are not in the bits: ``reportable`` compares bodies instead. So a statement
about a set needs no care for them, and no order of statements can lose one. ``bodies`` has a
number of at least 0 for each slot, equal where the pair is invariant, and its complement
``~body`` while the slot is deactivated.

``named`` has a flag for each slot of which a pair was ever excluded. Without it nothing is read of
the row, which in a scene of thousands comes from far away in memory, and most have no filter.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.prefetch import prefetch

Slots = NDArray[np.int64]
Bits = NDArray[np.uint8]
Flags = NDArray[np.bool_]

BASE = 0
CURRENT = 1

_SLOTS_A_STEP = 64  # rows then start on whole cache lines' worth of bits
_GROWTH_SIXTEENTHS = 17  # of the former capacity; then 5000 slots need at most 7.1 MB


def empty_bits() -> Bits:
    """Return the bits of no slots at all."""
    return np.zeros((2, 0, 0), dtype=np.uint8)


def grown_bits(bits: Bits) -> Bits:
    """Return a copy with room for more slots, whose pairs are not excluded."""
    wanted = bits.shape[1] * _GROWTH_SIXTEENTHS // 16
    capacity = (wanted // _SLOTS_A_STEP + 1) * _SLOTS_A_STEP
    grown = np.zeros((2, capacity, capacity // 8), dtype=np.uint8)
    grown[:, : bits.shape[1], : bits.shape[2]] = bits
    return grown


def clear_slot(bits: Bits, slot: int) -> None:
    """Forget everything that was said of a slot, so that it can be given to a newcomer."""
    bits[:, slot, :] = 0
    bits[:, :, slot >> 3] &= np.uint8(0xFF ^ (1 << (slot & 7)))


@compiled
def write_pairs(
    bits: Bits, named: Flags, first_layer: int, slots_a: Slots, slots_b: Slots, excludes: bool
) -> bool:
    """Exclude or allow all pairs between two sets, from a layer on; return if any bit changed."""
    changed = False
    if excludes and slots_a.size > 0 and slots_b.size > 0:
        for slots in (slots_a, slots_b):
            for slot in slots:
                named[slot] = True
    for layer in range(first_layer, 2):
        changed |= write_rows(bits, layer, slots_a, slots_b, excludes)
        changed |= write_rows(bits, layer, slots_b, slots_a, excludes)
    return changed


@allocating
def write_rows(bits: Bits, layer: int, rows: Slots, columns: Slots, excludes: bool) -> bool:
    """Exclude or allow the pairs (row, column) in these rows only; return if any bit changed."""
    if columns.size == 0:
        return False
    first = columns[0] >> 3
    last = first
    for column in columns:
        first = min(first, column >> 3)
        last = max(last, column >> 3)
    pattern = np.zeros(last - first + 1, dtype=np.uint8)
    for column in columns:
        pattern[(column >> 3) - first] |= np.uint8(1 << (column & 7))
    difference = np.uint8(0)
    for row in rows:
        line = bits[layer, row, first : last + 1]
        for k in range(pattern.size):
            before = line[k]
            after = before | pattern[k] if excludes else before & ~pattern[k]
            line[k] = after
            difference |= np.uint8(before ^ after)
    return bool(difference != 0)


@inlined
def may_report(bits: Bits, bodies: Slots, named: Flags, slot_a: int, slot_b: int) -> bool:
    """Tell whether a pair may be reported."""
    # Unsigned indices spare the test for negative ones, a third of the whole time.
    i, j = np.uint64(slot_a), np.uint64(slot_b)
    excluded = np.uint8(0)
    if named[i]:
        excluded = bits[CURRENT, i, j >> np.uint64(3)] >> np.uint8(j & np.uint64(7))
    body_a, body_b = bodies[i], bodies[j]
    return bool((excluded & np.uint8(1) == 0) & (body_a != body_b) & ((body_a | body_b) >= 0))


@inlined
def prefetch_pair(bits: Bits, named: Flags, slot_a: int, slot_b: int) -> None:
    """Ask for what ``may_report`` reads of the matrix: of n geometries it has n^2 / 8 bytes."""
    if named[np.uint64(slot_a)]:
        prefetch(bits, (CURRENT, slot_a, slot_b >> 3))


@allocating
def reportable(bits: Bits, bodies: Slots, named: Flags, slots_a: Slots, slots_b: Slots) -> Flags:
    """Return for each pair whether it may be reported."""
    answer = np.empty(slots_a.size, dtype=np.bool_)
    for k in range(slots_a.size):
        answer[k] = may_report(bits, bodies, named, slots_a[k], slots_b[k])
    return answer


@compiled
def count_filtered(bits: Bits, bodies: Slots, slots: Slots) -> int:
    """Return how many pairs of ``slots`` are filtered without being invariant."""
    count = 0
    for a in range(slots.size):
        i = slots[a]
        for b in range(a):
            j = slots[b]
            body_a, body_b = bodies[i], bodies[j]
            if max(body_a, ~body_a) != max(body_b, ~body_b):
                excluded = (bits[CURRENT, i, j >> 3] >> (j & 7)) & 1
                if excluded or (body_a | body_b) < 0:
                    count += 1
    return count
