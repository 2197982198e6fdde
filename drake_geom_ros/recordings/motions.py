"""What is proved of the recorded motion between one state and the next, by CheckMotion's rules.

Each frame goes straight from where one state has it to where the next one does, and turns about
one axis by the shorter way. What a sender did not tell at a state rests until its next message.
"""

from __future__ import annotations

import math
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch import LeastDistances
from drake_geom_ros.batch.running import cores
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries, MotionQuestion
from drake_geom_ros.geometry.queries.packed_scene import PackedScene
from drake_geom_ros.math.batched import matrices_from_poses
from drake_geom_ros.recordings.raw_messages import NANOSECONDS
from drake_geom_ros.recordings.states import Block

Floats = NDArray[np.float64]
Codes = NDArray[np.int8]
UNKNOWN, CLEAR, CONTACT = 0, 1, 2
_CODES = {'unknown': UNKNOWN, 'clear': CLEAR, 'contact': CONTACT}
_PART = 64  # motions that a thread takes at once


class Motions:
    """Proves motions of a set of pairs, block by block.

    ``take`` gives of each state what is known of the motion to it from the one before: a code,
    and the certified lower bound [m] of a clear one, nan of others. The first state of all, and
    one that follows a gap, another scene, or a state that does not tell all, is unknown.
    """

    def __init__(
        self, number: int, tolerance: float, accuracy: str, longest: float, threads: int
    ) -> None:
        """``tolerance`` [m]: how far bounds may be below what was seen; ``longest`` [s] motion."""
        self._number, self._accuracy, self._threads = number, accuracy, threads or cores()
        self._question = MotionQuestion(bound_tolerance=tolerance)
        self._longest = longest
        self._before: Block | None = None

    def take(self, block: Block, found: LeastDistances | None) -> tuple[Codes, Floats]:
        """Return codes and bounds (N,) of a block's states; ``found`` are their distances."""
        codes = np.full(len(block.times), UNKNOWN, dtype=np.int8)
        bounds = np.full(len(block.times), np.nan)
        before, self._before = self._before, block
        if found is None or block.asked[self._number].left_out:
            return codes, bounds
        first = 1
        poses, times, ages = block.poses, block.times, block.ages[:, self._number]
        if before is not None and before.context is block.context:
            first = 0
            poses = np.concatenate((before.poses[-1:], poses))
            times = np.append(before.times[-1], times)
            ages = np.append(before.ages[-1, self._number], ages)
        fresh = ages <= self._longest
        known = fresh[:-1] & fresh[1:] & (np.diff(times) <= self._longest * NANOSECONDS)
        moves = (poses[:-1] != poses[1:]).any(axis=(1, 2))
        here, there = codes[first:], bounds[first:]
        lower = (found.distance - found.error_bound)[first:]
        rests = known & ~moves
        here[rests] = np.where(lower[rests] > 0.0, CLEAR, CONTACT)
        there[rests] = np.where(lower[rests] > 0.0, lower[rests], np.nan)
        asked = np.flatnonzero(known & ~rests)
        if asked.size:
            self._prove(block, poses, asked, here, there, lower)
        return codes, bounds

    def pass_over(self, block: Block) -> None:
        """Go on behind a block of which all is known already."""
        self._before = block

    def _prove(
        self,
        block: Block,
        poses: Floats,
        asked: NDArray[np.int64],
        codes: Codes,
        bounds: Floats,
        lower: Floats,
    ) -> None:
        """Put what is proved of motions from rows of poses to the next ones."""
        context = block.narrowed(block.asked[self._number])
        scene, _ = PackedScene.of(context, block.frames, about_points=False)
        # Where what moves is in no pair of the set.
        if not scene.has_moving_pairs() and not len(scene.half_spaces):
            codes[asked] = np.where(lower[asked] > 0.0, CLEAR, CONTACT)
            bounds[asked] = np.where(lower[asked] > 0.0, lower[asked], np.nan)
            return
        Rs, ps = matrices_from_poses(poses.reshape(-1, 7))
        rows = np.hstack((Rs.reshape(-1, 9), ps)).reshape(len(poses), -1, 12)
        stop, own = np.zeros(1, dtype=np.int64), threading.local()

        def prove(part: NDArray[np.int64]) -> None:
            if not hasattr(own, 'queries'):
                own.queries = MotionQueries(scene, self._accuracy, stop)
            for k in part.tolist():
                told = own.queries.move(self._question, rows[k], rows[k + 1], 'slerp')
                codes[k] = _CODES[told.outcome]
                bounds[k] = told.lower_bound if told.outcome == 'clear' else math.nan

        parts = [asked[k : k + _PART] for k in range(0, len(asked), _PART)]
        with ThreadPoolExecutor(self._threads) as pool:
            try:
                list(pool.map(prove, parts))
            except BaseException:
                stop[0] = 1
                raise
            finally:
                pool.shutdown(cancel_futures=True)
