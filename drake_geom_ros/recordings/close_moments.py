"""The moments in which things came closest, with the poses of all, kept while states go by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_geom_ros.geometry import FramePoseVector, QueryObject
from drake_geom_ros.recordings.set_clearance import Moment, SetClearance
from drake_geom_ros.recordings.states import Block

_APART = 0.02  # of the duration: in a span of that there is one closest moment at most


@dataclass(frozen=True, eq=False)
class CloseMoment:
    """A state whose lower bound is the least for a while."""

    moment: Moment
    left_out: int  # pairs that wait for a pose
    is_stale: bool
    age: float  # [s] of the oldest pose that matters
    block: Block  # of this state alone
    lower_bound: float  # [m] by what is known

    def scene(self) -> QueryObject | None:
        """Return the scene then; None where a frame waited: nobody knows where that was."""
        if self.block.waiting:
            return None
        context = self.block.context.what_if()
        X_PFs = FramePoseVector.FromArrays(self.block.frames, self.block.poses[0])
        context.UpdateFramePoses(X_PFs)
        return QueryObject(context)


class CloseMoments:
    """Finds them of a set of pairs, block by block; of each span of time the least one is kept."""

    def __init__(self, duration: float) -> None:
        """``duration`` [s] of the recording."""
        self._apart = _APART * duration or 1.0
        self._least: dict[int, CloseMoment] = {}

    def take(self, block: Block, pairs: SetClearance) -> None:
        """Take the states of a block. Of those that do not tell all what is known counts, too."""
        lower = pairs.known_lower_bound
        states = np.flatnonzero(lower < np.inf)
        spans = (pairs.times[states] / self._apart).astype(np.int64)
        order = np.lexsort((lower[states], spans))
        firsts = order[np.flatnonzero(np.diff(spans[order], prepend=-1))]  # the least of each
        for k, span in zip(states[firsts].tolist(), spans[firsts].tolist(), strict=True):
            known = self._least.get(span)
            if known is None or lower[k] < known.lower_bound:
                self._least[span] = CloseMoment(
                    moment=pairs.at(k),
                    left_out=int(pairs.left_out[k]),
                    is_stale=bool(pairs.is_stale[k]),
                    age=float(pairs.age[k]),
                    block=block.alone(k),
                    lower_bound=float(lower[k]),
                )

    def result(self) -> tuple[CloseMoment, ...]:
        """Return those that are nearer than what is beside them, the closest one first."""

        def bound(span: int) -> float:
            known = self._least.get(span)
            return np.inf if known is None else known.lower_bound

        chosen = [
            each
            for span, each in sorted(self._least.items())
            if each.lower_bound <= bound(span - 1) and each.lower_bound < bound(span + 1)
        ]
        return tuple(sorted(chosen, key=lambda each: each.lower_bound))
