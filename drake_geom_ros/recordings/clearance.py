"""``clearance``: a recording, one call."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch import LeastDistances, evaluate
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.motions import Codes, Motions
from drake_geom_ros.recordings.opened import Opened, opened_recording
from drake_geom_ros.recordings.pair_sets import AskedPairs, Between, PairSet, pair_sets
from drake_geom_ros.recordings.player import Player
from drake_geom_ros.recordings.results import Clearances, SetClearance, Span
from drake_geom_ros.recordings.states import Block, StateBlocks, Travelled
from drake_geom_ros.recordings.storages import NANOSECONDS
from drake_geom_ros.recordings.topics import Topics, told_nothing
from drake_geom_ros.scene_files import SceneDescription

Progress = Callable[[int, float], None]  # states, seconds of the recording
STALE_AFTER = 1.0  # [s] the node's default


def clearance(
    path: str | Path | Sequence[str | Path],
    scene: str | Path | SceneDescription | None = None,
    *,
    between: Sequence[Between] = (),
    max_distance: float = math.inf,
    rate: float = 0.0,
    topics: Topics | None = None,
    stale_after: float = STALE_AFTER,
    accuracy: str = 'exact',
    world_frame: str = 'world',
    package_roots: Sequence[str | Path] = (),
    threads: int = 0,
    certify: float = 0.0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Clearances:
    """Return the least distances over the time of a recording.

    ``path`` is a file (MCAP or sqlite3), a folder that rosbag2 wrote, or several of these;
    ``scene`` a scene file, or None for the robot whose description was recorded. ``between`` are
    sets of pairs such as ``'left:right'``, by names or patterns of sources, frames or geometries;
    without any, all pairs are the set ``'all'``. A state is taken with each message that poses
    something, or ``rate`` times a second [Hz]. ``topics`` says what was recorded where.
    ``stale_after`` [s], ``accuracy``, ``world_frame`` and ``package_roots`` are what a node has as
    parameters, ``threads`` and ``max_distance`` [m] what ``batch.evaluate`` has.

    With ``certify`` [m] the motion between states is proved, too: see ``SetClearance``. Its bounds
    are no farther than that below what was seen. It takes a state with each message: motions from
    one moment of a ``rate`` to the next would leave out what was recorded between them.

    ``executor`` computes distances in the place of threads, as of ``batch.cluster_executor``.
    ``progress`` is called with the states so far, and the seconds of the recording.

    Poses come to be as in a node that took the same messages at the times of recording. Poses do
    not stay in memory; an answer takes 110 bytes a state and set.

    Raises RecordingError for what cannot be read or used, SceneFileError for a scene file,
    ArgumentError for other arguments.

        found = clearance('run.mcap', 'cell.yaml', between=['left:right'])
        assert found.least().distance > 0.05
    """
    if not (math.isfinite(rate) and rate >= 0.0):
        raise ArgumentError(f'rate={rate} must be finite and >= 0 [Hz]; 0: with each message')
    if not stale_after > 0.0 or math.isnan(max_distance):
        raise ArgumentError(
            f'stale_after={stale_after} must be > 0 [s], max_distance={max_distance} no nan [m]'
        )
    if not 0.0 <= certify < math.inf:
        raise ArgumentError(f'certify={certify} must be a distance >= 0 [m]; 0: not')
    if certify and rate:
        raise ArgumentError(
            f'certify={certify} proves motions from message to message, rate={rate} leaves out '
            'poses between its moments: give one of the two'
        )
    sets = pair_sets(between)
    opened = opened_recording(
        *(path, scene, topics, stale_after, accuracy, world_frame, package_roots)
    )
    motions = [
        Motions(k, certify, accuracy, stale_after, threads) if certify else None
        for k in range(len(sets))
    ]
    run = _Run(opened, sets, stale_after)
    answers = [_Answers(pairs) for pairs in run.pairs]
    start, computing = time.perf_counter(), 0.0
    travelled = Travelled()
    for block in run.blocks(rate):
        travelled.take(block)
        began = time.perf_counter()
        for k, each in enumerate(answers):
            least = _least(*(block, block.asked[k], max_distance, accuracy, threads, executor))
            motion = motions[k]
            each.add(block, k, least, None if motion is None else motion.take(block, least))
        computing += time.perf_counter() - began
        if progress is not None:
            recorded = (int(block.times[-1]) - run.player.begin) / NANOSECONDS
            progress(run.player.count, recorded)
    reading = time.perf_counter() - start - computing
    return run.result(answers, travelled.all(), max_distance, (reading, computing))


def _least(
    block: Block,
    pairs: AskedPairs,
    max_distance: float,
    accuracy: str,
    threads: int,
    executor: Executor | None,
) -> LeastDistances | None:
    """Return the least distances of a block; None where no pair is known."""
    if not pairs.considered.any():
        return None
    found = evaluate(
        *(block.narrowed(pairs), block.frames, block.poses),
        max_distance=max_distance,
        accuracy=accuracy,
        threads=threads,
        executor=executor,
    )
    assert isinstance(found, LeastDistances)
    return found


class _Run:
    """One pass through a recording."""

    def __init__(self, opened: Opened, pairs: tuple[PairSet, ...], stale_after: float) -> None:
        self.opened = opened
        self.pairs, self.stale_after = pairs, stale_after

    def blocks(self, rate: float) -> Iterator[Block]:
        """Yield the states in blocks; raises RecordingError where there are none."""
        recording, playback, roles = self.opened
        self.player = Player(self.opened, StateBlocks(playback, self.pairs), rate)
        yield from self.player.blocks()
        if not self.player.count:
            troubles = [trouble.words for trouble in playback.troubles][:5]
            raise RecordingError(
                'nothing that was recorded poses anything of the scene; '
                + '; '.join([told_nothing(recording.topics, roles), *troubles])
            )

    def result(
        self,
        answers: Sequence[_Answers],
        travelled: NDArray[np.float64],
        max_distance: float,
        seconds: tuple[float, float],
    ) -> Clearances:
        """Return what was found."""
        stamps = answers[0].joined('stamps')
        begin, end = self.player.begin, self.player.end
        times = (stamps - begin) / NANOSECONDS
        return Clearances(
            times=times,
            stamps=stamps,
            travelled=travelled,
            sets={each.pairs.name: each.result(times, self.stale_after) for each in answers},
            begin=begin,
            end=end,
            gaps=_gaps(times, (end - begin) / NANOSECONDS, self.stale_after),
            damage=tuple(self.opened.recording.damage),
            refused=tuple(self.opened.playback.refused),
            troubles=tuple(self.opened.playback.troubles),
            stale_after=self.stale_after,
            max_distance=max_distance,
            seconds_reading=seconds[0],
            seconds_computing=seconds[1],
        )


def _gaps(times: NDArray[np.float64], duration: float, longest: float) -> tuple[Span, ...]:
    """Return where no state is for longer than that, from the beginning to the end."""
    ends = np.concatenate(([0.0], times, [duration]))
    places = np.flatnonzero(np.diff(ends) > longest)
    return tuple(Span(float(ends[k]), float(ends[k + 1])) for k in places)


class _Answers:
    """What was found about a set of pairs, block by block."""

    def __init__(self, pairs: PairSet) -> None:
        self.pairs = pairs
        self._columns: dict[str, list[NDArray[Any]]] = {}
        self._names: dict[str, int] = {}
        self._waiting: dict[str, None] = {}

    def add(
        self,
        block: Block,
        number: int,
        found: LeastDistances | None,
        motion: tuple[Codes, NDArray[np.float64]] | None,
    ) -> None:
        """Take the answers about a block, None where no pair is known, and about its motion."""
        count, asked = len(block.times), block.asked[number]
        nothing, nowhere = np.full(count, np.nan), np.full((count, 3), np.nan)
        columns: dict[str, NDArray[Any]] = {
            'stamps': block.times,
            'known_distance': nothing if found is None else found.distance,
            'known_error_bound': nothing if found is None else found.error_bound,
            'p_WCa': nowhere if found is None else found.p_WCa,
            'p_WCb': nowhere if found is None else found.p_WCb,
            'age': block.ages[:, number],
            'left_out': np.full(count, asked.left_out, dtype=np.int64),
        }
        if motion is not None:
            columns['motion'], columns['motion_bound'] = motion
        for side in ('A', 'B'):
            columns[f'geometry_{side}'] = self._places(found, side, count)
        for name, values in columns.items():
            self._columns.setdefault(name, []).append(values)
        inspector = block.context_query().inspector()
        self._waiting.update((inspector.full_name(frame), None) for frame in asked.waiting)

    def _places(self, found: LeastDistances | None, side: str, count: int) -> NDArray[np.int32]:
        """Return the places of geometries among the names, -1 for none."""
        if found is None:
            return np.full(count, -1, dtype=np.int32)
        values, each = np.unique(getattr(found, f'id_{side}'), return_inverse=True)
        names = found.names_of(values).tolist()
        places = [self._names.setdefault(n, len(self._names)) if n else -1 for n in names]
        return np.array(places, dtype=np.int32)[each]

    def joined(self, name: str) -> NDArray[Any]:
        """Return a column of all blocks."""
        return np.concatenate(self._columns[name])

    def result(self, times: NDArray[np.float64], stale_after: float) -> SetClearance:
        """Return all of it."""
        columns = {name: self.joined(name) for name in self._columns if name != 'stamps'}
        return SetClearance(
            name=self.pairs.name,
            times=times,
            names=tuple(self._names),
            waiting_frames=tuple(self._waiting),
            is_stale=columns['age'] > stale_after,
            **columns,
        )
