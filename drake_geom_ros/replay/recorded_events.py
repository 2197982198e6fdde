"""Recorded ProximityEvents messages, in the format of ``ros2 topic echo --full-length``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from drake_geom_ros.proximity_rules import Why
from drake_geom_ros.scene_files import SceneFileError
from drake_geom_ros.scene_files.yaml_text import text_of

_LOADER = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
_NUMBERS = ('distance', 'error_bound', 'closing_speed', 'limit_distance', 'limit_time')


@dataclass(frozen=True, eq=False)
class RecordedEvent:
    """One entry of a ProximityEvents message, with its fields.

    ``pose_a`` and ``pose_b`` (7,) are x y z [m] qx qy qz qw; NaN without a pair. ``points``
    (2, 3) [m] are p_WCa and p_WCb; None if the message lacks these fields.
    """

    scene_version: int
    accuracy: str
    sequence: int
    rule: str
    entered: bool
    why: Why
    geometry_a: str
    geometry_b: str
    distance: float  # [m]
    error_bound: float  # [m]
    pose_a: NDArray[np.float64]
    pose_b: NDArray[np.float64]
    closing_speed: float  # [m/s]
    limit_distance: float  # [m]
    limit_time: float  # [s]
    oldest_pose_age: float  # [s]
    points: NDArray[np.float64] | None = None

    @property
    def has_pair(self) -> bool:
        """True if the event has two geometries with their poses."""
        return bool(self.geometry_b) and bool(np.isfinite([*self.pose_a, *self.pose_b]).all())


def read_events(path: str | Path) -> list[RecordedEvent]:
    """Return the events of a file of YAML documents, each one message, in their order.

    Raises SceneFileError for another format, and OSError.
    """
    file = str(path)
    events: list[RecordedEvent] = []
    try:
        for number, message in enumerate(_documents(Path(path))):
            try:
                events += events_of(message)
            except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
                what = f'document {number + 1} is no ProximityEvents message'
                raise SceneFileError(f'{what}: {type(error).__name__}: {error}', file) from None
    except (yaml.YAMLError, RecursionError) as error:
        raise SceneFileError(f'not YAML: {error}', file) from None
    if not events:
        raise SceneFileError('there is no event in it', file)
    return events


def _documents(path: Path) -> Iterator[Any]:
    for document in yaml.load_all(text_of(path.read_bytes(), str(path)), Loader=_LOADER):
        if document is not None:  # echo ends its output with a separator
            yield document


def events_of(message: Mapping[str, Any]) -> Iterator[RecordedEvent]:
    """Yield the entries of a ProximityEvents message, passed as a mapping of its fields."""
    for k, sequence in enumerate(message['sequence']):
        pose_a, pose_b = (
            np.array(message[field][7 * k : 7 * k + 7], dtype=np.float64).reshape(7)
            for field in ('pose_a', 'pose_b')
        )
        yield RecordedEvent(
            scene_version=int(message['scene_version']),
            accuracy=str(message['accuracy']),
            sequence=int(sequence),
            rule=str(message['rule'][k]),
            entered=bool(message['entered'][k]),
            why=Why(int(message['why'][k])),
            geometry_a=str(message['geometry_a'][k]),
            geometry_b=str(message['geometry_b'][k]),
            pose_a=pose_a,
            pose_b=pose_b,
            oldest_pose_age=float(message['oldest_pose_age'][k]),
            points=_points(message, k),
            **{field: float(message[field][k]) for field in _NUMBERS},
        )


def _points(message: Mapping[str, Any], k: int) -> NDArray[np.float64] | None:
    if not {'p_wca', 'p_wcb'} <= message.keys():
        return None
    both = [message[field][3 * k : 3 * k + 3] for field in ('p_wca', 'p_wcb')]
    return np.array(both, dtype=np.float64).reshape(2, 3)
