"""Ages of frame poses: which of them grow old, and since when; ``clocks`` compute the seconds.

Only the pose of a frame that is expected to move grows old. A pose that a scene file gives, or a
static transform of TF, holds until another one comes, and so does any pose of a frame that is
declared static. A frame is expected to move once a pose came for it by a message, or where it is
declared so: then the pose of a scene file is of unknown age.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from drake_geom_ros.common.counting import counted
from drake_geom_ros.live.conversions.names import NameTable, some_of
from drake_geom_ros.live.scene.clocks import ALWAYS, Clocks, Since


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


class Oldest(NamedTuple):
    """The age [s] of the oldest pose, and the value of its frame's id, 0 where none grows old."""

    age: float
    frame: int

    def after(self, seconds: float) -> Oldest:
        """Return the same pose some seconds later."""
        return self._replace(age=self.age + seconds) if self.frame else self


class _Unposed(NamedTuple):
    """The frames of a table, by the values of their ids, that have no pose."""

    names: NameTable
    frames: frozenset[int]


# Since when frames have their poses: those of a message have them since the same moment.
PosedFrames = Mapping[frozenset[int], Since]


@dataclass
class _Together:
    """The common data of frames that were posed together."""

    since: Since
    stamp: Any  # None: of no message
    left: int  # how many of them were not posed otherwise meanwhile


