"""Timeline of a motion: poses at a time, and minimum distances over time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from drake_geom_ros.common.frame_names import Frame
from drake_geom_ros.geometry import (
    FrameId,
    FramePoseVector,
    MotionCheck,
    QueryObject,
    SceneGraphContext,
)
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import slerp
from drake_geom_ros.trajectories.motion import Motion

_MOST_LOOKS = 400  # moments of a motion at which the minimum distance is computed
_FIRST_REACH = 0.1  # [m]
_LOOKS_BETWEEN = (0.25, 0.5, 0.75)  # sampled fractions of the time of a piece
_FARTHEST = 1000.0  # [m] pairs that are farther apart are sought without a limit


class Timeline:
    """Poses of frames over time: ``times`` (n,) [s], and ``poses(t)`` at any time.

    ``is_continuous``: frames move between these times; otherwise they rest until the next one.
    ``names_all``: frames that ``poses(t)`` does not name have no pose then.
    """

    def __init__(
        self,
        times: Floats,
        poses: Callable[[float], FramePoseVector],
        *,
        is_continuous: bool,
        names_all: bool = False,
    ) -> None:
        self.times = times
        self.poses = poses
        self.is_continuous = is_continuous
        self.names_all = names_all

    @classmethod
    def of_motion(
        cls, motion: Motion, frames: Mapping[Frame, FrameId], moments: int = _MOST_LOOKS
    ) -> Timeline:
        """Return the timeline of a motion; ``frames`` are the scene's, by source and name."""
        ids = [frames[source, f] for source, own in motion.frame_names.items() for f in own]

        def poses(time: float) -> FramePoseVector:
            rows = motion.poses(time)
            return FramePoseVector.FromArrays(
                ids, np.concatenate([rows[source] for source in motion.frame_names])
            )

        return cls(np.linspace(0.0, motion.duration, moments), poses, is_continuous=True)

    @classmethod
    def of_moments(
        cls,
        times: Sequence[float],
        moments: Sequence[FramePoseVector],
        *,
        names_all: bool = False,
    ) -> Timeline:
        """Return the timeline of poses at ascending times [s], each valid until the next."""
        starts = np.array(times, dtype=np.float64)
        if len(starts) == 0 or (np.diff(starts) <= 0.0).any():
            raise ValueError(f'times must ascend, and there must be one: {starts[:10].tolist()}')

        def poses(time: float) -> FramePoseVector:
            return moments[max(0, int(np.searchsorted(starts, time, side='right')) - 1)]

        return cls(starts, poses, is_continuous=False, names_all=names_all)

    @property
    def start(self) -> float:
        """The first time [s]."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """The last time [s]."""
        return float(self.times[-1])


def least_distances(timeline: Timeline, context: SceneGraphContext) -> Iterator[float]:
    """Yield the minimum certified lower bound [m] at each time; infinite without pairs.

    Poses ``context``, which must not be used otherwise meanwhile.
    """
    for distance, error_bound in least_pairs(timeline, context):
        yield distance - error_bound


def least_pairs(timeline: Timeline, context: SceneGraphContext) -> Iterator[tuple[float, float]]:
    """Yield ``least_pair`` at each time; poses ``context`` like ``least_distances``.

    For a timeline with ``names_all``, NaN while a frame of a pair has no pose.
    """
    query = QueryObject(context)
    reach = _FIRST_REACH
    for time in timeline.times.tolist():
        context.UpdateFramePoses(timeline.poses(time))
        if timeline.names_all and query.num_waiting_pairs():
            yield np.nan, 0.0
            continue
        distance, error_bound = least_pair(query, reach)
        # The next moment is similar, so the search begins a little farther than this result.
        reach = max(_FIRST_REACH, 2.0 * distance) if np.isfinite(distance) else reach
        yield distance, error_bound


def least_distance(query: QueryObject, reach: float) -> float:
    """Return the minimum certified lower bound [m] of all pairs, searched from ``reach`` [m]."""
    distance, error_bound = least_pair(query, reach)
    return distance - error_bound


def least_pair(query: QueryObject, reach: float) -> tuple[float, float]:
    """Return distance and error bound [m] of the pair with the minimum lower bound.

    Infinity and 0 without pairs. A limit, first ``reach`` [m], spares the query distant pairs; it
    is doubled until a pair is found.
    """
    while reach < _FARTHEST:
        pairs = query.ComputeSignedDistancePairwiseClosestPoints(reach)
        if len(pairs):
            break
        reach *= 2.0
    else:
        pairs = query.ComputeSignedDistancePairwiseClosestPoints()
    if not len(pairs):
        return np.inf, 0.0
    k = int(np.argmin(pairs.distance - pairs.error_bound))
    return float(pairs.distance[k]), float(pairs.error_bound[k])


def checks_between(
    timeline: Timeline, context: SceneGraphContext, **options: Any
) -> Iterator[MotionCheck]:
    """Yield ``CheckMotion`` with the options for each of the n - 1 pieces between two times.

    A piece is straight from pose to pose; ``leaves_pieces_by`` returns the deviation of the
    motion itself. Poses ``context``, which must not be used otherwise meanwhile. Raises
    ValueError for a timeline whose frames rest between its times.
    """
    if not timeline.is_continuous:
        raise ValueError('frames of this time line stand between its times, and jump at them')
    context.UpdateFramePoses(timeline.poses(timeline.start))
    for time in timeline.times[1:].tolist():
        end = timeline.poses(time)
        yield QueryObject(context).CheckMotion(end, **options)
        context.UpdateFramePoses(end)


def leaves_pieces_by(timeline: Timeline) -> tuple[float, float]:
    """Return the greatest deviation [m] and [rad] of frames from the straight pieces.

    It is sampled at a quarter, half and three quarters of the time of each piece, in parent
    frames. This is close to the maximum of a smooth motion, and no bound: a frame that makes a
    full turn between two samples appears to rest.
    """
    times, far, turned = timeline.times, 0.0, 0.0
    begins, ends = _rows_at(timeline, times[:-1]), _rows_at(timeline, times[1:])
    q_ends = _nearest_signs(ends[:, 3:], begins[:, 3:])  # by the shorter way
    for share in _LOOKS_BETWEEN:
        sampled = _rows_at(timeline, times[:-1] + share * np.diff(times))
        aside = sampled[:, :3] - begins[:, :3] - share * (ends - begins)[:, :3]
        far = max(far, float(np.linalg.norm(aside, axis=1).max(initial=0.0)))
        straight = slerp(begins[:, 3:], q_ends, share)
        chords = np.linalg.norm(_nearest_signs(sampled[:, 3:], straight) - straight, axis=1)
        turned = max(turned, float(4.0 * np.arcsin(0.5 * chords).max(initial=0.0)))
    return far, turned


def _nearest_signs(qs: Floats, others: Floats) -> Floats:
    """Return the quaternions (n, 4) with signs that make them nearest to ``others``."""
    return np.where(np.sum(qs * others, axis=1, keepdims=True) < 0.0, -qs, qs)


def _rows_at(timeline: Timeline, times: Floats) -> Floats:
    """Return poses (n f, 7), x y z [m] qx qy qz qw, of f frames at times (n,)."""
    moments = [timeline.poses(time) for time in times.tolist()]
    poses = [poses.value(frame).ToArray() for poses in moments for frame in poses.ids()]
    return np.array(poses).reshape(-1, 7)
