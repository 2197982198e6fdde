"""Since when each frame has its pose, by the node's clock and by the sender's. No ROS import."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from drake_geom_ros.ros.conversions.names import NameTable


class PoseAges:
    """Times of frame poses by the value of the frame's id; ages [s] by one clock."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._posed_at: dict[int, float] = {}
        self._stamps: dict[int, Any] = {}
        self.newest_stamp: Any = None  # builtin_interfaces/Time; None before the first pose

    def note(self, posed_at: Mapping[int, float], stamp: Any) -> None:
        """Note since when [s] frames have their poses; inf: a pose that does not grow old.

        ``stamp`` is when these held by the sender's clock. A message that comes late must not make
        the others' poses older, and none is newest that is not there any more.
        """
        self._posed_at.update(posed_at)
        self._stamps.update(dict.fromkeys(posed_at, stamp))
        if self.newest_stamp is None or time_of(stamp) >= time_of(self.newest_stamp):
            self.newest_stamp = stamp
        else:
            self.newest_stamp = max(self._stamps.values(), key=time_of)

    def by_name(self, names: NameTable) -> dict[str, float]:
        """Return the age [s] of the pose of every frame by name; inf for one never posed."""
        posed, now = self._posed_at, self._now()
        return {
            name: max(0.0, now - posed.get(frame.get_value(), -math.inf))
            for frame, name in names.frame_names.items()
            if frame != names.world
        }

    def oldest(self, names: NameTable) -> float:
        """Return the age [s] of the oldest frame pose; inf when a frame was never posed."""
        frames = len(names.frame_names) - 1
        if not frames:
            return 0.0
        if len(self._posed_at) < frames:
            return math.inf
        return max(0.0, self._now() - min(self._posed_at.values()))


def time_of(stamp: Any) -> tuple[int, int]:
    """Return a builtin_interfaces/Time as what can be compared."""
    return stamp.sec, stamp.nanosec
