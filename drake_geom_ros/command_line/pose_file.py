"""Pose files: poses of frames at one moment or at several, as CSV or JSON.

CSV has the header ``frame,x,y,z,qx,qy,qz,qw``, with ``time`` [s] before or after ``frame`` where
there are several moments; rows of one time stand together. JSON is an object
``{"frame": [x, y, z, qx, qy, qz, qw], ...}``, or a list whose items are such objects or
``{"time": t, "poses": {...}}``. Positions are in [m], poses are those of frames in their parents.
"""

import csv
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TextIO

from drake_geom_ros.command_line.standard_input import STANDARD_INPUT, bytes_of, is_json, name_of
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import Location, SceneFileError
from drake_geom_ros.scene_files.yaml_text import text_of

POSE_COLUMNS = ('x', 'y', 'z', 'qx', 'qy', 'qz', 'qw')
SUFFIXES = ('.csv', '.json')


@dataclass(frozen=True)
class FramePose:
    """The pose of a frame in its parent, and its place in the file."""

    frame: str
    X_PF: RigidTransform
    where: Location


@dataclass
class PoseSet:
    """Poses of frames at one moment; ``time`` [s] is None if the file has none."""

    time: float | None = None
    poses: list[FramePose] = field(default_factory=list)


def read_poses(path: str | Path) -> list[PoseSet]:
    """Return the moments of a pose file in its order.

    ``-`` is the standard input. Raises SceneFileError, naming file and line (CSV) or key (JSON),
    for another format, numbers that are no pose, and a frame that is posed twice at the same time.
    """
    path = str(path)
    file = name_of(path)
    if path != STANDARD_INPUT and Path(path).suffix not in SUFFIXES:
        raise SceneFileError(f'a pose file ends with one of {", ".join(SUFFIXES)}', file)
    try:
        text = text_of(bytes_of(path), file)
    except OSError as error:
        raise SceneFileError(f'cannot be read: {error.strerror}', file) from None
    sets = list((_from_json if is_json(path, text) else _from_csv)(text, file))
    if not sets:
        raise SceneFileError('there is no moment in it', file)
    for moment in sets:
        seen: dict[str, Location] = {}
        for pose in moment.poses:
            if pose.frame in seen:
                raise pose.where.error(f'frame {pose.frame!r} is posed twice at the same time')
            seen[pose.frame] = pose.where
    return sets


def write_poses(sets: Iterable[PoseSet], file: TextIO, suffix: str) -> None:
    """Write moments in the format of ``suffix``; ``read_poses`` reads back the same."""
    sets = list(sets)
    if suffix == '.csv':
        _to_csv(sets, file)
    else:
        items = [_plain(moment) for moment in sets]
        json.dump(items[0] if len(items) == 1 else items, file, indent=1)
        file.write('\n')


def _plain(moment: PoseSet) -> dict[str, Any]:
    poses = {pose.frame: pose.X_PF.ToArray().tolist() for pose in moment.poses}
    return poses if moment.time is None else {'time': moment.time, 'poses': poses}


def _to_csv(sets: list[PoseSet], file: TextIO) -> None:
    if len(sets) > 1 and any(moment.time is None for moment in sets):
        raise SceneFileError('several moments need a time each to be written as CSV', file.name)
    timed = any(moment.time is not None for moment in sets)
    writer = csv.writer(file, lineterminator='\n')
    writer.writerow([*(('time',) if timed else ()), 'frame', *POSE_COLUMNS])
    for moment in sets:
        for pose in moment.poses:
            start = [moment.time] if timed else []
            writer.writerow([*start, pose.frame, *pose.X_PF.ToArray().tolist()])


def _from_csv(text: str, file: str) -> Iterator[PoseSet]:
    reader = csv.DictReader(text.splitlines())
    columns = tuple(reader.fieldnames or ())
    if set(columns) - {'time'} != {'frame', *POSE_COLUMNS} or len(set(columns)) < len(columns):
        wanted = ','.join(('frame', *POSE_COLUMNS))
        raise SceneFileError(f'columns must be {wanted}, and optionally time', file, 1)
    current: PoseSet | None = None
    for row in reader:
        where = Location(file, reader.line_num)
        if None in row or None in row.values():
            raise where.error(f'a row has {len(columns)} values')
        time = _number(row['time'], where) if 'time' in columns else None
        if current is None or time != current.time:
            if current is not None:
                yield current
            current = PoseSet(time)
        numbers = [_number(row[column], where) for column in POSE_COLUMNS]
        current.poses.append(FramePose(row['frame'], _pose(numbers, where), where))
    if current is not None:
        yield current


def _from_json(text: str, file: str) -> Iterator[PoseSet]:
    try:
        value = json.loads(text, object_pairs_hook=partial(_each_once, file))
    except json.JSONDecodeError as error:
        raise SceneFileError(f'not JSON: {error.msg}', file, error.lineno) from None
    except RecursionError:
        raise SceneFileError('not a pose file: nested too deeply', file) from None
    for index, item in enumerate(value if isinstance(value, list) else [value]):
        key = f'[{index}]' if isinstance(value, list) else ''
        where = Location(file, key=key)
        if not isinstance(item, dict):
            raise where.error('an object {"frame": [x, y, z, qx, qy, qz, qw], ...} is wanted')
        if set(item) == {'time', 'poses'} and isinstance(item['poses'], dict):
            moment, poses = PoseSet(_number(item['time'], where)), item['poses']
        else:
            moment, poses = PoseSet(), item
        for frame, numbers in poses.items():
            place = Location(file, key=f'{key}.{frame}'.lstrip('.'))
            if not isinstance(numbers, list) or len(numbers) != len(POSE_COLUMNS):
                raise place.error(
                    f'a list of the {len(POSE_COLUMNS)} numbers of a pose is expected'
                )
            values = [_number(number, place) for number in numbers]
            moment.poses.append(FramePose(frame, _pose(values, place), place))
        yield moment


def _each_once(file: str, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object; raises SceneFileError for a duplicate key."""
    entries: dict[str, Any] = {}
    for key, value in pairs:
        if key in entries:
            raise SceneFileError('the key is there twice in one object', file, key=key)
        entries[key] = value
    return entries


def _number(value: Any, where: Location) -> float:
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise where.error(f'{str(value)[:80]!r} must be a finite number')
    return number


def _pose(numbers: list[float], where: Location) -> RigidTransform:
    try:
        return RigidTransform.FromArray(numbers)
    except RuntimeError as error:
        raise where.error(str(error)) from None
