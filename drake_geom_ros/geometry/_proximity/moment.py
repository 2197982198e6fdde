"""Where everything was when a query was answered, for what is asked of its results later.

Hardly anybody asks for derivatives, and to copy the orientations of 1000 bodies for each query
takes 2 us. So a moment shows the arrays of the world until these change: then it is given copies,
if a result still holds it.
"""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Results may be asked in one thread while the poses change in another: a copy is whole.
_copying = threading.Lock()


class Posed(NamedTuple):
    """The shapes and where they were when a query was answered."""

    ids: Indices  # (n,) of the geometries, ascending
    types: Indices
    starts: Indices
    pool: Floats
    frames: Indices  # (n,) rows of the frames
    R_WGs: Floats  # (n, 3, 3)
    frame_ids: Indices  # (nf,)
    p_WFs: Floats  # (nf, 3) [m]


class Moment:
    """What ``Posed`` tells, the last poses of a world until it moves on."""

    __slots__ = ('__weakref__', '_kept', '_posed')

    def __init__(self, posed: Posed) -> None:
        """Show the arrays of a world, which calls ``keep`` before it changes them."""
        self._posed, self._kept = posed, False

    def keep(self) -> None:
        """Have arrays of its own from now on; the tables of shapes never change."""
        with _copying:
            if not self._kept:
                posed = self._posed
                self._posed = Posed(  # in order, for _replace takes a microsecond more
                    posed.ids,
                    posed.types,
                    posed.starts,
                    posed.pool,
                    posed.frames,
                    posed.R_WGs.copy(),
                    posed.frame_ids,
                    posed.p_WFs.copy(),
                )
                self._kept = True

    def posed(self) -> Posed:
        """Return the shapes as they were then."""
        self.keep()
        return self._posed
