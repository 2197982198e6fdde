"""``watch_trajectory``, ``unwatch_trajectory`` and ~/trajectory_states.

One thread calls all of it. The scene is held while it is looked at, never while a trajectory is
judged.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.fields import stamp_seconds
from drake_geom_ros.live.conversions.names import shortened, some_of
from drake_geom_ros.live.conversions.request_types import (
    NamedRequest,
    WatchTrajectoryRequest,
)
from drake_geom_ros.live.outputs.effects import Beside
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.robot_joints import JointPlace, RobotJoints
from drake_geom_ros.live.watching.following import Following, following
from drake_geom_ros.live.watching.judging import Judgement, StaleNow, judge, refuse_limits
from drake_geom_ros.live.watching.trajectory_state import (
    CLEAR,
    NOT_KNOWN,
    TrajectoryState,
    fill_trajectory_states,
    state_of,
    unreliable_following,
)
from drake_geom_ros.live.watching.watched_trajectory import WatchedTrajectory, watched_trajectory

PERIOD = 0.05  # [s] between two looks at whether the scene changed
_MOST_WATCHED = 64
_NO_TRAJECTORY = 'no trajectory runs, or nothing changed since it was judged'
_CLOCK_JUMPED = (
    "the node's time jumped: where the trajectory is by now is not known; watch it anew"
)


def effect() -> Beside:
    """Return the row of ~/cycle_report with the pairs that judging trajectories took."""
    return Beside('judge trajectories', lambda: _NO_TRAJECTORY)


class Logs(NamedTuple):
    """The logs of events."""

    info: Callable[[str], object]
    warning: Callable[[str], object]


class _Look(NamedTuple):
    """A trajectory and its judgement as they were while the scene was held."""

    follows: Following
    unreliable: list[str]
    holds: bool  # the judgement is of the scene of now


@dataclass
class _Running:
    """A trajectory that is watched."""

    watched: WatchedTrajectory
    judgement: Judgement | None = None
    failure: str = ''  # why there is no judgement
    joints: RobotJoints | None = None  # the table in which the joints were looked up
    places: list[JointPlace] | None = None
    published: TrajectoryState | None = None

    def places_in(self, joints: RobotJoints) -> list[JointPlace]:
        """Return where the joints are; raises ArgumentError where one is gone."""
        if self.places is None or joints is not self.joints:
            self.places = joints.places(list(self.watched.joint_names))
            self.joints = joints
        return self.places


class TrajectoryWatch:
    """Judges the rest of each trajectory that runs whenever what it rests on has changed."""

    def __init__(
        self,
        live: LiveScene,
        publisher: Any,
        new_message: Callable[[], Any],
        log: Logs,
        did: Callable[[int, float], None],
    ) -> None:
        """``did(pairs, seconds)`` is called for each judgement, with the pairs that it took."""
        self._live, self._publisher, self._new_message = live, publisher, new_message
        self._log, self._did = log, did
        self._running: dict[str, _Running] = {}
        self._made_names = 0
        self._is_published = False  # the list of trajectories that there are
        self.judgements = 0

    def begin(self, request: WatchTrajectoryRequest, response: Any) -> None:
        """Watch a trajectory; raises RuntimeError to refuse it, and all stays as it was."""
        name = request.name or self._new_name()
        if name not in self._running and len(self._running) >= _MOST_WATCHED:
            raise ArgumentError(f'{_MOST_WATCHED} trajectories are watched already: end one')
        watched = watched_trajectory(self._live, request, name)
        refuse_limits(self._live, watched)
        running = _Running(watched)
        running.judgement = self._judge(watched)
        self._running[name], self._is_published = running, False
        response.name = name

    def end(self, request: NamedRequest, response: Any) -> None:
        """Watch a trajectory no longer; raises ArgumentError where none has that name."""
        if request.name not in self._running:
            raise ArgumentError(
                f'no trajectory {shortened(request.name)!r} is watched; those that are: '
                f'{some_of(list(self._running)) or "none"}'
            )
        del self._running[request.name]
        self._is_published = False

    def look(self) -> None:
        """Judge what rests on a scene that has changed, and publish what is new."""
        if not self._running and self._is_published:
            return
        states = [self._state(running) for running in self._running.values()]
        news = [s for s in states if not s.is_like(self._running[s.watched.name].published)]
        if not news and self._is_published:
            return
        self._publish(states)
        for state in states:
            running = self._running[state.watched.name]
            before = running.published
            if state.has_ended or before is None or before.outcome != state.outcome:
                is_good = state.outcome == CLEAR
                (self._log.info if is_good else self._log.warning)(state.in_words())
            running.published = state
            if state.has_ended:
                del self._running[state.watched.name]

    def forget(self) -> None:
        """Publish the states anew, to subscribers that received nothing meanwhile."""
        self._is_published = False

    def _new_name(self) -> str:
        while True:
            self._made_names += 1
            if (name := f'trajectory_{self._made_names}') not in self._running:
                return name

    def _judge(self, watched: WatchedTrajectory) -> Judgement:
        start = time.perf_counter()
        judgement = judge(self._live, watched, self._live.must_stop)
        self.judgements += 1
        self._did(judgement.check.evaluations, time.perf_counter() - start)
        return judgement

    def _state(self, running: _Running) -> TrajectoryState:
        """Return the state of a trajectory, which is judged anew where that is needed."""
        watched, clocks = running.watched, self._live.clocks
        if clocks.epoch != watched.epoch:
            return _ended(running, _CLOCK_JUMPED)
        if watched.elapsed(clocks.node()) >= watched.end:
            return _ended(running)
        try:
            look = self._look_at(running)
            if not look.holds:
                self._judge_anew(running)
                look = self._look_at(running)
        except ArgumentError as error:
            return _ended(running, str(error))
        if running.judgement is None:
            return _not_judged(running, running.failure)
        unreliable, notes = [*filter(None, look.unreliable)], self._notes(running)
        return state_of(watched, running.judgement, look.follows, unreliable, notes)

    def _look_at(self, running: _Running) -> _Look:
        """Look at a trajectory; raises ArgumentError where a joint is gone."""
        live, watched, judgement = self._live, running.watched, running.judgement
        with live.reading() as scene:
            places = running.places_in(scene.model.joints)
            follows = following(scene, watched, places, live.stale_after)
            untrusted = _untrusted(scene)
            stale = StaleNow.of(live, scene, places)
            holds = judgement is not None and judgement.basis.holds(scene)
        # The scene moves on from here.
        unreliable = [*unreliable_following(watched, follows), *untrusted]
        if judgement is not None:
            unreliable += [judgement.stale_frames(stale), judgement.missing()]
        return _Look(follows, unreliable, holds)

    def _judge_anew(self, running: _Running) -> None:
        try:
            running.judgement, running.failure = self._judge(running.watched), ''
        except InterruptedError:  # the node stops
            running.judgement, running.failure = None, 'the node stops'
        except RuntimeError as error:
            running.judgement, running.failure = None, str(error)

    def _notes(self, running: _Running) -> list[str]:
        """Return in words what a state rests on."""
        watched, judgement = running.watched, running.judgement
        assert judgement is not None
        notes = [judgement.view.beside.in_words()]
        if judgement.is_unproved():
            notes.append(f'the time_budget of {watched.time_budget:g} s was not enough')
        if watched.foreign_joints:
            notes.append(
                f'left out, since no robot has them: {some_of(list(watched.foreign_joints))}'
            )
        others = [name for name in self._running if name != watched.name]
        if others:
            notes.append(
                f'what {some_of(others)} moves counts as standing where it is, and is judged '
                'again as it moves'
            )
        return [*filter(None, notes)]

    def _publish(self, states: list[TrajectoryState]) -> None:
        message = self._new_message()
        judgements = [each.judgement for each in self._running.values() if each.judgement]
        with self._live.reading() as scene:
            message.header.frame_id = scene.model.world_frame
            message.scene_version = min(
                (each.view.moment.version for each in judgements), default=scene.model.version
            )
        stamp_seconds(message.header.stamp, self._live.clocks.node())
        fill_trajectory_states(message, states)
        self._publisher.publish(message)
        self._is_published = True


def _untrusted(scene: HeldScene) -> list[str]:
    """Return in words which poses are not those of now though they are new."""
    names = scene.model.names.frame_names.items()
    return [
        f'{what}: {some_of([name for frame, name in names if frame.get_value() in frames])}'
        for frames, what in (
            (scene.poses.contested_frames(), 'two senders pose in turn'),
            (scene.poses.ages.of_other_clocks(), 'poses bear stamps of another clock'),
        )
        if frames
    ]


def _ended(running: _Running, trouble: str = '') -> TrajectoryState:
    """Return the last state of a trajectory; with a ``trouble`` nothing is known of its rest."""
    if not trouble and running.published is not None:
        return running.published._replace(has_ended=True)
    return _not_judged(running, trouble)._replace(has_ended=True)


def _not_judged(running: _Running, trouble: str) -> TrajectoryState:
    watched, before = running.watched, running.published
    begin = float(watched.spline.times[0]) if before is None else before.begin
    return TrajectoryState(watched, NOT_KNOWN, begin, (begin, watched.end), trouble=trouble)
