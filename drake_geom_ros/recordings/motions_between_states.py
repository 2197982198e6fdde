"""Certification of the recorded motion from each state to the next, as by ``CheckMotion``.

Each frame moves straight from its pose in one state to that in the next, and turns about one axis
by the shorter way. Frames that a message does not pose rest until their sender's next message.
"""

from __future__ import annotations

import math
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch import LeastDistances
from drake_geom_ros.batch.running import cores
from drake_geom_ros.geometry import AccuracyLike
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries, MotionQuestion
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import matrices_from_poses
from drake_geom_ros.recordings.raw_messages import NANOSECONDS
from drake_geom_ros.recordings.states import Block

Codes = NDArray[np.int8]
UNKNOWN, CLEAR, CONTACT = 0, 1, 2
_CODES = {'unknown': UNKNOWN, 'clear': CLEAR, 'contact': CONTACT}
_PART = 64  # motions that a thread takes at once


class Motions:
    """Certifies motions of a set of pairs, block by block.

    ``take`` returns for each state a code of the motion from the previous one, and the certified
    lower bound [m] if it is clear, else nan. The motion is unknown for the first state, and after
    a gap, another scene or an incomplete state.
    """

    def __init__(
        self, number: int, tolerance: float, accuracy: AccuracyLike, longest: float, threads: int
    ) -> None:
        """Certify motions of the set of pairs with index ``number``.

        Bounds are at most ``tolerance`` [m] below the distances at states; motions that take
        longer than ``longest`` [s] are unknown.
        """
        self._number, self._accuracy, self._threads = number, accuracy, threads or cores()
        self._question = MotionQuestion(bound_tolerance=tolerance)
        self._longest = longest
        self._before: Block | None = None

    def take(self, block: Block, distances: LeastDistances | None) -> tuple[Codes, Floats]:
        """Return codes and bounds (N,) of a block's states with their ``distances``."""
        codes = np.full(len(block.times), UNKNOWN, dtype=np.int8)
        bounds = np.full(len(block.times), np.nan)
        before, self._before = self._before, block
        if distances is None or block.selected[self._number].left_out:
            return codes, bounds
        first = 1
        poses, times, ages = block.poses, block.times, block.ages[:, self._number]
        if before is not None and before.context is block.context:
            first = 0
            poses = np.concatenate((before.poses[-1:], poses))
            times = np.append(before.times[-1], times)
            ages = np.append(before.ages[-1, self._number], ages)
        fresh = ages <= self._longest
        is_known = fresh[:-1] & fresh[1:] & (np.diff(times) <= self._longest * NANOSECONDS)
        moves = (poses[:-1] != poses[1:]).any(axis=(1, 2))
        own_codes, own_bounds = codes[first:], bounds[first:]
        lower = (distances.distance - distances.error_bound)[first:]
        rests = is_known & ~moves
        own_codes[rests] = np.where(lower[rests] > 0.0, CLEAR, CONTACT)
        own_bounds[rests] = np.where(lower[rests] > 0.0, lower[rests], np.nan)
        moving = np.flatnonzero(is_known & ~rests)
        if moving.size:
            self._prove(block, poses, moving, own_codes, own_bounds, lower)
        return codes, bounds

    def pass_over(self, block: Block) -> None:
        """Skip a block whose motions are stored already."""
        self._before = block

    def _prove(
        self,
        block: Block,
        poses: Floats,
        motions: NDArray[np.int64],
        codes: Codes,
        bounds: Floats,
        lower: Floats,
    ) -> None:
        """Fill codes and bounds of ``motions``, from rows of poses to the next rows."""
        context = block.narrowed(block.selected[self._number])
        scene, _ = PackedScene.of(context, block.frames, about_points=False)
        # No moving geometry is in a pair of the set, so the distances at states hold.
        if not scene.has_moving_pairs() and not len(scene.half_spaces):
            codes[motions] = np.where(lower[motions] > 0.0, CLEAR, CONTACT)
            bounds[motions] = np.where(lower[motions] > 0.0, lower[motions], np.nan)
            return
        Rs, ps = matrices_from_poses(poses.reshape(-1, 7))
        rows = np.hstack((Rs.reshape(-1, 9), ps)).reshape(len(poses), -1, 12)
        stop, own = np.zeros(1, dtype=np.int64), threading.local()

        def prove(part: NDArray[np.int64]) -> None:
            if not hasattr(own, 'queries'):
                own.queries = MotionQueries(scene, self._accuracy, stop)
            for k in part.tolist():
                check = own.queries.move(self._question, rows[k], rows[k + 1], 'slerp')
                codes[k] = _CODES[check.outcome]
                bounds[k] = check.lower_bound if check.outcome == 'clear' else math.nan

        parts = [motions[k : k + _PART] for k in range(0, len(motions), _PART)]
        with ThreadPoolExecutor(self._threads) as pool:
            try:
                list(pool.map(prove, parts))
            except BaseException:
                stop[0] = 1
                raise
            finally:
                pool.shutdown(cancel_futures=True)
