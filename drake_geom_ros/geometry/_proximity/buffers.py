"""Arrays for large answers, used again once nobody holds the answer.

Fresh memory costs a page fault every 4 kB, which for the answers of all pairs of a scene takes as
long as computing them. What somebody holds, or shows a part of, is never written to again: that is
told by the count of references to the array.
"""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

SMALL = 2**18  # [bytes] below it the allocator keeps the memory itself
MOST_KEPT = 2**24  # [bytes] of one array; larger ones are given back, as a node stays for days
_PLACES = 6  # answers of three arrays, of which the last one is still held when the next is made
_KEPT_ALONE = [object()]
UNHELD = sys.getrefcount(_KEPT_ALONE[0])  # of what a list alone holds: interpreters differ


class Buffers:
    """Gives out arrays of which nobody else holds a part."""

    def __init__(self) -> None:
        self._kept: list[NDArray[np.uint8]] = []

    def empty(self, shape: tuple[int, ...], dtype: type[Any] = np.float64) -> NDArray[Any]:
        """Return an array of this shape; what is in it is left from before."""
        size = 8 * math.prod(shape)  # of the largest type
        if not SMALL <= size <= MOST_KEPT:
            return np.empty(shape, dtype)
        size = math.prod(shape) * np.dtype(dtype).itemsize
        found: NDArray[Any] = self._octets(size)[:size].view(dtype).reshape(shape)
        return found

    def _octets(self, size: int) -> NDArray[np.uint8]:
        """Return so many bytes or more, of an answer that is gone if there is one."""
        kept = self._kept
        for place in range(len(kept)):
            if len(kept[place]) >= size and sys.getrefcount(kept[place]) == UNHELD:
                found = kept.pop(place)
                break
        else:
            found = np.empty(size + size // 4, np.uint8)
        kept.append(found)  # the one that was used last is the last to go
        del kept[: len(kept) - _PLACES]
        return found

    def __getstate__(self) -> dict[str, object]:
        return {'_kept': []}  # a copy has its own
