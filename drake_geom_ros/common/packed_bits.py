"""Bits of a matrix that are packed by eight along its rows, lowest first."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def set_bits(packed: NDArray[np.uint8], rows: NDArray[np.int_], columns: NDArray[np.int_]) -> bool:
    """Set bits (n,) of a matrix (m, k), which holds 8 k columns; return whether one was clear."""
    at = rows, columns >> 3
    flags = (1 << (columns & 7)).astype(np.uint8)
    was_clear = bool(np.any(packed[at] & flags == 0))
    np.bitwise_or.at(packed, at, flags)
    return was_clear
