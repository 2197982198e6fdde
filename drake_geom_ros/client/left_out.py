"""Errors and records for results that omit geometries or rest on stale poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from drake_geom_ros.common.counting import are, counted

_SHOWN = 5  # names in a sentence


class IncompleteError(RuntimeError):
    """A result omits pairs, geometries or sensed points, and the caller did not allow that."""


class StaleError(RuntimeError):
    """A result rests on stale poses, and the caller did not allow that."""


def refuse_stale(what: str, frames: Sequence[str]) -> None:
    """Raise StaleError about ``what`` if it uses stale live poses of any ``frames``."""
    if frames:
        names = ', '.join(frames[:_SHOWN]) + ' ...' * (len(frames) > _SHOWN)
        raise StaleError(
            f'{what}: the answer rests on stale poses of {counted(len(frames), "frame")}: '
            f'{names}. '
            'They are older than the parameter stale_after of the node, or of unknown age: see '
            '/diagnostics for their senders, pose them in the question, or take the answer with '
            'allow_stale=True'
        )


class LeftOut(NamedTuple):
    """Frames that have never received a pose, and the number of rows that this omits.

    ``shell_points`` counts the sensed points beside bodies, which no row includes either;
    ``least_shell_distance`` [m] is the smallest distance of one to its body.
    """

    frames: tuple[str, ...]
    number: int
    thing: str  # `pair` or `geometry`
    shell_points: int
    least_shell_distance: float

    @classmethod
    def of_pairs(cls, answer: Any) -> LeftOut:
        """Return what a response about pairs omits."""
        return cls._of(answer, int(answer.waiting_pairs), 'pair')

    @classmethod
    def of_geometries(cls, answer: Any) -> LeftOut:
        """Return what a response about geometries omits."""
        return cls._of(answer, int(answer.waiting_geometries), 'geometry')

    @classmethod
    def _of(cls, answer: Any, number: int, thing: str) -> LeftOut:
        beside = int(answer.shell_points), float(answer.least_shell_distance)
        return cls(tuple(answer.waiting_frames), number, thing, *beside)

    @property
    def is_nothing(self) -> bool:
        """True if nothing is omitted."""
        return not (self.number or self.shell_points)

    def refuse(self, what: str) -> None:
        """Raise IncompleteError about ``what``, with the reasons and the remedies."""
        reasons = []
        if self.number:
            names = ', '.join(self.frames[:_SHOWN]) + ' ...' * (len(self.frames) > _SHOWN)
            reasons.append(
                f'{counted(self.number, self.thing)} {are(self.number)} left out because '
                f'{counted(len(self.frames), "frame")} never had a pose: {names}. Pose them '
                '(~/frame_poses, TF, the key `pose` of the scene file, or the poses of the '
                'question)'
            )
        if self.shell_points:
            points = self.shell_points
            reasons.append(
                f'{counted(points, "point")} of sensors {are(points)} beside bodies, the nearest '
                f'{self.least_shell_distance:.3g} m from one, and in no distance: see '
                'obstacle_noise'
            )
        raise IncompleteError(
            f'{what}: {"; ".join(reasons)}, or take what is known with allow_incomplete=True'
        )
