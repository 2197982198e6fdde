"""Since when each frame has its pose. No ROS import."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from drake_geom_ros.ros.conversions.names import NameTable


class PoseAges:
    """Times of frame poses by the value of the frame's id; ages [s] by one clock."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._posed_at: dict[int, float] = {}

    def note(self, posed_at: Mapping[int, float]) -> None:
        """Note since when [s] frames have their poses; inf: a pose that does not grow old."""
        self._posed_at.update(posed_at)

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
