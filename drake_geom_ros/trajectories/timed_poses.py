"""Poses of free frames over time, from a table of timed poses."""

import csv
import io
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.math.batched import slerp
from drake_geom_ros.scene_files import SceneFileError
from drake_geom_ros.scene_files.yaml_text import text_of
from drake_geom_ros.trajectories.interpolation import MonotoneCubic
from drake_geom_ros.trajectories.pose_matrices import matrices_of_poses

COLUMNS = ('time', 'frame', 'x', 'y', 'z', 'qx', 'qy', 'qz', 'qw')


class TimedPoses:
    """The pose of one frame over time: a smooth position, and great arcs of orientation.

    The pose is constant before the first and after the last time.
    """

    def __init__(self, times: ArrayLike, poses: ArrayLike):
        """Make a curve through poses (k, 7), x y z [m] qx qy qz qw, at times (k,) [s].

        Raises ValueError for wrong shapes or times, RuntimeError for invalid poses.
        """
        poses = np.array(poses, dtype=float)
        if poses.ndim != 2 or poses.shape[1] != 7:
            raise ValueError(f'poses must have shape (k, 7), got {poses.shape}')
        matrices_of_poses(poses)
        poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
        # q and -q are the same orientation: choose the sign with the shorter way at each step.
        flips = np.where(np.sum(poses[1:, 3:] * poses[:-1, 3:], axis=1) < 0.0, -1.0, 1.0)
        poses[1:, 3:] *= np.cumprod(flips)[:, None]
        self._poses = poses
        self._position = MonotoneCubic(times, poses[:, :3]) if len(poses) > 1 else None

    @property
    def moves(self) -> bool:
        """True if there is more than one pose."""
        return self._position is not None

    @property
    def end(self) -> float:
        """The last time [s]; 0 for a single pose."""
        return 0.0 if self._position is None else float(self._position.times[-1])

    def poses(self, t: ArrayLike) -> NDArray[np.float64]:
        """Return the poses (..., 7) at times t (...) [s]."""
        if self._position is None:
            return np.broadcast_to(self._poses[0], (*np.shape(t), 7))
        segment, u = self._position.locate(t)
        q = self._poses[:, 3:]
        return np.concatenate(
            [self._position.value(t), slerp(q[segment], q[segment + 1], u)], axis=-1
        )

    def matrices(self, t: ArrayLike) -> NDArray[np.float64]:
        """Return the rigid transforms (..., 4, 4) at times t (...) [s]."""
        return matrices_of_poses(self.poses(t))


def read_timed_poses(path: str | Path) -> dict[str, TimedPoses]:
    """Return the frames of a CSV file with the columns ``time,frame,x,y,z,qx,qy,qz,qw``.

    Frames are named ``source::frame``; rows of one frame must be in the order of their times.
    Raises SceneFileError with file and line for invalid content.
    """
    rows: dict[str, list[list[float]]] = {}
    file = str(path)
    reader = csv.DictReader(io.StringIO(text_of(Path(path).read_bytes(), file), newline=''))
    if tuple(reader.fieldnames or ()) != COLUMNS:
        raise SceneFileError(f'columns must be {",".join(COLUMNS)}', file, 1)
    for row in reader:
        try:
            numbers = [float(row[c]) for c in COLUMNS if c != 'frame']
        except (TypeError, ValueError) as error:
            raise SceneFileError(str(error), file, reader.line_num) from None
        rows.setdefault(row['frame'], []).append(numbers)
    frames = {}
    for name, lines in rows.items():
        table = np.array(lines)
        try:
            frames[name] = TimedPoses(table[:, 0], table[:, 1:])
        except (ValueError, RuntimeError) as error:
            raise SceneFileError(f'frame {name!r}: {error}', file) from error
    return frames
