"""Audit of a recording: a node's results and events, recomputed from the recorded poses."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from drake_geom_ros.geometry import AccuracyLike, GeometryError, GeometryId, QueryObject
from drake_geom_ros.live.scene.pose_ages import time_of
from drake_geom_ros.live.scene.scene_view import SceneView
from drake_geom_ros.proximity_rules import geometry_names, named_zones, zones_in
from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.message_types import DISTANCES, EVENTS, OVERLAPS, SCENE
from drake_geom_ros.recordings.opened import Opened, opened_recording
from drake_geom_ros.recordings.playback import RefusedMessages
from drake_geom_ros.recordings.raw_messages import NANOSECONDS, Damage
from drake_geom_ros.recordings.recorded_pairs import (
    Compared,
    Outcome,
    compare,
    computed_pairs,
    names_in,
    of_event_points,
    recorded_pairs,
)
from drake_geom_ros.recordings.recording import Recorded
from drake_geom_ros.recordings.recording_topics import Topics
from drake_geom_ros.replay import Finding, Judge, RecordedEvent, events_of
from drake_geom_ros.scene_files import SceneDescription

_RESULTS = DISTANCES, OVERLAPS
_KINDS = *_RESULTS, EVENTS
_WAITS = NANOSECONDS // 2  # [ns] poses of a result may be recorded up to this much after it
_KEEP = 3 * NANOSECONDS  # [ns] a result is recorded at most this long after its state
_MOST_STATES = 4096
_RACE = NANOSECONDS // 50  # [ns] messages of two senders may arrive in either order within this
_MOST_TRIED = 64  # states with the stamp of a result


class Audited(NamedTuple):
    """Verdict on a result or event."""

    time: float  # [s] since the recording began
    topic: str
    what: str
    outcome: Outcome
    because: str


@dataclass
class Audit:
    """Verdicts on all results and events of a node in a recording."""

    entries: list[Audited] = field(default_factory=list)
    silent: tuple[str, ...] = ()  # topics of results without a message
    begin: int = 0  # [ns] of the recording
    damage: tuple[Damage, ...] = ()  # unreadable parts
    refused: tuple[RefusedMessages, ...] = ()  # messages whose poses were refused
    differences: tuple[str, ...] = ()  # between the recorded ``~/scene`` and the scene played here

    def reservations(self) -> list[str]:
        """Return texts on what was not audited; empty if everything recorded was judged."""
        reservations = [each.in_words(self.begin) for each in self.damage]
        reservations += [each.in_words() for each in self.refused]
        reservations += self.differences
        reservations += [f'no message of {topic} was recorded' for topic in self.silent]
        if not self.entries:
            reservations.append('nothing: no result and no event was recorded')
        return reservations

    def counts(self) -> dict[Outcome, int]:
        """Return the number of entries by outcome."""
        counts = Counter(entry.outcome for entry in self.entries)
        return {outcome: counts[outcome] for outcome in Outcome}

    def by_reason(self) -> list[tuple[str, Audited, int]]:
        """Return topic, first entry and count of the unconfirmed entries, by topic and reason."""
        groups: dict[tuple[str, Outcome, str], list[Audited]] = {}
        for entry in self.entries:
            if entry.outcome in (Outcome.REFUTED, Outcome.NOT_REPRODUCIBLE):
                reason = entry.because if entry.outcome == Outcome.NOT_REPRODUCIBLE else ''
                groups.setdefault((entry.topic, entry.outcome, reason), []).append(entry)
        return [(entries[0].topic, entries[0], len(entries)) for entries in groups.values()]


def audit(
    path: str | Path | Sequence[str | Path],
    scene: str | Path | SceneDescription | None = None,
    *,
    topics: Topics | None = None,
    stale_after: float = 1.0,
    accuracy: AccuracyLike = 'exact',
    world_frame: str = 'world',
    package_roots: Sequence[str | Path] = (),
) -> Audit:
    """Return a verdict on each result and event of a scene_graph node in a recording.

    Each ``SignedDistancePairs``, ``PenetrationPairs`` and ``ProximityEvents`` is recomputed in
    the recorded state whose newest stamp it bears. Arguments are those of ``clearance``;
    ``accuracy`` is the level of the node. A result is refuted if no state with its stamp has its
    distances within both bounds, or if a pair is missing. It is not reproducible if the recording
    lacks what is needed: the poses of its stamp, the ``~/scene`` that explains its ids, or poses
    from before the recording.

    Raises the errors of ``clearance``, and RecordingError if there is nothing to audit.

        audited = audit('run.mcap', 'cell.yaml')
        assert audited.counts()[Outcome.REFUTED] == 0
    """
    opened = opened_recording(
        path,
        scene=scene,
        topics=topics,
        stale_after=stale_after,
        accuracy=accuracy,
        world_frame=world_frame,
        package_roots=package_roots,
    )
    recorded = opened.recording.topics
    prefix = (topics or Topics()).prefix
    recorded = [topic for topic in recorded if topic.name.startswith(prefix)]
    judged_topics = [topic.name for topic in recorded if topic.type in _KINDS]
    if not judged_topics:
        raise RecordingError(
            'there is nothing to be audited: no topic of signed distances, penetrations or '
            'proximity events was recorded'
        )
    tables = [topic.name for topic in recorded if topic.type == SCENE]
    auditor = _Auditor(opened, [*judged_topics, *tables], one_scene=len(tables) == 1)
    audited = auditor.run()
    # A node publishes results in each cycle, but events only when they occur.
    results = dict.fromkeys(topic.name for topic in recorded if topic.type in _RESULTS)
    audited.silent = tuple(topic for topic in results if topic not in auditor.judged_topics)
    audited.begin = opened.recording.begin
    audited.damage = tuple(opened.recording.damage)
    audited.refused = tuple(opened.playback.refused)
    audited.differences = opened.playback.differences()
    return audited


class _State(NamedTuple):
    """The scene at a time of the recording."""

    time: int  # [ns]
    topic: str  # of the message that led to it
    posed: frozenset[str]  # joints or frames that this message names
    stamp: tuple[int, int]  # the newest one of its poses
    view: SceneView


class _Auditor:
    """Plays a recording, with a window of recent states and a queue of messages to judge."""

    def __init__(self, opened: Opened, topics: Sequence[str], *, one_scene: bool) -> None:
        self._playback, self._roles = opened.playback, opened.roles
        self._messages = opened.recording.messages([*self._roles, *topics])
        self._states: deque[_State] = deque(maxlen=_MOST_STATES)
        self._waiting: deque[Recorded] = deque()
        # By namespace of the node and names_version; a single scene is that of all nodes.
        self._one_scene = one_scene
        self._names: dict[tuple[str, int], dict[int, str]] = {}
        self._sequences: dict[str, int] = {}  # number of the last event by topic
        self._begin, self._first = opened.recording.begin, 0
        self.judged_topics: set[str] = set()
        self.audit = Audit()

    def run(self) -> Audit:
        """Play the recording and return the verdicts on all messages."""
        self._add_state(0, '', frozenset())
        for message in self._messages:
            self._first = self._first or message.time
            while self._waiting and message.time - self._waiting[0].time > _WAITS:
                self._judge(self._waiting.popleft())
            if message.topic.type in _KINDS:
                self._waiting.append(message)
            elif message.topic.type == SCENE:
                if message.message is not None:
                    key = self._node_of(message), int(message.message.names_version)
                    self._names[key] = names_in(message.message)
                if message.topic.name in self._roles:
                    self._playback.take(message, 'scene')
            elif self._playback.take(message, self._roles[message.topic.name]):
                self._add_state(message.time, message.topic.name, _posed(message.message))
        while self._waiting:
            self._judge(self._waiting.popleft())
        return self.audit

    def _node_of(self, message: Recorded) -> str:
        return '' if self._one_scene else message.topic.name.rpartition('/')[0]

    def _add_state(self, time: int, topic: str, posed: frozenset[str]) -> None:
        with self._playback.live.reading() as scene:
            view = scene.view()
        newest = view.moment.newest_stamp
        stamp = (0, 0) if newest is None else time_of(newest)
        self._states.append(_State(time, topic, posed, stamp, view))
        while len(self._states) > 1 and time - self._states[1].time > _KEEP:
            self._states.popleft()

    def _judge(self, recorded: Recorded) -> None:
        self.judged_topics.add(recorded.topic.name)
        if recorded.message is None:
            verdict = Compared(Outcome.NOT_REPRODUCIBLE, recorded.reason)
            self._add_entry(recorded, 'a message', verdict)
            return
        stamp = time_of(recorded.message.header.stamp)
        states = [each for each in self._states if each.stamp == stamp]
        states.sort(key=lambda state: abs(state.time - recorded.time))
        if recorded.topic.type == EVENTS:
            self._judge_events(recorded, states[:_MOST_TRIED])
            return
        what = f'{len(recorded.message.id_a)} pairs'
        self._add_entry(recorded, what, self._of_pairs(recorded, states[:_MOST_TRIED]))

    def _of_pairs(self, recorded: Recorded, states: Sequence[_State]) -> Compared:
        message, kind = recorded.message, recorded.topic.type
        names = self._names.get((self._node_of(recorded), int(message.names_version)))
        if names is None:
            why = f'no ~/scene of names_version {message.names_version} was recorded'
            return Compared(Outcome.NOT_REPRODUCIBLE, why)
        if not states:
            return Compared(Outcome.NOT_REPRODUCIBLE, 'no recorded poses bear its stamp')
        try:
            pairs = recorded_pairs(kind, message, names)
        except KeyError as error:
            why = f'the recorded ~/scene has no geometry {error}'
            return Compared(Outcome.NOT_REPRODUCIBLE, why)
        if unknown := {n for pair in pairs.names for n in pair} - set(_ids(states[0]).values()):
            why = f'the scene given has no {sorted(unknown)[0]!r}'
            return Compared(Outcome.NOT_REPRODUCIBLE, why)
        verdicts = []
        for state in states:
            here, query = _ids(state), state.view.query
            now = computed_pairs(kind, query, here, state.view.waiting().pairs, pairs.reach)
            verdicts.append(compare(pairs, now, query, here))
            if verdicts[-1].outcome == Outcome.SAME:
                break
        best = min(verdicts, key=_rank)
        lacking = sorted(set(_ids(states[0]).values()) - set(names.values()))
        if lacking and best.outcome == Outcome.REFUTED:
            why = f'the recorded ~/scene has no {lacking[0]!r}, which the scene given has'
            return Compared(Outcome.NOT_REPRODUCIBLE, why)
        return self._unless_unknown(recorded, states, best, message.oldest_pose_age)

    def _unless_unknown(
        self, recorded: Recorded, states: Sequence[_State], verdict: Compared, age: float
    ) -> Compared:
        """Return the verdict, weakened from refuted if the recording may lack the poses used."""
        if verdict.outcome != Outcome.REFUTED:
            return verdict
        if age > (recorded.time - self._first) / NANOSECONDS:
            why = 'it used a pose from before the recording, or of unknown age'
            return Compared(Outcome.NOT_REPRODUCIBLE, why)
        for state in states:
            for other in self._states:
                if abs(other.time - state.time) < _RACE and _may_be_of_two(state, other):
                    both = ' and '.join(sorted({state.topic, other.topic}))
                    why = f'poses of {both} came within 20 ms, in an order that nobody knows'
                    return Compared(Outcome.NOT_REPRODUCIBLE, why)
        return verdict

    def _judge_events(self, recorded: Recorded, states: Sequence[_State]) -> None:
        values = vars(recorded.message)
        for event in events_of(values):
            last = self._sequences.get(recorded.topic.name)
            if last is not None and event.sequence != last + 1:
                why = f'the events {last + 1} to {event.sequence - 1} are missing'
                if event.sequence <= last:
                    why = f'event {event.sequence} follows {last}: the node was started anew'
                self._add_entry(recorded, 'events', Compared(Outcome.NOT_REPRODUCIBLE, why))
            self._sequences[recorded.topic.name] = event.sequence
            best = min((self._of_event(event, state) for state in states), key=_rank, default=None)
            if best is None:
                best = Compared(Outcome.NOT_REPRODUCIBLE, 'no recorded poses bear its stamp')
            best = self._unless_unknown(recorded, states, best, event.oldest_pose_age)
            verb = 'entered' if event.entered else 'left'
            what = f'event {event.sequence}: {event.rule!r} was {verb}'
            self._add_entry(recorded, what, best)

    def _of_event(self, event: RecordedEvent, state: _State) -> Compared:
        names = {name: GeometryId(value) for value, name in _ids(state).items()}
        try:
            with self._playback.live.editing() as scene:
                verdict = Judge.of(scene.model.scene_graph, names).verdict(event)
        except GeometryError as error:
            return Compared(Outcome.NOT_REPRODUCIBLE, str(error))
        if verdict.finding == Finding.UNFOUNDED:
            return Compared(Outcome.REFUTED, verdict.because)
        if verdict.finding == Finding.NOT_TO_BE_TOLD or verdict.distance is None:
            outcome = Outcome.WITHIN if verdict.finding == Finding.FOUNDED else None
            return Compared(outcome or Outcome.NOT_REPRODUCIBLE, verdict.because)
        query = state.view.query
        inspector = query.inspector()
        names |= named_zones(inspector)
        a, b = names[event.geometry_a], names[event.geometry_b]
        if zones := {id: each for id, each in zones_in(inspector).items() if id in (a, b)}:
            query = query.with_proximity(zones)
        if not (query.is_placed(a) and query.is_placed(b)):
            return Compared(Outcome.NOT_REPRODUCIBLE, 'its pair waits for a pose here')
        now = query.signed_distance_of_pair(a, b, accuracy=event.accuracy)
        distance, bound = float(now.distance[0]), float(now.error_bound[0])
        is_same = (distance, bound) == (event.distance, event.error_bound)
        if abs(distance - event.distance) <= bound + event.error_bound:
            return of_event_points(event, now, query, (a, b), is_same=is_same)
        why = (
            f'it says {event.distance!r} m ± {event.error_bound:.1e} m, and by the recorded poses'
        )
        return Compared(Outcome.REFUTED, f'{why} it is {distance!r} m ± {bound:.1e} m')

    def _add_entry(self, recorded: Recorded, what: str, verdict: Compared) -> None:
        time = (recorded.time - self._begin) / NANOSECONDS
        entry = Audited(time, recorded.topic.name, what, verdict.outcome, verdict.because)
        self.audit.entries.append(entry)


def _rank(verdict: Compared) -> int:
    """Return the rank of a verdict, 0 for the best match."""
    order = (Outcome.SAME, Outcome.WITHIN, Outcome.NOT_REPRODUCIBLE, Outcome.REFUTED)
    return order.index(verdict.outcome)


def _posed(message: Any) -> frozenset[str]:
    """Return the names of the frames or joints that a message poses."""
    if hasattr(message, 'transforms'):
        return frozenset(each.child_frame_id for each in message.transforms)
    names = message.frame_names if hasattr(message, 'frame_names') else message.name
    return frozenset(names)


def _may_be_of_two(one: _State, other: _State) -> bool:
    """Return whether two senders may have led to two states, since a sender's names are fixed."""
    return one.topic != other.topic or one.posed != other.posed


def _ids(state: _State) -> dict[int, str]:
    """Return the full names of the geometries of a state, by id."""
    inspector = QueryObject(state.view.context).inspector()
    ids = inspector.candidate_matrix()[0].tolist()
    return {i: geometry_names(inspector, GeometryId(i)).full_name for i in ids}
