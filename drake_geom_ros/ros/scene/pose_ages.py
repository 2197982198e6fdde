"""Since when each frame has its pose, by the node's clocks and by the sender's. No ROS import.

Only the pose of a frame that is expected to move grows old. A pose that a scene file gives, or a
static transform of TF, holds until another one comes, and so does any pose of a frame that is
declared static. A frame is expected to move once a pose came for it by a message, or where it is
declared so: then the pose of a scene file is of unknown age.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from drake_geom_ros.common.counting import counted
from drake_geom_ros.ros.conversions.names import NameTable, some_of
from drake_geom_ros.ros.scene.clocks import ALWAYS, Clocks, Since


class UnknownAges(NamedTuple):
    """The full names of the frames that were posed, but not since the node's clock jumped."""

    frames: list[str]

    def in_words(self) -> str:
        """Return a sentence about it; empty where there are none."""
        if not self.frames:
            return ''
        return (
            f'the poses of {counted(len(self.frames), "frame")} are of unknown age, from before '
            'the clock jumped: '
            f'{some_of(self.frames)}'
        )


class PoseAges:
    """Times of frame poses by the value of the frame's id; ages [s] by two clocks."""

    def __init__(self, clocks: Clocks) -> None:
        self._clocks = clocks
        self._posed: dict[int, Since] = {}
        self._stamps: dict[int, Any] = {}
        self.newest_stamp: Any = None  # builtin_interfaces/Time; None before the first pose
        self._latest = ALWAYS
        self._declared: dict[int, bool] = {}  # static or expected to move, as the scene says
        self._static: set[int] = set()  # those of them that are static

    def begin(self, with_poses: Iterable[int], declared: Mapping[int, bool]) -> None:
        """Take over the frames of a scene: which it gives a pose, and what it says of which."""
        self._declared.update(declared)
        self._static = {value for value, static in self._declared.items() if static}
        rest = (value for value in with_poses if declared.get(value) is not False)
        self._posed.update(dict.fromkeys(rest, ALWAYS))

    def static(self) -> dict[int, bool]:
        """Return which frames are static (true) or expected to move (false), as far as known."""
        moved = (value for value, since in self._posed.items() if since != ALWAYS)
        return {**self._declared, **dict.fromkeys(moved, False)}

    def note(self, posed: Mapping[int, Since], stamp: Any) -> None:
        """Note since when frames have their poses.

        ``stamp`` is when these held by the sender's clock. A message that comes late must not make
        the others' poses older, and none is newest that is not there any more, or that is of the
        time before the clock jumped.
        """
        self._posed.update(posed)
        if self._static:
            self._posed.update(dict.fromkeys(self._static & posed.keys(), ALWAYS))
        self._latest = max((s for s in set(posed.values()) if s != ALWAYS), default=ALWAYS)
        self._stamps.update(dict.fromkeys(posed, stamp))
        if self.newest_stamp is None or time_of(stamp) >= time_of(self.newest_stamp):
            self.newest_stamp = stamp
        else:
            epoch = max(since.epoch for since in posed.values())
            alive = (s for frame, s in self._stamps.items() if self._posed[frame].epoch >= epoch)
            self.newest_stamp = max(alive, key=time_of)

    def by_name(self, names: NameTable) -> dict[str, float]:
        """Return the age [s] of the pose of every frame by name; inf for one that is unknown."""
        ages = {value: self._clocks.age(since) for value, since in self._posed.items()}
        return {
            name: ages.get(frame.get_value(), math.inf)
            for frame, name in names.frame_names.items()
            if frame != names.world
        }

    def unknown(self, names: NameTable) -> list[str]:
        """Return the names of the frames that were posed, but not since the clock jumped."""
        epoch = self._clocks.epoch
        before = {value for value, since in self._posed.items() if since.epoch < epoch}
        if not before:
            return []
        return [name for frame, name in names.frame_names.items() if frame.get_value() in before]

    def lag(self) -> float:
        """Return the age [s] of what was noted last; inf: unknown, 0: it does not grow old."""
        return self._clocks.age(self._latest)

    def oldest(self, names: NameTable) -> float:
        """Return the age [s] of the oldest frame pose; inf when one is unknown."""
        frames = len(names.frame_names) - 1
        if not frames:
            return 0.0
        if len(self._posed) < frames:
            return math.inf
        # The frames of a message have their poses since the same moment.
        return max(map(self._clocks.age, set(self._posed.values())))


def time_of(stamp: Any) -> tuple[int, int]:
    """Return a builtin_interfaces/Time as what can be compared."""
    return stamp.sec, stamp.nanosec
