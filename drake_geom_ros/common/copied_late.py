"""An array that copies share until one of them is to write into it.

The bits of 16 000 geometries with filters are 67 MB. A copy of a scene is made for every change of
a large one and every what-if, while cycles wait, and hardly any of them writes filters.
"""

from __future__ import annotations

from typing import Generic, TypeVar
from weakref import WeakSet

import numpy as np
from numpy.typing import NDArray

_Scalar = TypeVar('_Scalar', bound=np.generic)


class CopiedLate(Generic[_Scalar]):
    """Holds an array; ``copy`` costs nothing, and the first ``writable`` of either copies it.

    Two threads may each have one of the copies. Making a copy and writing into the original
    exclude each other by the caller's means, as for any array.
    """

    def __init__(self, array: NDArray[_Scalar]) -> None:
        self.array = array  # to be read only
        self._sharers: WeakSet[CopiedLate[_Scalar]] = WeakSet([self])

    def copy(self) -> CopiedLate[_Scalar]:
        """Return one with the same content, which later writes here do not change."""
        other = CopiedLate(self.array)
        other._sharers = self._sharers
        self._sharers.add(other)
        return other

    def writable(self) -> NDArray[_Scalar]:
        """Return the array, which no other one shares any more."""
        if len(self._sharers) > 1:
            array = self.array.copy()
            self._sharers.discard(self)  # now, for the others write in place once they are alone
            self.array, self._sharers = array, WeakSet([self])
        return self.array

    def __reduce__(self) -> tuple[type[CopiedLate[_Scalar]], tuple[NDArray[_Scalar]]]:
        return CopiedLate, (self.array,)
