"""Function ``clearance``: the minimum distances over a recording in one call."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path

from drake_geom_ros.geometry import AccuracyLike
from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.pair_sets import Between, pair_sets
from drake_geom_ros.recordings.recording_topics import Topics
from drake_geom_ros.recordings.results import Clearances
from drake_geom_ros.recordings.run import STALE_AFTER, Progress, Run, RunOptions
from drake_geom_ros.scene_files import SceneDescription


def clearance(
    path: str | Path | Sequence[str | Path],
    scene: str | Path | SceneDescription | None = None,
    *,
    between: Sequence[Between] = (),
    max_distance: float = math.inf,
    rate: float = 0.0,
    topics: Topics | None = None,
    stale_after: float = STALE_AFTER,
    accuracy: AccuracyLike = 'exact',
    world_frame: str = 'world',
    package_roots: Sequence[str | Path] = (),
    threads: int = 0,
    certify: float = 0.0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Clearances:
    """Return the minimum distances over the time of a recording.

    The poses are those of a node that received the same messages at the times of recording. They
    do not stay in memory; the result takes 113 bytes a state and set.

        over_time = clearance('run.mcap', 'cell.yaml', between=['left:right'])
        assert over_time.least().distance > 0.05

    Args:
        path: A file (MCAP or sqlite3), a folder that rosbag2 wrote, or several of these.
        scene: A scene file, or None for the robot whose description was recorded.
        between: Sets of pairs such as ``'left:right'``, by names or patterns of sources, frames
            or geometries; without any, all pairs are the set ``'all'``.
        max_distance: As of ``batch.evaluate`` [m].
        rate: States a second [Hz]; 0: one with each message that poses something.
        topics: The names of the recorded topics.
        stale_after: Parameter of a node [s].
        accuracy: A level or a length [m].
        world_frame: Parameter of a node.
        package_roots: Parameter of a node.
        threads: As of ``batch.evaluate``.
        certify: If > 0 [m], the motions between states are certified too, with bounds at most
            this far below the distances at states: see ``SetClearance``. It needs a state with
            each message, since a ``rate`` would skip the messages between its moments.
        executor: Computes distances instead of threads, for example ``batch.cluster_executor``.
        progress: Called with the number of states so far, and the seconds of the recording.

    Raises:
        RecordingError: The recording cannot be read or used.
        SceneFileError: The scene file is invalid.
        ArgumentError: Another argument is invalid.
    """
    options = RunOptions(
        sets=pair_sets(between),
        max_distance=max_distance,
        rate=rate,
        stale_after=stale_after,
        accuracy=accuracy,
        certify=certify,
    )
    opened = opened_recording(
        path,
        scene=scene,
        topics=topics,
        stale_after=stale_after,
        accuracy=accuracy,
        world_frame=world_frame,
        package_roots=package_roots,
    )
    run = Run(opened, options, threads=threads, executor=executor, progress=progress)
    parts = list(run.parts())
    return Clearances.of(run.facts(), parts)
