"""One pass through a recording, which computes the distances of its states block by block."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch import LeastDistances, evaluate
from drake_geom_ros.geometry import AccuracyLike, ArgumentError
from drake_geom_ros.recordings.close_moments import CloseMoments
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.motions_between_states import Motions
from drake_geom_ros.recordings.opened import Opened
from drake_geom_ros.recordings.pair_sets import PairSet
from drake_geom_ros.recordings.player import Player
from drake_geom_ros.recordings.raw_messages import NANOSECONDS
from drake_geom_ros.recordings.recording_topics import topics_remark
from drake_geom_ros.recordings.results import Facts, StateMinima
from drake_geom_ros.recordings.set_clearance import SetClearance, Span
from drake_geom_ros.recordings.states import Block, StateBlocks, Travelled
from drake_geom_ros.recordings.stored_states import StoredStates

Progress = Callable[[int, float], None]  # states, seconds of the recording
STALE_AFTER = 1.0  # [s] the node's default


@dataclass(frozen=True)
class RunOptions:
    """Options of a run, as arguments of ``clearance``; raises ArgumentError for invalid ones."""

    sets: tuple[PairSet, ...]
    max_distance: float = math.inf  # [m]
    rate: float = 0.0  # [Hz]
    stale_after: float = STALE_AFTER  # [s]
    accuracy: AccuracyLike = 'exact'
    certify: float = 0.0  # [m]

    def __post_init__(self) -> None:
        if not (math.isfinite(self.rate) and self.rate >= 0.0):
            raise ArgumentError(
                f'rate={self.rate} must be finite and >= 0 [Hz]; 0: with each message'
            )
        if not self.stale_after > 0.0 or math.isnan(self.max_distance):
            raise ArgumentError(
                f'stale_after={self.stale_after} must be > 0 [s], '
                f'max_distance={self.max_distance} no nan [m]'
            )
        if not 0.0 <= self.certify < math.inf:
            raise ArgumentError(f'certify={self.certify} must be a distance >= 0 [m]; 0: not')
        if self.certify and self.rate:
            raise ArgumentError(
                f'certify={self.certify} proves motions from message to message, '
                f'rate={self.rate} leaves out poses between its moments: give one of the two'
            )


class Run:
    """One pass through a recording: ``parts`` first, and then ``facts``."""

    def __init__(
        self,
        opened: Opened,
        options: RunOptions,
        *,
        threads: int = 0,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Prepare to play a recording, which was not played yet, and is not played elsewhere."""
        self._opened, self._options = opened, options
        self._threads, self._executor, self._progress = threads, executor, progress
        self._player = Player(opened, StateBlocks(opened.playback, options.sets), options.rate)
        self._motions = [
            Motions(k, options.certify, options.accuracy, options.stale_after, threads)
            for k in range(len(options.sets) if options.certify else 0)
        ]
        self._travelled = Travelled()
        duration = (self._player.end - self._player.begin) / NANOSECONDS
        self._moments = {pairs.name: CloseMoments(duration) for pairs in options.sets}
        self._gaps: list[Span] = []
        self._silence = Span(0.0, 0.0)  # the longest time without a state
        self._last = 0.0  # [s] of the last state
        self._seconds = self._computing = 0.0

    def parts(self, stored: StoredStates | None = None) -> Iterator[StateMinima]:
        """Yield the states with their distances; raises RecordingError if there are none.

        Blocks that are ``stored`` by another pass are not computed again; new ones are added.
        """
        start = time.perf_counter()
        for block in self._player.blocks():
            question = '' if stored is None else self._question(block)
            began = time.perf_counter()
            travelled = self._travelled.take(block)
            states = None if stored is None else stored.find(question)
            if states is None:
                states = self._computed(block, travelled)
                if stored is not None:
                    stored.add(question, states)
            else:
                for motions in self._motions:
                    motions.pass_over(block)
            self._take(block, states)
            self._computing += time.perf_counter() - began
            if self._progress is not None:
                self._progress(self._player.count, float(states.times[-1]))
            yield states
        self._seconds = time.perf_counter() - start
        if not self._player.count:
            recording, roles = self._opened.recording, self._opened.roles
            troubles = [trouble.words for trouble in self._opened.playback.troubles][:5]
            raise RecordingError(
                'nothing that was recorded poses anything of the scene; '
                + '; '.join([topics_remark(recording.topics, roles), *troubles])
            )

    def facts(self) -> Facts:
        """Return the facts about the recording, after all ``parts`` were taken."""
        begin, end = self._player.begin, self._player.end
        self._note_gaps(np.array([(end - begin) / NANOSECONDS]))
        return Facts(
            begin=begin,
            end=end,
            gaps=tuple(self._gaps),
            silence=self._silence,
            damage=tuple(self._opened.recording.damage),
            refused=tuple(self._opened.playback.refused),
            maps=self._opened.maps,
            differences=self._opened.playback.differences(),
            troubles=tuple(self._opened.playback.troubles),
            stale_after=self._options.stale_after,
            max_distance=self._options.max_distance,
            travelled_in_all=self._travelled.in_all,
            seconds_reading=self._seconds - self._computing,
            seconds_computing=self._computing,
            moments={name: each.result() for name, each in self._moments.items()},
        )

    def _take(self, block: Block, states: StateMinima) -> None:
        """Update the closest moments and gaps of the whole recording."""
        for name, moments in self._moments.items():
            moments.take(block, states.sets[name])
        self._note_gaps(states.times)

    def _note_gaps(self, times: NDArray[np.float64]) -> None:
        """Add the gaps between states that are longer than ``stale_after``."""
        ends = np.append(self._last, times)
        silences = np.diff(ends)
        k = int(np.argmax(silences))
        if silences[k] > self._silence.end - self._silence.begin:
            self._silence = Span(float(ends[k]), float(ends[k + 1]))
        for k in np.flatnonzero(silences > self._options.stale_after).tolist():
            self._gaps.append(Span(float(ends[k]), float(ends[k + 1])))
        self._last = float(ends[-1])

    def _question(self, block: Block) -> str:
        """Return a digest of a block and its robot files, to recognise stored states."""
        digests = self._opened.playback.robot_files
        files = sorted((str(path), digest) for path, digest in digests.items())
        return sha256(f'{block.digest()} {files}'.encode()).hexdigest()

    def _computed(self, block: Block, travelled: NDArray[np.float64]) -> StateMinima:
        """Return the states of a block with their distances."""
        times = (block.times - self._player.begin) / NANOSECONDS
        sets = {
            pairs.name: self._of_set(block, number, times)
            for number, pairs in enumerate(self._options.sets)
        }
        return StateMinima(times, block.times, travelled, sets)

    def _of_set(self, block: Block, number: int, times: NDArray[np.float64]) -> SetClearance:
        least, count, selected = self._least(block, number), len(times), block.selected[number]
        nothing, nowhere = np.full(count, np.nan), np.full((count, 3), np.nan)
        names: dict[str, int] = {}
        columns: dict[str, Any] = {
            'known_distance': nothing if least is None else least.distance,
            'known_error_bound': nothing if least is None else least.error_bound,
            'p_WCa': nowhere if least is None else least.p_WCa,
            'p_WCb': nowhere if least is None else least.p_WCb,
        }
        for side in ('A', 'B'):
            columns[f'geometry_{side}'] = _places(least, side, count, names)
        if self._motions:
            motion = self._motions[number].take(block, least)
            columns['motion'], columns['motion_bound'] = motion
        inspector = block.context_query().inspector()
        ages = block.ages[:, number]
        return SetClearance(
            name=self._options.sets[number].name,
            times=times,
            names=tuple(names),
            age=ages,
            left_out=np.full(count, selected.left_out, dtype=np.int64),
            waiting_frames=tuple(inspector.full_name(frame) for frame in selected.waiting),
            is_stale=ages > self._options.stale_after,
            **columns,
        )

    def _least(self, block: Block, number: int) -> LeastDistances | None:
        """Return the minimum distances of a block; None if no pair is known."""
        pairs = block.selected[number]
        if not pairs.considered.any():
            return None
        distances = evaluate(
            block.narrowed(pairs),
            block.frames,
            block.poses,
            max_distance=self._options.max_distance,
            accuracy=self._options.accuracy,
            threads=self._threads,
            executor=self._executor,
        )
        assert isinstance(distances, LeastDistances)
        return distances


def _places(
    least: LeastDistances | None, side: str, count: int, names: dict[str, int]
) -> NDArray[np.int32]:
    """Return the indices (N,) of geometries in ``names``, -1 for none; add new names."""
    if least is None:
        return np.full(count, -1, dtype=np.int32)
    values, each = np.unique(getattr(least, f'id_{side}'), return_inverse=True)
    geometry_names: Sequence[str] = least.names_of(values).tolist()
    places = [names.setdefault(name, len(names)) if name else -1 for name in geometry_names]
    return np.array(places, dtype=np.int32)[each]
