"""Twists of frames: from messages, or from the last two stamped poses.

A twist holds for the pose that it belongs to: one of a message, until a pose with a later stamp
comes; one from two poses, for the later of them. So none is older than the pose it is used with,
nor is any used that is ahead of it, from before a jump of the clock, or too old by itself.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import FrameId, FramePoseVector, QueryObject
from drake_geom_ros.live.conversions.names import NameTable, some_of
from drake_geom_ros.live.scene.clocks import ALWAYS, Clocks, Since
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats

_NANOSECONDS = 1e-9  # [s]
_REMEMBERED = 5.0  # [s] for which a twist is told of that was not used


class _Posed(NamedTuple):
    """A pose X_PF and, if an earlier one is near enough, the twist V_PF (6,) between them."""

    stamp: int  # [ns]
    since: Since
    X_PF: RigidTransform
    V_PF: Floats | None


class _Told(NamedTuple):
    """A twist (6,) of a message: V_WF, or V_PF in the frame's parent, in the axes of that."""

    stamp: int  # [ns]
    since: Since
    V: Floats
    in_parent: bool


class FrameTwists:
    """The twists of the frames of one scene, by the values of their ids."""

    def __init__(self, longest_gap: float, clocks: Clocks) -> None:
        """Poses farther apart than ``longest_gap`` [s] give no twist.

        Nor does a twist that is older, or that is stamped later than its pose by more.
        """
        self._longest_gap = longest_gap
        self._clocks = clocks
        self._poses: dict[int, _Posed] = {}
        self._told: dict[int, _Told] = {}

    def note_poses(self, poses: FramePoseVector, stamps: Mapping[int, tuple[int, Since]]) -> None:
        """Note the poses of frames, by id value their stamps [ns] and since when they hold.

        A stamp of 0: the pose bears none. What holds for ever rests from now on.
        """
        for value, (stamp, since) in stamps.items():
            if since == ALWAYS:
                self._poses.pop(value, None)
                self._told.pop(value, None)
                continue
            X_PF, before = poses.value(FrameId(value)), self._poses.get(value)
            V_PF = None
            if stamp and before is not None and before.stamp and since.epoch == before.since.epoch:
                seconds = (stamp - before.stamp) * _NANOSECONDS
                if seconds == 0.0:  # said twice
                    V_PF = before.V_PF
                elif 0.0 < seconds <= self._longest_gap:
                    V_PF = _twist(before.X_PF, X_PF, seconds)
            self._poses[value] = _Posed(stamp, since, X_PF, V_PF)

    def forget(self, frames: Iterable[int]) -> None:
        """Know nothing more of some frames."""
        for value in frames:
            self._poses.pop(value, None)
            self._told.pop(value, None)

    def note_twists(
        self,
        frames: NDArray[np.int64],
        twists: Floats,
        stamp: int,
        since: Since,
        *,
        in_parent: bool = False,
    ) -> None:
        """Note the twists V_WF (n, 6) of frames (n,), their stamp [ns] and how long they hold.

        ``in_parent``: they are V_PF.
        """
        for value, twist in zip(frames.tolist(), twists, strict=True):
            before = self._told.get(value)
            held = since
            if before is not None and before.stamp == stamp:
                held = since.said_again(before.since)
            self._told[value] = _Told(stamp, held, twist, in_parent)

    def in_world(self, query: QueryObject, static: Mapping[int, bool]) -> dict[FrameId, Floats]:
        """Return V_WF (6,) of the frames whose motion is known, at the poses of now.

        A frame that never had a stamped pose, nor was said to move, rests in its parent where
        ``static`` says so, or says nothing; where it says False, it is expected to move, and
        nobody knows how.
        """
        inspector, age = query.inspector(), self._clocks.ages()
        world = inspector.world_frame_id()
        V_WFs: dict[FrameId, Floats | None] = {world: np.zeros(6)}
        for frame in inspector.FramesParentsFirst():
            if frame != world and query.is_placed(frame):
                value = frame.get_value()
                message = self._told.get(value)
                if message is not None and self._why_not(value, age):
                    message = None
                if message is not None and not message.in_parent:
                    V_WFs[frame] = message.V
                    continue
                parent = inspector.GetParentFrame(frame)
                rests = static.get(value, True)
                V_PF = self._of_poses(value, rests, age) if message is None else message.V
                V_WFs[frame] = _carried(frame, parent, V_WFs.get(parent), V_PF, query)
        return {frame: V for frame, V in V_WFs.items() if V is not None}

    def troubles(self, names: NameTable) -> list[str]:
        """Return in words which twists came of late and are of no use."""
        age = self._clocks.ages()
        unused = defaultdict(list)
        for frame, name in names.frame_names.items():
            message = self._told.get(value := frame.get_value())
            # One that a pose overtook is no trouble, and one of before a jump is until it is told
            # anew, as poses are.
            since = None if message is None else message.since._replace(offset=0.0)
            if since is None or _REMEMBERED < age(since) < math.inf:
                continue
            if (why := self._why_not(value, age)) and why != _OVERTAKEN:
                unused[why].append(name)
        return [
            f'the twists of {counted(len(frames), "frame")} are not used, because they are '
            f'{why.format(gap=self._longest_gap)}: {some_of(frames)}'
            for why, frames in unused.items()
        ]

    def _why_not(self, value: int, age: Callable[[Since], float]) -> str:
        """Return why the twist of a frame's message cannot be used now; empty if it can."""
        message, pose = self._told[value], self._poses.get(value)
        old = age(message.since)
        if message.since.offset:
            return _OTHER_CLOCK
        if math.isinf(old):
            return _OF_BEFORE
        if pose is None:
            ahead = message.stamp * _NANOSECONDS - self._clocks.node()
        elif not pose.stamp:
            return _WITHOUT
        else:
            ahead = (message.stamp - pose.stamp) * _NANOSECONDS
            if ahead < 0.0:
                return _OVERTAKEN
        if ahead > self._longest_gap:
            return _AHEAD
        return _OLD if old > self._longest_gap else ''

    def _of_poses(self, value: int, rests: bool, age: Callable[[Since], float]) -> Floats | None:
        """Return V_PF (6,) from the last poses of a frame; None if it is unknown."""
        pose = self._poses.get(value)
        if pose is not None and pose.V_PF is not None and age(pose.since) <= self._longest_gap:
            return pose.V_PF
        # What was said to move is no longer known to rest.
        return np.zeros(6) if rests and value not in self._told else None


