"""The poses of a recording over time, to be looked at."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.frame_names import Frame
from drake_geom_ros.geometry import FrameId
from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.player import Player
from drake_geom_ros.recordings.states import StateBlocks
from drake_geom_ros.recordings.storages import NANOSECONDS
from drake_geom_ros.recordings.topics import Topics
from drake_geom_ros.scene_files import SceneDescription


class TimedPoses(NamedTuple):
    """Poses that hold from a time on until the next: of the frames that were posed by then."""

    time: float  # [s] since the recording began
    frames: tuple[Frame, ...]  # by source and name
    rows: NDArray[np.float64]  # (n, 7) X_PF


def recorded_poses(
    path: str | Path | Sequence[str | Path],
    scene: str | Path | SceneDescription,
    rate: float,
    topics: Topics | None = None,
    package_roots: Sequence[str | Path] = (),
) -> list[TimedPoses]:
    """Return the poses of a recording, so often a second [Hz]; raises as ``clearance``."""
    opened = opened_recording(path, scene, topics, 1.0, 'exact', 'world', package_roots)
    player = Player(opened, StateBlocks(opened.playback, ()), rate)
    found = []
    for block in player.blocks():
        inspector = block.context_query().inspector()
        ids = [FrameId(value) for value in block.frames.tolist()]
        names = tuple((inspector.GetOwningSourceName(f), inspector.GetName(f)) for f in ids)
        for stamp, rows in zip(block.times.tolist(), block.poses, strict=True):
            found.append(TimedPoses((stamp - player.begin) / NANOSECONDS, names, rows))
    return found
