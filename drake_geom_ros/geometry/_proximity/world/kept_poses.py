"""Poses at the time of a query, for later computations with its results."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class PosedWorld(NamedTuple):
    """Shapes and their poses at the time of a query."""

    ids: Indices  # (n,) of the geometries, ascending
    types: Indices
    starts: Indices
    pool: Floats
    frames: Indices  # (n,) rows of the frames
    R_WGs: Floats  # (n, 3, 3)
    frame_ids: Indices  # (nf,)
    p_WFs: Floats  # (nf, 3) [m]


class KeptPoses:
    """A copy-on-write ``PosedWorld``: poses are copied only if a result still needs them.

    Derivatives are rarely requested, and most results are gone when the next poses come. So the
    world makes the copy just before anything moves, if a result still refers to this object.

    Every query makes one, so it has no ``__init__``: see ``Engine.answer_of``.
    """

    now: PosedWorld  # the current poses; the tables of shapes never change
    _kept: PosedWorld | None = None

    def is_kept(self) -> bool:
        """Return whether the poses were copied, so that later ones do not change them."""
        return self._kept is not None

    def keep(self) -> PosedWorld:
        """Return the shapes at the poses of the first call of this method."""
        if self._kept is None:
            R_WGs, p_WFs = self.now.R_WGs.copy(), self.now.p_WFs.copy()
            # Another thread may have made the copy, before it moved the world.
            if self._kept is None:
                self._kept = self.now._replace(R_WGs=R_WGs, p_WFs=p_WFs)
        return self._kept
