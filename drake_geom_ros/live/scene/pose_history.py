"""The poses of frames in the last seconds, for measurements at a stamp.

Between two poses of a frame the position goes straight and the orientation by the shorter arc.
A pose that was made of parts, each with a time of its own (the base and the joints of a robot, the
transforms of a chain), is that of no time: such parts are kept instead, and put together anew as
each of them was at the time that is asked about.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from drake_geom_ros.geometry import FrameId, SceneGraphInspector
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.pose_ages import PosedFrames
from drake_geom_ros.live.scene.tracks import KEPT, Bracket, Track, UnknownThenError
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import slerp

_MOST_TRACKS = 64  # sets of frames that came together; more are looked through for old ones
_REMEMBERED = 60.0  # [s] for which it is known since when somebody poses a frame


class Then(Protocol):
    """Poses of other frames at the same time; one that is not known raises UnknownThenError."""

    @property
    def inspector(self) -> SceneGraphInspector:
        """The inspector of the scene."""

    def X_PF(self, frame: FrameId) -> RigidTransform:
        """Return the pose of a frame in its parent."""

    def X_WF(self, frame: FrameId) -> RigidTransform:
        """Return the pose of a frame in the world."""


PoseThen = Callable[[int, Then], Floats]  # X_PF (7,) of a frame; may raise UnknownThenError


class Parts(Protocol):
    """The parts of which the poses of frames are made."""

    def around(self, time: float) -> PoseThen:
        """Return the poses around a time [s], unaffected by later messages; the scene is held."""


class _Rows(NamedTuple):
    """The poses X_PF (n, 7) of frames (n,) that came together."""

    ids: Indices
    rows: Floats


class PoseHistory:
    """Keeps what came for frames that move, by id values."""

    def __init__(self) -> None:
        self._tracks: dict[frozenset[int], Track[_Rows]] = {}
        self._fed: dict[str, set[int]] = {}  # by feeder: the frames that it posed last
        self._parts: dict[int, Parts] = {}
        self._begun: dict[int, float] = {}  # [s] since when the feeder, or the parent, is that

    def note(
        self,
        poses: tuple[Indices, Floats],
        posed: PosedFrames,
        feeder: str,
        now: float,
        parts: Parts | None = None,
    ) -> None:
        """Keep the poses (n, 7) of frames (n,), of which those of ``posed`` count.

        ``now`` [s] is the node's time; ``parts`` are what they were made of, where these have
        times of their own.
        """
        moving = {frames: since for frames, since in posed.items() if since != ALWAYS}
        own = self._fed.setdefault(feeder, set())
        if fresh := frozenset().union(*moving) - own:
            self._hand_over(fresh, feeder, now)
        if parts is not None:
            for frames in moving:
                self._parts.update(dict.fromkeys(frames, parts))
            return
        ids, rows = poses
        copied = _Rows(ids, rows.copy())  # senders' arrays are filled anew
        for frames, since in moving.items():
            if frames not in self._tracks:
                self._make_room(since.held)
            self._tracks.setdefault(frames, Track()).note(copied, since)

    def _hand_over(self, frames: frozenset[int], feeder: str, now: float) -> None:
        """Note that somebody poses frames whom others posed before, or nobody."""
        for other, frames_of_other in self._fed.items():
            if taken := frames_of_other & frames if other != feeder else None:
                self._begun.update(dict.fromkeys(taken, now))
                frames_of_other -= taken
        self._fed[feeder] |= frames
        for frame in frames:
            self._parts.pop(frame, None)

    def _make_room(self, time: float) -> None:
        if len(self._tracks) >= _MOST_TRACKS:
            alive = {f: track for f, track in self._tracks.items() if track.newest > time - KEPT}
            self._tracks = alive

    def begin_anew(self, frames: Iterable[int], now: float) -> None:
        """Note that from ``now`` [s] on frames hang on others than before."""
        gone = frozenset(frames)
        self._tracks = {f - gone: track for f, track in self._tracks.items() if f - gone}
        for fed in self._fed.values():
            fed -= gone
        for frame in gone:
            self._parts.pop(frame, None)
        self._begun.update(dict.fromkeys(gone, now))

    def around(self, time: float) -> PosesAround:
        """Return what is known of a time [s]; what comes later does not change it."""
        self._begun = {f: at for f, at in self._begun.items() if at > time - _REMEMBERED}
        brackets = [(frames, track.around(time)) for frames, track in self._tracks.items()]
        then = {parts: parts.around(time) for parts in set(self._parts.values())}
        by_parts = {frame: then[parts] for frame, parts in self._parts.items()}
        return PosesAround(brackets, by_parts, {f for f, at in self._begun.items() if at > time})


class PosesAround:
    """The poses before and after a time."""

    def __init__(
        self,
        brackets: Sequence[tuple[frozenset[int], Bracket[_Rows]]],
        by_parts: Mapping[int, PoseThen],
        begun_later: set[int],
    ) -> None:
        """``begun_later``: frames that somebody else posed then, or that hung elsewhere."""
        self._brackets = brackets
        self._by_parts = by_parts
        self._begun_later = begun_later
        self._told: dict[tuple[int, int], Floats] = {}  # of two messages, the poses between

    def was_another(self, frame: int) -> bool:
        """Return whether the frame hung elsewhere then, or somebody else posed it."""
        return frame in self._begun_later

    def row(self, frame: int, then: Then) -> Floats:
        """Return X_PF (7,) of a frame; raises UnknownThenError where it is not known."""
        if self.was_another(frame):
            raise UnknownThenError(is_later=False)
        if (pose := self._by_parts.get(frame)) is not None:
            return pose(frame, then)
        joined: Bracket[_Rows] = Bracket(math.nan, None, None)
        for frames, bracket in self._brackets:
            if frame in frames:
                joined = bracket.joined(joined)
        first, last, share = joined.between()
        k = np.flatnonzero(first.ids == frame)[-1]
        if not share:
            return np.array(first.rows[k])
        if not np.array_equal(first.ids, last.ids):
            return between(first.rows[k], last.rows[np.flatnonzero(last.ids == frame)[-1]], share)
        both = id(first), id(last)  # which the brackets hold
        if both not in self._told:  # one after the other they took a third of what a cloud does
            self._told[both] = between(first.rows, last.rows, share)
        return np.array(self._told[both][k])


def between(a: Floats, b: Floats, share: float) -> Floats:
    """Return the poses (..., 7) that are so far on the way from some to others, 0 to 1."""
    q0, q1 = a[..., 3:], b[..., 3:]
    q1 = np.where((q0 * q1).sum(axis=-1, keepdims=True) >= 0.0, q1, -q1)
    turned = slerp(q0, q1, np.array([share]))
    return np.concatenate([a[..., :3] + share * (b[..., :3] - a[..., :3]), turned], axis=-1)
