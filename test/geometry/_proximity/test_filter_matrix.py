import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.filter_matrix import (
    BASE,
    CURRENT,
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


def unpacked(bits, layer):
    """Return the layer as a matrix of booleans."""
    return np.unpackbits(bits[layer], axis=1, bitorder='little').astype(bool)


def test_growth_keeps_what_was_written_and_is_bounded():
    bits = grown_bits(empty_bits())
    write_pairs(bits, np.zeros(64, bool), BASE, slots(1, 5), slots(63), True)
    before = np.argwhere(unpacked(bits, CURRENT))
    grown = bits
    while grown.shape[1] < 5000:
        former, grown = grown, grown_bits(grown)
        assert former.shape[1] < grown.shape[1] <= former.shape[1] * 17 // 16 + 64
    assert grown.shape[2] * 8 == grown.shape[1]
    assert grown.nbytes < 7.1e6
    np.testing.assert_array_equal(np.argwhere(unpacked(grown, CURRENT)), before)


@pytest.mark.parametrize('first_layer', [BASE, CURRENT])
def test_writing_is_what_it_is_on_a_matrix_of_booleans(first_layer):
    rng = np.random.default_rng(7)
    bits = grown_bits(grown_bits(empty_bits()))
    n = bits.shape[1]
    expected, named = np.zeros((2, n, n), dtype=bool), np.zeros(n, dtype=bool)
    said = named.copy()
    for step in range(60):
        a, b = (rng.permutation(n)[: rng.integers(0, 20)] for _ in range(2))
        excludes = bool(rng.integers(2))
        before = expected.copy()
        if step % 3:
            expected[first_layer:, a[:, None], b] = excludes
            expected[first_layer:, b[:, None], a] = excludes
            changed = write_pairs(bits, named, first_layer, a, b, excludes)
            if excludes and len(a) and len(b):
                said[a] = said[b] = True
        else:
            expected[first_layer, a[:, None], b] = excludes
            changed = write_rows(bits, first_layer, a, b, excludes)
        assert changed == (before != expected).any()
        for layer in (BASE, CURRENT):
            np.testing.assert_array_equal(unpacked(bits, layer), expected[layer])
        np.testing.assert_array_equal(named, said)


def test_clearing_a_slot_clears_its_row_and_its_column():
    bits = grown_bits(empty_bits())
    every = np.arange(64)
    write_pairs(bits, np.zeros(64, bool), BASE, every, every, True)
    clear_slot(bits, 13)
    for layer in (BASE, CURRENT):
        left = unpacked(bits, layer)
        assert not left[13].any()
        assert not left[:, 13].any()
        assert left.sum() == 63 * 63


def test_reportable_and_count_against_booleans():
    rng = np.random.default_rng(11)
    bits = grown_bits(empty_bits())
    n, named = 40, np.zeros(64, bool)
    for _ in range(12):
        write_pairs(bits, named, CURRENT, rng.permutation(25)[:6], rng.permutation(n)[:6], True)
    bodies = rng.integers(0, 15, size=64)
    active = rng.random(64) < 0.8
    packed = np.where(active, bodies, ~bodies)
    i, j = (side.ravel() for side in np.indices((n, n)))
    possible = bodies[i] != bodies[j]
    free = ~unpacked(bits, CURRENT)[i, j] & active[i] & active[j]
    np.testing.assert_array_equal(reportable(bits, packed, named, i, j), possible & free)
    # Without the flag of its first slot a pair is not looked up.
    some = named & (rng.random(64) < 0.5)
    assert (~some[:n] & named[:n]).any()
    unseen = possible & active[i] & active[j] & ~some[i]
    np.testing.assert_array_equal(reportable(bits, packed, some, i, j), possible & free | unseen)
    assert 0 < (possible & ~free).sum() < possible.sum()
    assert 2 * count_filtered(bits, packed, np.arange(n)) == (possible & ~free).sum()
