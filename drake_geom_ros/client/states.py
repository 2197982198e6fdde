"""Evaluation of many joint states, split into requests that fit into messages."""

from __future__ import annotations

import array
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.client.scene_table import SceneTable
from drake_geom_ros.math.array_types import Floats

Progress = Callable[[int, int], object]  # states done, and all
# Size of one request: below any limit of responses, and small enough for regular progress.
_MOST_NUMBERS = 200_000
_MOST_OF_PAIRS = 2_000  # states of `near`, whose number of pairs is not known in advance


@dataclass(frozen=True)
class StatesRequest:
    """Request about ``states`` (n, q) of joints, with the other ``fields`` of the service."""

    joint_names: list[str]
    states: Floats
    fields: dict[str, Any]

    def ask(self, call: Callable[..., Any], progress: Progress | None) -> list[Any]:
        """Return the responses of all parts; with ``stop_at_first``, end at a state not free.

        Raises RuntimeError if the scene changes between two parts.
        """
        answers: list[Any] = []
        done = 0
        for part in self._parts():
            positions = array.array('d', np.ascontiguousarray(part).tobytes())
            answer = call(joint_names=self.joint_names, positions=positions, **self.fields)
            if answers and answer.scene_version != answers[0].scene_version:
                raise RuntimeError(
                    f'the scene changed while its states were evaluated, from version '
                    f'{answers[0].scene_version} to {answer.scene_version}: ask again'
                )
            answers.append(answer)
            done += answer.count
            if progress is not None:
                progress(done, len(self.states))
            if self.fields['stop_at_first'] and answer.first_not_free >= 0:
                break
        return answers

    def _parts(self) -> Iterator[Floats]:
        size = max(1, _MOST_NUMBERS // max(1, self.states.shape[1]))
        if self.fields['want'] == 'near':
            size = min(size, _MOST_OF_PAIRS)
        for first in range(0, max(1, len(self.states)), size):
            yield self.states[first : first + size]


class States(NamedTuple):
    """Verdicts and distances of n states, in the order of the request.

    The rows of ``distance``, ``error_bound`` and ``ids`` depend on what was wanted:

    - ``least``: one row a state, nan and 0 where a state is outside its limits;
    - ``near``: rows ``offsets[s]`` to ``offsets[s + 1]`` are those of state s;
    - ``collision``: none.
    """

    free: NDArray[np.bool_]  # (n,)
    reason: NDArray[np.uint8]  # (n,) EvaluateStates.Response's FREE, TOO_NEAR, OUTSIDE_LIMITS
    distance: Floats  # [m]
    error_bound: Floats  # [m]
    ids: NDArray[np.int64]  # (p, 2) of the geometries; 0: there is no pair
    offsets: NDArray[np.int64]  # (n + 1,) of `near`, else empty
    oldest_pose_age: float  # [s] of the oldest frame pose at that time; inf: unknown
    stale_frames: tuple[str, ...]  # frames whose live pose is stale and used; at most 20 a part
    scene: SceneTable

    @classmethod
    def of(cls, answers: Sequence[Any], scene: SceneTable) -> States:
        """Return the states of several responses, concatenated."""

        def joined(name: str, kind: Any) -> Any:
            return np.concatenate(
                [np.asarray(getattr(each, name), dtype=kind) for each in answers]
            )

        offsets = np.zeros(0, dtype=np.int64)
        if any(len(answer.offsets) for answer in answers):
            counts = [np.diff(np.asarray(each.offsets, dtype=np.int64)) for each in answers]
            offsets = np.concatenate(([0], np.cumsum(np.concatenate(counts))))
        return cls(
            joined('free', np.bool_),
            joined('reason', np.uint8),
            joined('distance', np.float64),
            joined('error_bound', np.float64),
            np.stack((joined('id_a', np.int64), joined('id_b', np.int64)), axis=1),
            offsets,
            max(answer.oldest_pose_age for answer in answers),
            tuple(dict.fromkeys(name for each in answers for name in each.stale_frames)),
            scene,
        )

    @property
    def first_not_free(self) -> int:
        """Index of the first state that is not free; -1: all are free."""
        return -1 if self.free.all() else int(np.argmin(self.free))

    def names(self, row: int) -> tuple[str, str]:
        """Return the full names of the geometries of a row; empty if it has no pair."""
        a, b = self.ids[row].tolist()
        return ('', '') if a == 0 else (self.scene[a].full_name, self.scene[b].full_name)
