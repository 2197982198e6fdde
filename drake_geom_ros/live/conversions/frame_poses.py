"""FramePoses and FrameTwists messages to arrays: ids of frames, poses and twists."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import ArgumentError, FrameId, FramePoseVector
from drake_geom_ros.live.conversions.message_types import (
    FramePosesMessage,
    FrameTwistsMessage,
    ListedFramesMessage,
)
from drake_geom_ros.live.conversions.names import NameTable

_POSE_WIDTH = 7
_TWIST_WIDTH = 6


# The source, the names and the ids of a message.
_Listing: TypeAlias = tuple[str, tuple[str, ...], tuple[int, ...]]


class ReadPoses(NamedTuple):
    """The poses of a FramePoses message."""

    poses: FramePoseVector
    frames: frozenset[int]  # by the values of their ids; the same object for the same list
    rows: NDArray[np.float64]  # (n, 7) what the poses were read from


class ListedFrames(NamedTuple):
    """The frames that a message lists."""

    ids: NDArray[np.int64]  # (n,) in its order
    frames: frozenset[int]


class FramePosesReader:
    """Reads FramePoses and FrameTwists messages of one version of a scene.

    A stream names the same frames again and again, so the look-up of a list of names is kept.
    """

    def __init__(self, names: NameTable) -> None:
        self._names = names
        self._world_frame = names.frame_names[names.world]
        self._known: dict[_Listing, ListedFrames] = {}
        # To find a thousand names takes 10 us (50 after other work); those of the last message are
        # most often the same objects.
        self._last: tuple[_Listing, ListedFrames] | None = None

    def read(self, message: FramePosesMessage) -> ReadPoses:
        """Return the poses of a message; raises RuntimeError, and nothing is half read."""
        ids, frames = self.listed_in(message)
        poses = np.asarray(message.poses, dtype=np.float64)
        if poses.size != _POSE_WIDTH * len(frames):
            raise ArgumentError(
                f'poses holds {poses.size} numbers for {counted(len(frames), "frame")}; it must '
                f'hold {_POSE_WIDTH} for each frame: x y z qx qy qz qw'
            )
        rows = poses.reshape(-1, _POSE_WIDTH)
        return ReadPoses(FramePoseVector.FromArrays(ids, rows), frames, rows)

    def read_twists(
        self, message: FrameTwistsMessage
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the ids (n,) of frames and V_WF (n, 6) of a FrameTwists; raises RuntimeError."""
        ids = self.listed_in(message).ids
        twists = np.asarray(message.twists, dtype=np.float64)
        if twists.size != _TWIST_WIDTH * len(ids) or not np.isfinite(twists).all():
            raise ArgumentError(
                f'twists holds {twists.size} numbers for {counted(len(ids), "frame")}; it must '
                f'hold {_TWIST_WIDTH} finite ones a frame: wx wy wz vx vy vz'
            )
        return ids, twists.reshape(-1, _TWIST_WIDTH)

    def listed_in(self, message: ListedFramesMessage) -> ListedFrames:
        """Return the frames that a message names; raises RuntimeError for names that are none."""
        frame_id = message.header.frame_id
        if frame_id not in ('', self._world_frame):
            raise ArgumentError(
                f'header.frame_id is {frame_id[:80]!r}; it must be the world frame, '
                f'{self._world_frame!r}, or empty'
            )
        if len(message.frame_names) and len(message.frame_ids):
            raise ArgumentError('frame_names and frame_ids are both given; exactly one must be')
        # Names and ids apart: a frame may be named as the id of another.
        key = (message.source, tuple(message.frame_names), tuple(message.frame_ids))
        if self._last is not None and self._last[0] == key:
            return self._last[1]
        listed = self._known.get(key)
        if listed is None:
            ids = [frame.get_value() for frame in self._look_up(message)]
            listed = ListedFrames(np.array(ids, dtype=np.int64), frozenset(ids))
            # One list for each sender; a sender whose lists never repeat must not fill the memory.
            if len(self._known) >= 64:
                self._known.clear()
            self._known[key] = listed
        self._last = key, listed
        return listed

    def _look_up(self, message: ListedFramesMessage) -> list[FrameId]:
        names, source = self._names, message.source
        if source:
            names.source(source)
        if message.frame_names:
            frames = [names.frame(name, source) for name in message.frame_names]
        else:
            frames = [names.frame_of_value(value) for value in message.frame_ids]
        for frame in frames:
            full = names.frame_names[frame]
            if source and (frame == names.world or names.labels[frame][0] != source):
                raise ArgumentError(f"frame '{full}' does not belong to source '{source}'")
            if frame == names.world:
                raise ArgumentError('the world frame cannot be posed')
            if frame in names.of_maps:
                raise ArgumentError(
                    f"frame '{full}' is that of a sensed map, which stands where it was seen"
                )
        if len(set(frames)) != len(frames):
            twice = next(f for k, f in enumerate(frames) if f in frames[:k])
            raise ArgumentError(f"frame '{names.frame_names[twice]}' is named twice")
        return frames
