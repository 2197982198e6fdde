"""Moments of minimum distance with all poses, collected while states are processed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drake_geom_ros.geometry import FramePoseVector, QueryObject
from drake_geom_ros.recordings.set_clearance import Moment, SetClearance
from drake_geom_ros.recordings.states import Block

_APART = 0.02  # fraction of the duration, in which there is at most one closest moment


@dataclass(frozen=True, eq=False)
class CloseMoment:
    """A state whose lower bound is a local minimum over time."""

    moment: Moment
    left_out: int  # pairs omitted for lack of a pose
    is_stale: bool
    age: float  # [s] of the oldest pose used by its pairs
    block: Block  # of only this state
    lower_bound: float  # [m] over the known pairs

    def scene(self) -> QueryObject | None:
        """Return the scene at that time; None if a frame had no pose."""
        if self.block.waiting:
            return None
        context = self.block.context.what_if()
        X_PFs = FramePoseVector.FromArrays(self.block.frames, self.block.poses[0])
        context.UpdateFramePoses(X_PFs)
        return QueryObject(context)


class CloseMoments:
    """Finds the closest moments of a set of pairs, block by block, one for each time span."""

    def __init__(self, duration: float) -> None:
        """Divide the ``duration`` [s] of the recording into time spans."""
        self._apart = _APART * duration or 1.0
        self._least: dict[int, CloseMoment] = {}

    def take(self, block: Block, pairs: SetClearance) -> None:
        """Process the states of a block; of incomplete ones the known pairs count."""
        lower = pairs.known_lower_bound
        states = np.flatnonzero(lower < np.inf)
        spans = (pairs.times[states] / self._apart).astype(np.int64)
        order = np.lexsort((lower[states], spans))
        firsts = order[np.flatnonzero(np.diff(spans[order], prepend=-1))]  # the minimum of each
        for k, span in zip(states[firsts].tolist(), spans[firsts].tolist(), strict=True):
            least = self._least.get(span)
            if least is None or lower[k] < least.lower_bound:
                self._least[span] = CloseMoment(
                    moment=pairs.at(k),
                    left_out=int(pairs.left_out[k]),
                    is_stale=bool(pairs.is_stale[k]),
                    age=float(pairs.age[k]),
                    block=block.alone(k),
                    lower_bound=float(lower[k]),
                )

    def result(self) -> tuple[CloseMoment, ...]:
        """Return the moments that are closer than those of both adjacent spans, closest first."""

        def bound(span: int) -> float:
            least = self._least.get(span)
            return np.inf if least is None else least.lower_bound

        chosen = [
            each
            for span, each in sorted(self._least.items())
            if each.lower_bound <= bound(span - 1) and each.lower_bound < bound(span + 1)
        ]
        return tuple(sorted(chosen, key=lambda each: each.lower_bound))
