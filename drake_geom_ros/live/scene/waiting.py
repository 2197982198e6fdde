"""Frames that have never received a pose, and the pairs that queries omit because of them."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, NamedTuple

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.geometry import FrameId, QueryObject
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
            # rclpy checks each name of a list that is set: 0.2 ms for 4000, in each cycle.
            if getattr(message, 'waiting_frames', None) is not self.frames:
                message.waiting_frames = self.frames
            message.waiting_pairs = self.pairs
        self.beside.fill(*messages)

    def tell_geometries(self, message: Any) -> None:
        """Say it in an answer about geometries."""
        message.waiting_frames, message.waiting_geometries = self.frames, self.geometries
        self.beside.fill(message)


class WaitingNames:
    """Names of the frames that wait, made once for the same frames, names and absent ones.

    Each cycle asks for them, of a robot of 4000 links that nobody poses too.
    """

    def __init__(self) -> None:
        self._frames: list[FrameId] = []
        self._table: NameTable | None = None
        self._absent: Collection[int] = ()
        self._names: list[str] = []

    def of(
        self, frames: list[FrameId], table: NameTable, absent: Collection[int] = ()
    ) -> list[str]:
        """Return the full names of ``frames`` without those that are ``absent``.

        The same list while all three are the same; nobody changes it.
        """
        is_same = table is self._table and absent == self._absent and frames == self._frames
        if not is_same:
            self._frames, self._table, self._absent = frames, table, absent
            self._names = [table.frame_names[f] for f in frames if f.get_value() not in absent]
        return self._names


def waiting(
    query: QueryObject,
    names: NameTable,
    beside: BesideBodies = NOTHING_BESIDE,
    absent: Collection[int] = (),
    listed: WaitingNames | None = None,
) -> Waiting:
    """Return what waits in the scene of a query object, and what was seen beside bodies.

    For frames that are ``absent``, by the values of their ids, nobody waits. ``listed`` keeps the
    names from one call to the next.
    """
    frames = (listed or WaitingNames()).of(query.waiting_frames(), names, absent)
    if not frames:
        return Waiting([], 0, 0, beside)
    pairs, geometries = query.num_waiting_pairs(), query.num_waiting_geometries()
    return Waiting(frames, pairs, geometries, beside)
