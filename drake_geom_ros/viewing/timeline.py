"""Motion over time: poses at a moment, and how near things come on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.frame_names import Frame
from drake_geom_ros.geometry import FrameId, FramePoseVector, QueryObject, SceneGraphContext
from drake_geom_ros.trajectories.motion import Motion

Floats = NDArray[np.float64]
_MOST_LOOKS = 400  # moments of a motion at which the least distance is computed
_FIRST_REACH = 0.1  # [m]
_FARTHEST = 1000.0  # [m] what is farther apart is looked for without a limit


class Timeline:
    """``times`` (n,) [s] of a motion, and ``poses(t)`` of its frames at any of them."""

    def __init__(self, times: Floats, poses: Callable[[float], FramePoseVector]) -> None:
        self.times = times
        self.poses = poses

    @classmethod
    def of_motion(cls, motion: Motion, frames: Mapping[Frame, FrameId]) -> Timeline:
        """Return that of a motion file; ``frames`` are the scene's, by source and name."""
        ids = [frames[source, f] for source, own in motion.frame_names.items() for f in own]

        def poses(time: float) -> FramePoseVector:
            rows = motion.poses(time)
            return FramePoseVector.FromArrays(
                ids, np.concatenate([rows[source] for source in motion.frame_names])
            )

        return cls(np.linspace(0.0, motion.duration, _MOST_LOOKS), poses)

    @classmethod
    def of_moments(cls, times: Sequence[float], moments: Sequence[FramePoseVector]) -> Timeline:
        """Return that of poses at times [s], ascending, each of which holds until the next."""
        starts = np.array(times, dtype=np.float64)
        if len(starts) == 0 or (np.diff(starts) <= 0.0).any():
            raise ValueError(f'times must ascend, and there must be one: {starts[:10].tolist()}')

        def poses(time: float) -> FramePoseVector:
            return moments[max(0, int(np.searchsorted(starts, time, side='right')) - 1)]

        return cls(starts, poses)

    @property
    def start(self) -> float:
        """The first time [s]."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """The last time [s]."""
        return float(self.times[-1])


def least_distances(timeline: Timeline, context: SceneGraphContext) -> Iterator[float]:
    """Yield the least certified lower bound [m] at each time; infinite where no pair is left.

    Poses ``context``, which nobody else may use meanwhile.
    """
    query = QueryObject(context)
    reach = _FIRST_REACH
    for time in timeline.times.tolist():
        context.UpdateFramePoses(timeline.poses(time))
        least = least_distance(query, reach)
        # The next moment is like this one: look a little farther than its answer.
        reach = max(_FIRST_REACH, 2.0 * least) if np.isfinite(least) else reach
        yield least


def least_distance(query: QueryObject, reach: float) -> float:
    """Return the least certified lower bound [m] of all pairs, sought from ``reach`` [m] on.

    A limit spares the query the far pairs; where it finds none, the next one is twice as far.
    """
    while reach < _FARTHEST:
        found = query.ComputeSignedDistancePairwiseClosestPoints(reach)
        if len(found):
            return float((found.distance - found.error_bound).min())
        reach *= 2.0
    found = query.ComputeSignedDistancePairwiseClosestPoints()
    return float((found.distance - found.error_bound).min(initial=np.inf))