class PoseAges:
    """Times of frame poses by the value of the frame's id; ages [s] by two clocks.

    A sender names the same frames in each message: then one time changes, not one for each.
    """

    def __init__(self, clocks: Clocks) -> None:
        self._clocks = clocks
        self._posed: dict[int, _Together] = {}
        self._together: dict[frozenset[int], _Together] = {}  # of which some are left
        self.newest_stamp: Any = None  # builtin_interfaces/Time; None before the first pose
        self._latest = ALWAYS
        self._declared: dict[int, bool] = {}  # static or expected to move, as the scene says
        self._static: set[int] = set()  # those of them that are static
        self._resting: dict[int, bool | None] = {}  # and what the scene says of the attached ones
        self._unposed: _Unposed | None = None  # None: to be found

    def begin(self, with_poses: Iterable[int], declared: Mapping[int, bool]) -> None:
        """Take over the frames of a scene: which it gives a pose, and what it says of which."""
        self._declared.update(declared)
        self._static = {value for value, static in self._declared.items() if static}
        rest = (value for value in with_poses if declared.get(value) is not False)
        self._pose(frozenset(rest), ALWAYS, None)

    def forget(self, frames: Iterable[int]) -> None:
        """Know nothing more of frames that are gone."""
        frames = list(frames)
        self.wait(frames)
        for value in frames:
            self._declared.pop(value, None)
            self._static.discard(value)
            self._resting.pop(value, None)

    def wait(self, frames: Iterable[int]) -> None:
        """Know no pose of frames, which wait for one."""
        self._unposed = None
        for value in frames:
            if (together := self._posed.pop(value, None)) is not None:
                together.left -= 1
        self._together = {f: each for f, each in self._together.items() if each.left}

    def keep(self, frames: Iterable[int], since: Since) -> None:
        """Have frames have their poses since a moment that is known already."""
        self._pose(frozenset(frames), since, None)

    def rest(self, frame: int) -> None:
        """Let the pose of a frame hold for good, which is attached to another one."""
        self._resting.setdefault(frame, self._declared.get(frame))
        self._declared[frame] = True
        self._static.add(frame)
        self.keep([frame], ALWAYS)

    def rest_no_more(self, frame: int, since: Since) -> None:
        """Let a pose grow old again, which it has since then."""
        before = self._resting.pop(frame)
        self._static.discard(frame)
        del self._declared[frame]
        if before is not None:
            self._declared[frame] = before
        if before:
            self._static.add(frame)
        self.keep([frame], ALWAYS if before else since)

    def since(self, frame: int) -> Since | None:
        """Return since when a frame has its pose; None where it waits, or nobody knows."""
        together = self._posed.get(frame)
        return None if together is None else together.since

    def static(self) -> dict[int, bool]:
        """Return which frames are static (true) or expected to move (false), as far as known."""
        moved = (value for value, together in self._posed.items() if together.since != ALWAYS)
        return {**self._declared, **dict.fromkeys(moved, False)}

    def posed_by(self, frames: frozenset[int], since: Since, stamp: Any) -> PosedFrames:
        """Return since when frames have the poses of a message that is heard ``since``.

        The same stamp (not 0, which is none) coming again for a frame is no new pose.
        """
        together = self._together.get(frames)
        if time_of(stamp) == (0, 0) or not frames:
            return {frames: since} if frames else {}
        if together is not None and together.left == len(frames):
            return {frames: _again(together, since, stamp)}
        frames_by_since: dict[Since, set[int]] = {}
        for frame in frames:
            frames_by_since.setdefault(_again(self._posed.get(frame), since, stamp), set()).add(
                frame
            )
        return {frozenset(some): each for each, some in frames_by_since.items()}

    def note(self, posed: PosedFrames, stamp: Any) -> None:
        """Note since when frames have their poses.

        ``stamp`` is when these held by the sender's clock. A message that comes late must not make
        the others' poses older, and none is newest that is not there any more, or that is of the
        time before the clock jumped.
        """
        for frames, since in posed.items():
            if static := frames & self._static:
                self._pose(static, ALWAYS, stamp)
                self._pose(frames - static, since, stamp)
            else:
                self._pose(frames, since, stamp)
        moving = [since for since in posed.values() if since != ALWAYS]
        self._latest = max(moving, default=ALWAYS)
        if self.newest_stamp is None or time_of(stamp) >= time_of(self.newest_stamp):
            self.newest_stamp = stamp
        elif moving:
            epoch = max(since.epoch for since in posed.values())
            stamped = (t for t in self._together.values() if t.stamp is not None)
            alive = (together.stamp for together in stamped if together.since.epoch >= epoch)
            self.newest_stamp = max(alive, key=time_of)

    def _pose(self, frames: frozenset[int], since: Since, stamp: Any) -> None:
        """Note since when frames have the poses of one message."""
        together = self._together.get(frames)
        if together is not None and together.left == len(frames):
            together.since, together.stamp = since, stamp
            return
        together = _Together(since, stamp, len(frames))
        for frame in frames:
            if (before := self._posed.get(frame)) is not None:
                before.left -= 1
            else:
                self._unposed = None
            self._posed[frame] = together
        self._together[frames] = together
        self._together = {f: each for f, each in self._together.items() if each.left}

    def by_name(self, names: NameTable) -> dict[str, float]:
        """Return the age [s] of the pose of every frame by name; inf for one that is unknown."""
        age = self._clocks.ages()
        ages = {value: age(together.since) for value, together in self._posed.items()}
        return {
            name: ages.get(frame.get_value(), math.inf)
            for frame, name in names.frame_names.items()
            if frame != names.world
        }

    def unknown(self, names: NameTable) -> list[str]:
        """Return the names of the frames that were posed, but not since the clock jumped."""
        epoch = self._clocks.epoch
        if all(together.since.epoch >= epoch for together in self._together.values()):
            return []
        before = {value for value, t in self._posed.items() if t.since.epoch < epoch}
        return [name for frame, name in names.frame_names.items() if frame.get_value() in before]

    def of_other_clocks(self) -> dict[int, float]:
        """Return the frames posed with stamps of another clock, and how far [s] these lie behind.

        Negative: ahead.
        """
        groups = [(fs, t) for fs, t in self._together.items() if t.since.offset]
        return {f: t.since.offset for fs, t in groups for f in fs if self._posed.get(f) is t}

    def stale(self, seconds: float) -> dict[int, float]:
        """Return the ages [s] of the poses that are older than ``seconds``, by frame."""
        groups = zip(self._together.items(), self._ages_of_groups(), strict=True)
        old = [(frames, group, age) for (frames, group), age in groups if age > seconds]
        return {f: age for fs, group, age in old for f in fs if self._posed.get(f) is group}

    def _ages_of_groups(self) -> list[float]:
        """Return the age [s] of each set of frames that were posed together."""
        return self._clocks.ages_of([each.since for each in self._together.values()])

    def older_than(self, seconds: float, names: NameTable) -> frozenset[int]:
        """Return the frames whose poses are older [s], or of unknown age; those that wait, too.

        The same set while no frame has a pose that is older, and the same ones wait.
        """
        old, unposed = self.stale(seconds), self._unposed_of(names)
        return unposed.union(old) if old else unposed

    def _unposed_of(self, names: NameTable) -> frozenset[int]:
        """Return the frames of a table that have no pose, found once while they are the same."""
        if self._unposed is None or self._unposed.names is not names:
            frames = frozenset(names.frame_values).difference(self._posed)
            self._unposed = _Unposed(names, frames)
        return self._unposed.frames

    def lag(self) -> float:
        """Return the age [s] of what was noted last; inf: unknown, 0: it does not grow old."""
        return self._clocks.age(self._latest)

    def oldest(self, names: NameTable) -> Oldest:
        """Return the age [s] of the oldest frame pose, inf when one is unknown, and its frame."""
        frames, posed = names.frame_values, self._posed
        if not frames:
            return Oldest(0.0, 0)
        if len(posed) < len(frames):
            return Oldest(math.inf, next(value for value in frames if value not in posed))
        ages = self._ages_of_groups()
        oldest = max(ages)
        if not oldest:
            return Oldest(0.0, 0)
        group_frames, group = list(self._together.items())[ages.index(oldest)]
        # Some of those that were posed together were posed otherwise since.
        return Oldest(oldest, next(f for f in group_frames if posed.get(f) is group))


def _again(before: _Together | None, since: Since, stamp: Any) -> Since:
    """Return since when a pose holds that is heard ``since``, and ``before`` which was there."""
    if before is None or before.stamp is None or time_of(before.stamp) != time_of(stamp):
        return since
    return since.said_again(before.since)


def time_of(stamp: Any) -> tuple[int, int]:
    """Return a builtin_interfaces/Time as what can be compared."""
    return stamp.sec, stamp.nanosec
