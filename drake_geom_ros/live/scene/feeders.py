"""Inputs or publishers that posed a frame, a joint or a transform last, and those that alternate.

The last one counts; ``senders`` has those of publishers.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable
from typing import Any

TF, MESSAGES, JOINTS = 'TF', '~/frame_poses', 'joint states'
OBSTACLES = '~/obstacles'
TRACKERS = '~/tracked_objects'
_ALL = TF, MESSAGES, JOINTS, OBSTACLES, TRACKERS
_BY_TURNS = 1.0  # [s] a frame that changes hands again that soon is not handed over
_REMEMBERED = 5.0  # [s] for which it is told of


class Feeders:
    """The frames, by the value of their id, that each feeder posed last.

    So it is for whatever has a name, and any feeders: joints, transforms, identities of senders.
    """

    def __init__(self, now: Callable[[], float]) -> None:
        """``now()`` [s] is of steady time."""
        self._now = now
        self._frames: dict[Hashable, set[Any]] = defaultdict(set, {f: set() for f in _ALL})
        # What was noted last, where nothing of it was handed over since: a stream repeats it.
        self._last: dict[Hashable, frozenset[Any]] = {}
        self._handed: dict[Any, float] = {}  # when [s] a frame was handed over
        self._contested: dict[Any, float] = {}  # when [s] that happened by turns

    def note(self, feeder: Hashable, frames: frozenset[Any]) -> None:
        """Note who poses frames now."""
        if frames is self._last.get(feeder):
            return
        fresh = frames - self._frames[feeder]
        if fresh:
            self._last.clear()
        self._last[feeder] = frames
        if not fresh:
            return
        now = self._now()
        self._frames[feeder] |= fresh
        for other, frames_of_other in self._frames.items():
            if other == feeder:
                continue
            for frame in frames_of_other & fresh:
                if now - self._handed.get(frame, -math.inf) < _BY_TURNS:
                    self._contested[frame] = now
                self._handed[frame] = now
            frames_of_other -= fresh

    def fed_by_others(self, feeder: str) -> frozenset[int]:
        """Return the frames that somebody else than a feeder was the last to pose."""
        return frozenset().union(*(some for who, some in self._frames.items() if who != feeder))

    def is_fed_by_others(self, feeder: str, frame: int) -> bool:
        """Return whether somebody else than a feeder was the last who posed a frame."""
        return any(frame in frames for who, frames in self._frames.items() if who != feeder)

    def forget(self, frames: Iterable[int]) -> None:
        """Have nobody be the last who posed some frames."""
        gone = set(frames)
        self._last.clear()
        for fed in self._frames.values():
            fed -= gone
        for times in (self._handed, self._contested):
            for frame in gone & times.keys():
                del times[frame]

    def is_fed_by(self, feeder: str, frame: int) -> bool:
        """Return whether a feeder was the last who posed a frame."""
        return frame in self._frames[feeder]

    def contested(self) -> list[Any]:
        """Return the frames that two pose by turns."""
        now = self._now()
        return [frame for frame, seen in self._contested.items() if now - seen < _REMEMBERED]
