"""Frames that have never received a pose, and the pairs that queries omit because of them."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, NamedTuple

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.geometry import QueryObject
from drake_geom_ros.live.conversions.names import NameTable, some_of
from drake_geom_ros.live.scene.seen_shells import NOTHING_BESIDE, BesideBodies


class Waiting(NamedTuple):
    """The full names of the frames that never had a pose, and what that leaves out."""

    frames: list[str]
    pairs: int  # unfiltered ones
    geometries: int  # with the proximity role
    beside: BesideBodies = NOTHING_BESIDE  # points that are in no distance

    def in_words(self) -> str:
        """Return a sentence about it; empty where nothing waits."""
        if not self.frames:
            return ''
        return (
            f'{counted(self.pairs, "pair")} {are(self.pairs)} left out because '
            f'{counted(len(self.frames), "frame")} never had a pose: {some_of(self.frames)}'
        )

    def tell_pairs(self, *messages: Any) -> None:
        """Say it in answers about pairs, and in the report of a cycle."""
        for message in messages:
            message.waiting_frames, message.waiting_pairs = self.frames, self.pairs
        self.beside.fill(*messages)

    def tell_geometries(self, message: Any) -> None:
        """Say it in an answer about geometries."""
        message.waiting_frames, message.waiting_geometries = self.frames, self.geometries
        self.beside.fill(message)


def waiting(
    query: QueryObject,
    names: NameTable,
    beside: BesideBodies = NOTHING_BESIDE,
    absent: Collection[int] = (),
) -> Waiting:
    """Return what waits in the scene of a query object, and what was seen beside bodies.

    For frames that are ``absent``, by the values of their ids, nobody waits.
    """
    waiting_frames = [f for f in query.waiting_frames() if f.get_value() not in absent]
    frames = [names.frame_names[frame] for frame in waiting_frames]
    if not frames:
        return Waiting([], 0, 0, beside)
    pairs, geometries = query.num_waiting_pairs(), query.num_waiting_geometries()
    return Waiting(frames, pairs, geometries, beside)
