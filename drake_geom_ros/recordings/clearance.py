"""``clearance``: a recording, one call."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path

from drake_geom_ros.recordings.opened import opened_recording
from drake_geom_ros.recordings.pair_sets import Between, pair_sets
from drake_geom_ros.recordings.results import Clearances
from drake_geom_ros.recordings.run import STALE_AFTER, Asked, Progress, Run
from drake_geom_ros.recordings.topics import Topics
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
    accuracy: str = 'exact',
    world_frame: str = 'world',
    package_roots: Sequence[str | Path] = (),
    threads: int = 0,
    certify: float = 0.0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Clearances:
    """Return the least distances over the time of a recording.

    ``path`` is a file (MCAP or sqlite3), a folder that rosbag2 wrote, or several of these;
    ``scene`` a scene file, or None for the robot whose description was recorded. ``between`` are
    sets of pairs such as ``'left:right'``, by names or patterns of sources, frames or geometries;
    without any, all pairs are the set ``'all'``. A state is taken with each message that poses
    something, or ``rate`` times a second [Hz]. ``topics`` says what was recorded where.
    ``stale_after`` [s], ``accuracy``, ``world_frame`` and ``package_roots`` are what a node has as
    parameters, ``threads`` and ``max_distance`` [m] what ``batch.evaluate`` has.

    With ``certify`` [m] the motion between states is proved, too: see ``SetClearance``. Its bounds
    are no farther than that below what was seen. It takes a state with each message: motions from
    one moment of a ``rate`` to the next would leave out what was recorded between them.

    ``executor`` computes distances in the place of threads, as of ``batch.cluster_executor``.
    ``progress`` is called with the states so far, and the seconds of the recording.

    Poses come to be as in a node that took the same messages at the times of recording. Poses do
    not stay in memory; an answer takes 113 bytes a state and set.

    Raises RecordingError for what cannot be read or used, SceneFileError for a scene file,
    ArgumentError for other arguments.

        over_time = clearance('run.mcap', 'cell.yaml', between=['left:right'])
        assert over_time.least().distance > 0.05
    """
    asked = Asked(
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
    run = Run(opened, asked, threads=threads, executor=executor, progress=progress)
    parts = list(run.parts())
    return Clearances.of(run.facts(), parts)
