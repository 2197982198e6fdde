"""Player of a recording that collects its states, by single messages and by runs of messages.

``live/inputs/pose_runs.py`` defines runs, and explains why their states equal those of single
messages. Everything that is not certainly a run is played message by message.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.inputs.pose_runs import PoseRun, Sender, run_of, subjects_of
from drake_geom_ros.live.scene import feeders
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.layouts import Layouts
from drake_geom_ros.recordings.message_types import CLOCK, JOINTS, POSES, TF
from drake_geom_ros.recordings.opened import Opened
from drake_geom_ros.recordings.playback import ClockTimes
from drake_geom_ros.recordings.raw_messages import NANOSECONDS, RecordedTopic
from drake_geom_ros.recordings.recording import Recorded, recorded
from drake_geom_ros.recordings.repeats import MessageBatch, Stretch, TimeFields
from drake_geom_ros.recordings.states import Block, RunStates, StateBlocks

_SHORTEST = 8  # messages of a run, since finding one takes as long as a few messages
_MOST_POSES = 2**19  # of a run: 30 MB, and several times that while it is processed
_MOST_STATES = 10**9  # of a rate, which take hours to compute
_NEVER_A_RUN = 'tf_static', 'tracked_objects'  # roles
_FEEDERS = {JOINTS: feeders.JOINTS, POSES: feeders.MESSAGES, TF: feeders.TF}


class Player:
    """Player of batches of messages, which yields the states in blocks."""

    def __init__(self, opened: Opened, states: StateBlocks, rate: float) -> None:
        """Take states at ``rate`` [Hz]; 0: one with each message that poses something.

        Raises RecordingError if the number of states would be unreasonable.
        """
        self._recording, self._playback = opened.recording, opened.playback
        self._roles = opened.roles
        self._states, self._rate = states, rate
        self._layouts = Layouts()
        # Subjects, by layout, of senders whose last message is still the latest for all of them.
        self._taken: dict[int, frozenset[Any]] = {}
        self._patience = _SHORTEST  # messages to play singly after a failed attempt at a run
        self._first = -1  # the first pose's time [ns]
        self.count = 0  # of states
        # [ns] of the whole recording, so that a sender that falls silent early leaves a gap.
        self.begin, self.end = opened.recording.begin, opened.recording.end
        duration = (self.end - self.begin) / NANOSECONDS
        if duration * rate > _MOST_STATES:
            raise RecordingError(
                f'rate={rate:g} [Hz] makes {duration * rate:.3g} states of a recording that goes '
                f'over {duration:.6g} s, and at most {_MOST_STATES:.0e} can be asked for: is the '
                'time of a message wrong? rate=0 takes a state with each message'
            )

    def blocks(self) -> Iterator[Block]:
        """Yield the states of all messages."""
        for raws in self._recording.batches(list(self._roles)):
            yield from self._play(MessageBatch(raws, self._layouts))
        while self._is_due(self.end + 1):
            self._playback.wait_until(self._due())
            yield from self._take(self._due())
        yield from self._states.rest()
        self._playback.wait_until(self.end)
        self._playback.look(self.end)

    def _due(self) -> int:
        """Return the time [ns] of the next state of a rate."""
        return self._first + round(self.count * NANOSECONDS / self._rate)

    def _is_due(self, time: int) -> bool:
        """Return whether a state of a rate is due before a message at ``time`` [ns]."""
        return bool(self._rate) and self._first >= 0 and self._due() < time

    def _take(self, time: int) -> Iterator[Block]:
        self.count += 1
        return self._states.take(time)

    def _play(self, batch: MessageBatch) -> Iterator[Block]:
        k = 0
        while k < len(batch.raws):
            stretch = self._stretch(batch, k)
            run = self._run_of(stretch) if stretch.count >= _SHORTEST else None
            if run is not None:
                self._patience = _SHORTEST
                yield from self._play_run(stretch, run)
                k = stretch.end
                continue
            end = max(k + 1, stretch.end)
            if stretch.count >= _SHORTEST:  # the obstacle may be gone some messages later
                end = min(end, k + self._patience)
                self._patience *= 2
            for each in range(k, end):
                yield from self._play_one(batch, each)
            k = end

    def _stretch(self, batch: MessageBatch, begin: int) -> Stretch:
        """Return the longest stretch of messages from ``begin`` that may be a run."""
        is_taken = [r.topic.type == CLOCK or id(r.layout) in self._taken for r in batch.repeated]
        is_run = batch.is_good[begin] and is_taken[batch.owner[begin]]
        if self._playback.has_trackers or not is_run:  # bodies leave between messages
            return Stretch(batch, begin, begin)
        may_be = batch.is_good[begin:] & np.array([*is_taken, False])[batch.owner[begin:]]
        may_be &= batch.times[begin:] < self._playback.next_look
        with self._playback.live.reading() as scene:
            most = max(_SHORTEST, _MOST_POSES // scene.model.inspector.num_frames())
        stops = [*np.flatnonzero(~may_be)[:1].tolist(), len(may_be), most]
        return Stretch(batch, begin, begin + min(stops))

    def _play_one(self, batch: MessageBatch, k: int) -> Iterator[Block]:
        """Play one message."""
        raw = batch.raws[k]
        self.end = max(self.end, raw.time)
        while self._is_due(raw.time):
            self._playback.wait_until(self._due())
            yield from self._take(self._due())
        message = recorded(raw)
        has_posed = self._playback.take(message, self._roles[raw.topic.name])
        self._learn(batch, k, message, has_posed=has_posed)
        if has_posed and not self._rate:
            yield from self._take(raw.time)
        elif has_posed and self._first < 0:
            self._first = raw.time

    def _learn(self, batch: MessageBatch, k: int, message: Recorded, *, has_posed: bool) -> None:
        """Update the senders whose last message was processed."""
        owner, topic = int(batch.owner[k]), message.topic
        if topic.type == CLOCK:
            return
        role = self._roles[topic.name]
        # Transforms that pose nothing do not affect other senders.
        if not (has_posed or role == 'tf') or role in _NEVER_A_RUN or owner < 0:
            self._taken.clear()
            return
        with self._playback.live.reading() as scene:
            named = subjects_of(
                self._playback.inputs, scene, message.message, *self._feeder(topic)
            )
        self._taken = {k: each for k, each in self._taken.items() if each.isdisjoint(named)}
        self._taken[id(batch.repeated[owner].layout)] = named

    def _feeder(self, topic: RecordedTopic) -> tuple[str, str]:
        """Return the kind of a topic's feeder, and the topic of joint states as robots name it."""
        return _FEEDERS[topic.type], self._roles[topic.name].partition(':')[2]

    def _run_of(self, stretch: Stretch) -> PoseRun | None:
        batch, senders = stretch.batch, []
        for number, owner in enumerate(stretch.owners):
            repeated = batch.repeated[owner]
            at, rows = stretch.rows_of(number)
            feeder, topic = self._feeder(repeated.topic)
            senders.append(
                Sender(
                    sample=repeated.layout.sample,
                    feeder=feeder,
                    topic=topic,
                    # The first message of a batch is never good, so there is one before.
                    before=repeated.numbers[rows[0] - 1],
                    at=at,
                    numbers=repeated.numbers[rows],
                    times=_times(batch, owner, rows),
                    first=seconds_of(
                        TimeFields(*batch.stamps[stretch.begin + int(at[0])].tolist())
                    ),
                )
            )
        if not senders:
            return None
        with self._playback.live.editing() as scene:
            if scene.poses.visitors.gone_after:
                return None  # who leaves in between is known message by message
            return run_of(self._playback.inputs, scene, senders, stretch.count)

    def _play_run(self, stretch: Stretch, run: PoseRun) -> Iterator[Block]:
        yield from self._states.begin_run(run)
        states, moments = self._states_of_run(stretch, run)
        self.end = max(self.end, int(stretch.batch.times[stretch.begin : stretch.end].max()))
        yield from self._states.take_run(run, states)
        # The last message of each sender leaves the scene in the same state as all of them.
        now = self._playback.moment
        for k, moment in moments:
            self._playback.moment = moment
            raw = stretch.batch.raws[stretch.begin + k]
            self._playback.take(recorded(raw), self._roles[raw.topic.name])
        self._playback.moment = now

    def _states_of_run(
        self, stretch: Stretch, run: PoseRun
    ) -> tuple[RunStates, list[tuple[int, ClockTimes]]]:
        """Return the states of a run, with ages by the rules for single messages.

        Also return the last message of each sender, with the times of the clocks then.
        """
        playback, arrival = self._playback, self._playback.clocks.arrival
        heard, states = list(run.heard), RunStates([], [], [])
        last = {int(stretch.rows_of(number)[0][-1]) for number in range(len(heard))}
        moments: list[tuple[int, ClockTimes]] = []

        def take(time: int, messages: int) -> None:
            states.times.append(time)
            states.messages.append(messages)
            states.ages.append(self._states.ages_of_run(heard))
            self.count += 1

        for k, (time, sender, stamp) in enumerate(stretch.messages()):
            while self._is_due(time):
                playback.wait_until(self._due())
                take(self._due(), k)
            playback.wait_until(time)
            if sender < 0:
                playback.tick(stamp.sec + stamp.nanosec / NANOSECONDS)
                continue
            if k in last:
                moments.append((k, playback.moment))
            heard[sender] = arrival().since(seconds_of(stamp))
            if not self._rate and sender in run.posing:
                take(time, k + 1)
        return states, moments


def _times(batch: MessageBatch, owner: int, rows: Indices) -> Floats:
    """Return the stamps [s] of messages and of the one before; without stamps, arrival times."""
    repeated, chosen = batch.repeated[owner], np.arange(rows[0] - 1, rows[-1] + 1)
    stamps = repeated.seconds[chosen] + repeated.nanoseconds[chosen] / NANOSECONDS
    arrivals: Floats = batch.times[repeated.at[chosen]] / NANOSECONDS
    return arrivals if not stamps.any() else np.asarray(stamps, dtype=np.float64)
