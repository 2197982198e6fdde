"""The state of a trajectory that runs, and the message ~/trajectory_states."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.live.conversions.fields import floats, stamp_seconds, uint8s, unsigned
from drake_geom_ros.live.conversions.names import some_of
from drake_geom_ros.live.services.motions import OUTCOMES
from drake_geom_ros.live.watching.following import Following
from drake_geom_ros.live.watching.judging import Judgement
from drake_geom_ros.live.watching.watched_trajectory import WatchedTrajectory

NOT_KNOWN = 0  # as an outcome: trouble says why
CLEAR, UNKNOWN = OUTCOMES['clear'], OUTCOMES['unknown']
_IN_WORDS = {number: word for word, number in OUTCOMES.items()} | {NOT_KNOWN: 'not known'}
NOT_FOLLOWED = Following(math.nan, '', ())


class TrajectoryState(NamedTuple):
    """An entry of TrajectoryStates; times [s] since the start of the trajectory."""

    watched: WatchedTrajectory
    outcome: int
    begin: float
    times: tuple[float, float]
    geometries: tuple[str, str] = ('', '')
    ids: tuple[int, int] = (0, 0)
    distance: float = math.inf
    error_bound: float = 0.0
    lower_bound: float = -math.inf
    following: Following = NOT_FOLLOWED
    oldest_pose_age: float = math.inf
    trouble: str = ''
    has_ended: bool = False

    def is_like(self, other: TrajectoryState | None) -> bool:
        """Return whether another state says all that this one does."""
        return other is not None and self.published() == other.published()

    def published(self) -> tuple[Any, ...]:
        """Return the values that are published when they change: all but the deviation."""
        limit = self.watched.deviation_tolerance
        return (
            *(self.watched, self.outcome, self.begin, self.times, self.ids, self.trouble),
            *(self.has_ended, self.following.deviates(limit)),
        )

    def in_words(self) -> str:
        """Return a line for the log."""
        if self.has_ended:
            return f'trajectory {self.watched.name!r} ended' + _after_colon(self.trouble)
        pair = f' of {" and ".join(self.geometries)}' if self.geometries[0] else ''
        until = '' if self.outcome in (CLEAR, NOT_KNOWN) else f' at {self.times[0]:.3f} s'
        return (
            f'trajectory {self.watched.name!r} from {self.begin:.3f} s on: '
            f'{_IN_WORDS[self.outcome]}{pair if until else ""}{until}' + _after_colon(self.trouble)
        )


def _after_colon(text: str) -> str:
    return f': {text}' if text else ''


def state_of(
    watched: WatchedTrajectory,
    judgement: Judgement,
    follows: Following,
    unreliable: Sequence[str],
    notes: Sequence[str],
) -> TrajectoryState:
    """Return the state of a trajectory that was judged.

    For what is ``unreliable`` nothing is called clear, and no time is proved; ``notes`` are told.
    """
    check, outcome = judgement.check, OUTCOMES[judgement.check.outcome]
    times, lower_bound = check.times, check.lower_bound
    if unreliable and outcome in (CLEAR, UNKNOWN):
        outcome, lower_bound = UNKNOWN, -math.inf
        times = judgement.begin, watched.end
    ids = (0, 0)
    geometries = ('', '')
    if check.id_A is not None and check.id_B is not None:
        ids = check.id_A.get_value(), check.id_B.get_value()
        names = judgement.view.names.geometry_names
        geometries = names[check.id_A], names[check.id_B]
    return TrajectoryState(
        watched=watched,
        outcome=outcome,
        begin=judgement.begin,
        times=times,
        geometries=geometries,
        ids=ids,
        distance=check.distance,
        error_bound=check.error_bound,
        lower_bound=lower_bound,
        following=follows,
        oldest_pose_age=judgement.view.moment.oldest_pose_age,
        trouble='; '.join((*unreliable, *notes)),
    )


def unreliable_following(watched: WatchedTrajectory, follows: Following) -> list[str]:
    """Return in words why nobody knows whether a trajectory is what is executed."""
    said = []
    if follows.silent:
        said.append(
            f'no value of now came of {some_of(list(follows.silent))}: whether the trajectory is '
            'followed is not known'
        )
    if follows.deviates(watched.deviation_tolerance):
        said.append(
            f'{follows.joint} is farther from the trajectory than the deviation_tolerance of '
            f'{watched.deviation_tolerance:g}: what is judged is not what is executed'
        )
    return said


def fill_trajectory_states(message: Any, states: Sequence[TrajectoryState]) -> None:
    """Fill the arrays of a TrajectoryStates."""
    new_time = type(message.header.stamp)
    starts = [new_time() for _ in states]
    for start, state in zip(starts, states, strict=True):
        stamp_seconds(start, state.watched.start)
    message.names, message.starts = [state.watched.name for state in states], starts
    message.ended = [state.has_ended for state in states]
    message.outcome = uint8s(np.array([state.outcome for state in states]))
    message.geometry_a = [state.geometries[0] for state in states]
    message.geometry_b = [state.geometries[1] for state in states]
    message.id_a = unsigned(np.array([state.ids[0] for state in states]))
    message.id_b = unsigned(np.array([state.ids[1] for state in states]))
    message.deviating_joint = [state.following.joint for state in states]
    message.deviates = [
        state.following.deviates(state.watched.deviation_tolerance) for state in states
    ]
    message.trouble = [state.trouble for state in states]
    message.times = floats(np.array([time for state in states for time in state.times]))
    for field, values in (
        ('now', [state.begin for state in states]),
        ('last_free', [state.times[0] for state in states]),
        ('distance', [state.distance for state in states]),
        ('error_bound', [state.error_bound for state in states]),
        ('lower_bound', [state.lower_bound for state in states]),
        ('deviation', [state.following.deviation for state in states]),
        ('oldest_pose_age', [state.oldest_pose_age for state in states]),
    ):
        setattr(message, field, floats(np.array(values)))
