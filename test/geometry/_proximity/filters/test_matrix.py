import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.filters.matrix import (
    BASE,
    CURRENT,
    NO_ROW,
    capacity_for,
    clear_slot,
    count_filtered,
    empty_bits,
    grown_bits,
    reportable,
    write_pairs,
    write_rows,
)


def slots(*values):
    return np.array(values, dtype=np.int64)


def matrix(count):
    """Return bits with a row for each of ``count`` slots, in some order, and the rows by slot."""
    capacity = capacity_for(count, 0)
    bit_rows = np.full(capacity, NO_ROW, dtype=np.int32)
    bit_rows[:count] = np.random.default_rng(3).permutation(count)
    return grown_bits(empty_bits(), count, capacity), bit_rows


def unpacked(bits, bit_rows, layer):
    """Return the layer as a matrix of booleans, by slots."""
    by_row = np.unpackbits(bits[layer], axis=1, bitorder='little').astype(bool)
    return np.where((bit_rows == NO_ROW)[:, None], False, by_row[np.maximum(bit_rows, 0)])


def test_growth_keeps_what_was_written():
    bits, bit_rows = matrix(6)
    write_pairs(bits, bit_rows, BASE, slots(1, 5), slots(2), True)
    before = np.argwhere(unpacked(bits, bit_rows, CURRENT))
    grown = grown_bits(bits, 20, 192)
    assert grown.shape == (2, 20, 192 // 8)
    assert grown.sum() == bits.sum()
    after = unpacked(grown, np.append(bit_rows, np.full(128, NO_ROW)), CURRENT)
    np.testing.assert_array_equal(np.argwhere(after), before)
    assert before.tolist() == [[1, 2], [2, 1], [2, 5], [5, 2]]


def test_capacity_is_bounded():
    capacity = 0
    while capacity < 5000:
        former, capacity = capacity, capacity_for(capacity + 1, capacity)
        assert former < capacity <= former * 17 // 16 + 64
        assert capacity % 64 == 0
    assert 2 * capacity * capacity / 8 < 7.1e6
    assert 5000 < capacity_for(5000, 64) <= 5064


@pytest.mark.parametrize('first_layer', [BASE, CURRENT])
def test_writing_is_what_it_is_on_a_matrix_of_booleans(first_layer):
    rng = np.random.default_rng(7)
    n = 100
    bits, bit_rows = matrix(n)
    expected = np.zeros((2, 128, 128), dtype=bool)
    for step in range(60):
        a, b = (rng.permutation(n)[: rng.integers(0, 20)] for _ in range(2))
        excludes = bool(rng.integers(2))
        before = expected.copy()
        if step % 3:
            expected[first_layer:, a[:, None], b] = excludes
            expected[first_layer:, b[:, None], a] = excludes
            changed = write_pairs(bits, bit_rows, first_layer, a, b, excludes)
        else:
            expected[first_layer, a[:, None], b] = excludes
            changed = write_rows(bits, bit_rows, first_layer, a, b, excludes)
        assert changed == (before != expected).any()
        for layer in (BASE, CURRENT):
            np.testing.assert_array_equal(unpacked(bits, bit_rows, layer), expected[layer])


def test_of_a_slot_without_a_row_nothing_is_excluded():
    bits, bit_rows = matrix(6)
    every = np.arange(6)
    write_pairs(bits, bit_rows, BASE, every, every, True)
    bit_rows[4] = NO_ROW
    i, j = slots(4, 4, 0), slots(0, 9, 1)
    np.testing.assert_array_equal(
        reportable(bits, np.arange(64), bit_rows, i, j), [True, True, False]
    )
    before = bits.copy()
    assert not write_pairs(bits, bit_rows, BASE, slots(4), slots(4, 9), False)
    clear_slot(bits, bit_rows, 4)
    np.testing.assert_array_equal(bits, before)


def test_clearing_a_slot_clears_its_row_and_its_column():
    bits, bit_rows = matrix(64)
    every = np.arange(64)
    write_pairs(bits, bit_rows, BASE, every, every, True)
    clear_slot(bits, bit_rows, 13)
    for layer in (BASE, CURRENT):
        left = unpacked(bits, bit_rows, layer)
        assert not left[13].any()
        assert not left[:, 13].any()
        assert left.sum() == 63 * 63


def test_reportable_and_count_against_booleans():
    rng = np.random.default_rng(11)
    n = 40
    bits, bit_rows = matrix(n)
    for _ in range(12):
        write_pairs(bits, bit_rows, CURRENT, rng.permutation(25)[:6], rng.permutation(n)[:6], True)
    bodies = rng.integers(0, 15, size=64)
    active = rng.random(64) < 0.8
    packed = np.where(active, bodies, ~bodies)
    i, j = (side.ravel() for side in np.indices((n, n)))
    possible = bodies[i] != bodies[j]
    free = ~unpacked(bits, bit_rows, CURRENT)[i, j] & active[i] & active[j]
    np.testing.assert_array_equal(reportable(bits, packed, bit_rows, i, j), possible & free)
    assert 0 < (possible & ~free).sum() < possible.sum()
    assert 2 * count_filtered(bits, packed, bit_rows, np.arange(n)) == (possible & ~free).sum()
