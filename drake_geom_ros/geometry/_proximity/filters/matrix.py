"""Filter matrix: the excluded pairs as packed bits, written by rows and read by pairs.

``bits[layer, bit_rows[i], j >> 3]`` has bit ``j & 7`` set where the pair of slots (i, j) is
excluded, and the same for (j, i), so each slot has all its pairs in its own row. ``BASE`` is the
persistent configuration, ``CURRENT`` the one with all transient declarations applied. A slot of
which no pair was ever excluded has ``NO_ROW``: most geometries of a large scene have no filter and
need neither memory nor reads. m rows for n slots take m * n / 4 bytes: 6.3 MB if each of 5000
slots has one.

The bits do not contain the invariant pairs: ``reportable`` compares bodies instead. So statements
need not consider them, and no order of statements can lose one. ``bodies`` has a number of at
least 0 for each slot, equal for the two slots of an invariant pair, and its complement ``~body``
while the slot is deactivated.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.runtime.arrays import unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined

Slots = NDArray[np.int64]
Bits = NDArray[np.uint8]
Flags = NDArray[np.bool_]
BitRows = NDArray[np.int32]

NO_ROW = -1
BASE = 0
CURRENT = 1

_STEP = 64  # rows then start on whole cache lines' worth of bits
_GROWTH_SIXTEENTHS = 17  # of the former capacity; then 5000 slots need at most 7.1 MB


def empty_bits() -> Bits:
    """Return the bits of no slots at all."""
    return np.zeros((2, 0, 0), dtype=np.uint8)


def capacity_for(wanted: int, former: int) -> int:
    """Return the capacity, of slots or rows, to grow to from a ``former`` one."""
    return (max(wanted, former * _GROWTH_SIXTEENTHS // 16) // _STEP + 1) * _STEP


def grown_bits(bits: Bits, rows: int, slots: int) -> Bits:
    """Return a copy of larger capacity; pairs of the new rows or slots are not excluded."""
    grown = np.zeros((2, rows, slots // 8), dtype=np.uint8)
    grown[:, : bits.shape[1], : bits.shape[2]] = bits
    return grown


def clear_slot(bits: Bits, bit_rows: BitRows, slot: int) -> None:
    """Clear all bits of a slot, so that it can be reused."""
    if bit_rows[slot] != NO_ROW:
        bits[:, bit_rows[slot], :] = 0
        bits[:, :, slot >> 3] &= np.uint8(0xFF ^ (1 << (slot & 7)))


@compiled
def write_pairs(
    bits: Bits, bit_rows: BitRows, first_layer: int, slots_a: Slots, slots_b: Slots, excludes: bool
) -> bool:
    """Exclude or allow all pairs between two sets, from a layer on; return whether any changed."""
    changed = False
    for layer in range(first_layer, 2):
        changed |= write_rows(bits, bit_rows, layer, slots_a, slots_b, excludes)
        changed |= write_rows(bits, bit_rows, layer, slots_b, slots_a, excludes)
    return changed


@allocating
def write_rows(
    bits: Bits, bit_rows: BitRows, layer: int, slots: Slots, columns: Slots, excludes: bool
) -> bool:
    """Exclude or allow the pairs (slot, column) in the slots' rows; return whether bits changed.

    Slots without a row are skipped: allowing changes nothing there, and callers that exclude give
    them rows first.
    """
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
    for slot in slots:
        if bit_rows[slot] == NO_ROW:
            continue
        line = bits[layer, bit_rows[slot], first : last + 1]
        for k in range(pattern.size):
            before = line[k]
            after = before | pattern[k] if excludes else before & ~pattern[k]
            line[k] = after
            difference |= np.uint8(before ^ after)
    return bool(difference != 0)


@inlined
def may_report(bits: Bits, bodies: Slots, bit_rows: BitRows, slot_a: int, slot_b: int) -> bool:
    """Return whether a pair may be reported."""
    # Unsigned indices need no test for negative ones, which takes a third of the whole time.
    i, j = unsigned(slot_a), unsigned(slot_b)
    excluded = np.uint8(0)
    if bit_rows[i] != NO_ROW:
        row = unsigned(bit_rows[i])
        excluded = bits[CURRENT, row, j >> unsigned(3)] >> np.uint8(j & unsigned(7))
    body_a, body_b = bodies[i], bodies[j]
    return bool((excluded & np.uint8(1) == 0) & (body_a != body_b) & ((body_a | body_b) >= 0))


@allocating
def reportable(
    bits: Bits, bodies: Slots, bit_rows: BitRows, slots_a: Slots, slots_b: Slots
) -> Flags:
    """Return whether each pair may be reported."""
    answer = np.empty(slots_a.size, dtype=np.bool_)
    for k in range(slots_a.size):
        answer[k] = may_report(bits, bodies, bit_rows, slots_a[k], slots_b[k])
    return answer


@compiled
def count_lacking(bits: Bits, bodies: Slots, bit_rows: BitRows, slots: Slots, lacks: Flags) -> int:
    """Return how many pairs of ``slots`` may be reported and have one that ``lacks`` a place."""
    count = 0
    for a in range(slots.size):
        i = slots[a]
        for b in range(a):
            if lacks[a] or lacks[b]:
                count += may_report(bits, bodies, bit_rows, i, slots[b])
    return count


@compiled
def count_filtered(bits: Bits, bodies: Slots, bit_rows: BitRows, slots: Slots) -> int:
    """Return the number of pairs of ``slots`` that are filtered and not invariant."""
    count = 0
    for a in range(slots.size):
        i = slots[a]
        for b in range(a):
            j = slots[b]
            body_a, body_b = bodies[i], bodies[j]
            if max(body_a, ~body_a) != max(body_b, ~body_b):
                count += not may_report(bits, bodies, bit_rows, i, j)
    return count
