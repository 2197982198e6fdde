"""Bits that are set in a packed matrix."""

import numpy as np

from drake_geom_ros.common.packed_bits import set_bits


def test_bits_are_set_as_in_a_matrix_of_flags_and_a_change_is_told():
    rng = np.random.default_rng(5)
    flags = rng.random((7, 64)) < 0.2
    packed = np.packbits(flags, axis=1, bitorder='little')
    for _ in range(20):
        rows, columns = rng.integers(7, size=30), rng.integers(64, size=30)
        was_clear = not flags[rows, columns].all()
        flags[rows, columns] = True
        assert set_bits(packed, rows, columns) == was_clear
        assert not set_bits(packed, rows, columns)
        assert np.array_equal(packed, np.packbits(flags, axis=1, bitorder='little'))


def test_none_are_set_where_none_are_named():
    packed, none = np.zeros((2, 1), dtype=np.uint8), np.zeros(0, dtype=np.int64)
    assert not set_bits(packed, none, none)
    assert not packed.any()
