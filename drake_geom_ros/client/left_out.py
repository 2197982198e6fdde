"""What an answer leaves out, because nobody knows where it is."""

from __future__ import annotations

from typing import Any, NamedTuple

from drake_geom_ros.common.counting import are, counted

_SHOWN = 5  # names in a sentence


class IncompleteError(RuntimeError):
    """An answer that leaves something out was about to be taken for the whole one."""


class LeftOut(NamedTuple):
    """Frames that never had a pose, by full names, and how many things that leaves out."""

    frames: tuple[str, ...]
    number: int
    thing: str  # `pair` or `geometry`

    @classmethod
    def of_pairs(cls, answer: Any) -> LeftOut:
        """Return what an answer about pairs leaves out."""
        return cls(tuple(answer.waiting_frames), int(answer.waiting_pairs), 'pair')

    @classmethod
    def of_geometries(cls, answer: Any) -> LeftOut:
        """Return what an answer about geometries leaves out."""
        return cls(tuple(answer.waiting_frames), int(answer.waiting_geometries), 'geometry')

    def refuse(self, what: str) -> None:
        """Raise IncompleteError about ``what``, which would look whole."""
        names = ', '.join(self.frames[:_SHOWN]) + ' ...' * (len(self.frames) > _SHOWN)
        raise IncompleteError(
            f'{what}: {counted(self.number, self.thing)} {are(self.number)} left out because '
            f'{counted(len(self.frames), "frame")} never had a pose: {names}. Pose them '
            '(~/frame_poses, TF, the key `pose` of the scene file, or the poses of the question), '
            'or take what is known with allow_incomplete=True'
        )
