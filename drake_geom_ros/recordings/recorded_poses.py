"""The poses of a recording over time, to be looked at."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.frame_names import Frame
from drake_geom_ros.geometry import FrameId
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.recordings.maps import told_maps
from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.player import Player
from drake_geom_ros.recordings.raw_messages import NANOSECONDS
from drake_geom_ros.recordings.states import Block, StateBlocks
from drake_geom_ros.recordings.topics import Topics
from drake_geom_ros.scene_files import SceneDescription, poses_in_parents


class TimedPoses(NamedTuple):
    """Poses that hold from a time on until the next: of all frames that have one by then."""

    time: float  # [s] since the recording began
    frames: tuple[Frame, ...]  # by source and name
    rows: NDArray[np.float64]  # (n, 7) X_PF


def recorded_poses(
    path: str | Path | Sequence[str | Path],
    scene: str | Path | SceneDescription,
    rate: float,
    topics: Topics | None = None,
    world_frame: str = 'world',
    package_roots: Sequence[str | Path] = (),
    tell: Callable[[str], None] | None = None,
) -> list[TimedPoses]:
    """Return the poses of a recording, so often a second [Hz]; raises as ``clearance``.

    ``tell`` is called with what is not known, was refused, or could not be read.
    """
    opened = opened_recording(
        path,
        scene=scene,
        topics=topics,
        stale_after=1.0,
        accuracy='exact',
        world_frame=world_frame,
        package_roots=package_roots,
    )
    player = Player(opened, StateBlocks(opened.playback, ()), rate)
    found = []
    for block in player.blocks():
        still = _still(block)
        inspector = block.context_query().inspector()
        ids = [*(FrameId(value) for value in block.frames.tolist()), *still]
        names = tuple((inspector.GetOwningSourceName(f), inspector.GetName(f)) for f in ids)
        rest = np.array([X_PF.ToArray() for X_PF in still.values()]).reshape(-1, 7)
        for stamp, rows in zip(block.times.tolist(), block.poses, strict=True):
            time = (stamp - player.begin) / NANOSECONDS
            found.append(TimedPoses(time, names, np.vstack((rows, rest))))
    if tell is not None:
        told = [each.in_words(player.begin) for each in opened.recording.damage]
        told += [each.words for each in opened.playback.troubles]
        told += opened.playback.differences()
        for words in [*told, *filter(None, [told_maps(opened.maps)])]:
            tell(words)
    return found


def _still(block: Block) -> dict[FrameId, RigidTransform]:
    """Return the poses X_PF of the frames that have one, and are no part of a block's states."""
    X_PFs = poses_in_parents(block.context_query())
    others = {*map(FrameId, block.frames.tolist()), *block.waiting}
    return {frame: X_PF for frame, X_PF in X_PFs.items() if frame not in others}
