"""Poses of a recording over time, for display."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.frame_names import Frame
from drake_geom_ros.geometry import FrameId
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.player import Player
from drake_geom_ros.recordings.raw_messages import NANOSECONDS
from drake_geom_ros.recordings.recorded_maps import maps_remark
from drake_geom_ros.recordings.recording_topics import Topics
from drake_geom_ros.recordings.states import Block, StateBlocks
from drake_geom_ros.scene_files import SceneDescription, poses_in_parents


class PosesAtTime(NamedTuple):
    """Poses of all frames that have one, valid from a time until the next."""

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
    warn: Callable[[str], None] | None = None,
) -> list[PosesAtTime]:
    """Return the poses of a recording at ``rate`` [Hz]; raises the errors of ``clearance``.

    ``warn`` is called with texts on unknown, refused and unreadable parts.
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
    timed_poses = []
    for block in player.blocks():
        still = _still(block)
        inspector = block.context_query().inspector()
        ids = [*(FrameId(value) for value in block.frames.tolist()), *still]
        names = tuple((inspector.GetOwningSourceName(f), inspector.GetName(f)) for f in ids)
        rest = np.array([X_PF.ToArray() for X_PF in still.values()]).reshape(-1, 7)
        for stamp, rows in zip(block.times.tolist(), block.poses, strict=True):
            time = (stamp - player.begin) / NANOSECONDS
            timed_poses.append(PosesAtTime(time, names, np.vstack((rows, rest))))
    if warn is not None:
        warnings = [each.in_words(player.begin) for each in opened.recording.damage]
        warnings += [each.words for each in opened.playback.troubles]
        warnings += opened.playback.differences()
        for words in [*warnings, *filter(None, [maps_remark(opened.maps)])]:
            warn(words)
    return timed_poses


def _still(block: Block) -> dict[FrameId, RigidTransform]:
    """Return X_PF of the posed frames that are not among the moving frames of a block."""
    X_PFs = poses_in_parents(block.context_query())
    others = {*map(FrameId, block.frames.tolist()), *block.waiting}
    return {frame: X_PF for frame, X_PF in X_PFs.items() if frame not in others}