_AHEAD = (
    'stamped more than {gap:g} s later than the pose, or than now where no message poses the '
    'frame; do their sender and the one of the poses use the same clock?'
)
_OF_BEFORE = 'from before the clock jumped'
_OLD = 'older than {gap:g} s'
_OTHER_CLOCK = 'stamped by another clock than that of the node'
_WITHOUT = 'for poses that bear no stamp'
_OVERTAKEN = 'overtaken by a pose'


def _carried(
    frame: FrameId,
    parent: FrameId,
    V_WP: Floats | None,
    V_PF: Floats | None,
    query: QueryObject,
) -> Floats | None:
    """Return V_WF (6,) of a frame that moves in its parent; None where one is not known."""
    if V_WP is None or V_PF is None:
        return None
    if parent == query.inspector().world_frame_id():
        return V_PF
    X_WP = query.X_WF(parent)
    R_WP, p_PF_W = (
        X_WP.rotation().matrix(),
        query.X_WF(frame).translation() - X_WP.translation(),
    )
    carried = np.concatenate((V_WP[:3], V_WP[3:] + np.cross(V_WP[:3], p_PF_W)))
    return carried + np.concatenate((R_WP @ V_PF[:3], R_WP @ V_PF[3:]))


def _twist(before: RigidTransform, after: RigidTransform, seconds: float) -> Floats:
    """Return the mean spatial velocity [w, v] (6,) from one pose to the other, in the parent."""
    turn = (after.rotation() @ before.rotation().inverse()).ToAngleAxis()
    w = turn.angle() * turn.axis()
    return np.concatenate((w, after.translation() - before.translation())) / seconds
