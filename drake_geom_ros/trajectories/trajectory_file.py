"""Trajectory files: a ``trajectory_msgs/JointTrajectory`` as YAML.

::

    joint_names: [left::panda_joint1, left::panda_joint2]
    points:
    - {time_from_start: 0.0, positions: [0.0, -0.3], velocities: [0.0, 0.0]}
    - {time_from_start: {sec: 2, nanosec: 0}, positions: [0.5, 0.1], velocities: [0.0, 0.0]}

So what ``ros2 topic echo --full-length`` prints of one message is such a file.
``trajectory.schema.json`` is the complete schema.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files.errors import SceneFileError, unreadable
from drake_geom_ros.scene_files.schema import check_schema, read_schema
from drake_geom_ros.scene_files.yaml_text import Document, read_yaml, text_of
from drake_geom_ros.trajectories.joint_spline import JointTrajectory


class NamedTrajectory(NamedTuple):
    """A trajectory, and the joints of its columns."""

    joint_names: tuple[str, ...]
    trajectory: JointTrajectory


def read_trajectory(path: str | Path) -> NamedTrajectory:
    """Return the trajectory of a file.

    Raises SceneFileError, with file, line and key, for a file of another form.
    """
    try:
        document = read_yaml(text_of(Path(path).read_bytes(), str(path)), str(path))
    except OSError as error:
        raise unreadable(str(path), error) from error
    except ValueError as error:
        raise SceneFileError(str(error), str(path)) from error
    check_schema(document, read_schema('drake_geom_ros.trajectories', 'trajectory.schema.json'))
    names, points = document.value['joint_names'], document.value['points']
    trajectory = JointTrajectory(
        times=np.array([_seconds(point['time_from_start']) for point in points]),
        positions=_rows(document, 'positions', len(names)),
        velocities=_rows(document, 'velocities', len(names)),
        accelerations=_rows(document, 'accelerations', len(names)),
    )
    return NamedTrajectory(tuple(names), trajectory)


def _seconds(time: Any) -> float:
    if isinstance(time, dict):
        return float(time['sec'] + time.get('nanosec', 0) / 1_000_000_000)
    return float(time)


def _rows(document: Document, name: str, count: int) -> Floats:
    """Return numbers of all points (k, count), NaN where a point has none of them."""
    points = document.value['points']
    rows = np.full((len(points), count), np.nan)
    for k, point in enumerate(points):
        numbers = point.get(name) or []
        if numbers and len(numbers) != count:
            raise document.at('points', k, name).error(
                f'it has {len(numbers)} numbers for {count} joints'
            )
        if numbers:
            rows[k] = numbers
        elif name == 'positions':
            raise document.at('points', k).error('it has no positions')
    return rows
