"""Where everything was when a query was answered, for what is asked of its results later."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class PosedWorld(NamedTuple):
    """The shapes and where they were when a query was answered."""

    ids: Indices  # (n,) of the geometries, ascending
    types: Indices
    starts: Indices
    pool: Floats
    frames: Indices  # (n,) rows of the frames
    R_WGs: Floats  # (n, 3, 3)
    frame_ids: Indices  # (nf,)
    p_WFs: Floats  # (nf, 3) [m]


class KeptPoses:
    """A ``PosedWorld`` that moves on: of what moves, a copy is made once it is needed.

    Hardly anybody asks for derivatives, and most results are gone when the next poses come. So the
    world has a copy made before anything moves, if a result still refers to this.

    Each query makes one, so it is made without a function of its own: see ``Engine.answer_of``.
    """

    now: PosedWorld  # where everything is; the tables of shapes never change
    _kept: PosedWorld | None = None

    def is_kept(self) -> bool:
        """Tell whether there is a copy, which later poses do not change."""
        return self._kept is not None

    def keep(self) -> PosedWorld:
        """Return the shapes as they are now, or were when this was first asked."""
        if self._kept is None:
            R_WGs, p_WFs = self.now.R_WGs.copy(), self.now.p_WFs.copy()
            # Another thread may have done the same, before it let the world move.
            if self._kept is None:
                self._kept = self.now._replace(R_WGs=R_WGs, p_WFs=p_WFs)
        return self._kept
