"""Files and folders of a recording."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import yaml

from drake_geom_ros.recordings.errors import RecordingError

SUFFIXES = ('.mcap', '.db3')
METADATA = 'metadata.yaml'
_COMPRESSED = '.zstd'  # a whole file that rosbag2 compressed


def places_of(paths: str | Path | Sequence[str | Path]) -> list[Path]:
    """Return the storage files of a recording in the order of their names.

    ``paths`` is a file, a folder that rosbag2 wrote, possibly without metadata, or several of
    these. A folder is returned itself if rosbag2 compressed whole files or each message. Raises
    RecordingError for a folder without a recording, or with several runs.
    """
    each_path = [paths] if isinstance(paths, (str, Path)) else list(paths)
    places = [place for path in each_path for place in _places(Path(path))]
    if not places:
        raise RecordingError('no recording was given')
    return list(dict.fromkeys(places))


def missing_files(paths: str | Path | Sequence[str | Path]) -> list[Path]:
    """Return the missing storage files that the metadata of folders name."""
    each_path = [paths] if isinstance(paths, (str, Path)) else list(paths)
    every = [Path(path) for path in each_path]
    folders = [path.parent if path.name == METADATA else path for path in every]
    return [
        folder / name
        for folder in dict.fromkeys(folders)
        for name in _named_files(folder)
        if not any((folder / each).exists() for each in (name, name.removesuffix(_COMPRESSED)))
    ]


def _places(path: Path) -> list[Path]:
    if not path.exists():
        raise RecordingError(f'{path}: there is no such file or folder')
    if path.is_dir():
        return _of_folder(path)
    if path.name == METADATA:
        return _of_folder(path.parent)
    if path.suffix == _COMPRESSED:
        raise RecordingError(f'{path} is compressed as a whole: give the folder that it is in')
    if path.suffix not in SUFFIXES:
        raise RecordingError(f'{path}: a recording is one of {", ".join(SUFFIXES)}, or a folder')
    _check_file(path)
    return [path]


def _check_file(path: Path) -> None:
    """Raise RecordingError for a pipe, a device or a socket, which may have no end."""
    if path.exists() and not path.is_file():
        raise RecordingError(f'{path} is no regular file: a recording is one, or a folder of some')


def _of_folder(folder: Path) -> list[Path]:
    inside = sorted(folder.iterdir(), key=_by_numbers)
    _check_file(folder / METADATA)
    for path in [each for each in inside if _holds([each]) and not each.is_dir()]:
        _check_file(path)
    for name in _paths_named(folder):
        _check_file(folder / name)
    if any(each.suffix == _COMPRESSED for each in inside) or _compresses_messages(folder):
        return [folder]
    if files := [each for each in inside if each.suffix in SUFFIXES and each.is_file()]:
        return files
    if runs := [run.name for run in runs_in(folder)]:
        raise RecordingError(
            f'{folder} holds {len(runs)} runs, and one is asked for: {", ".join(runs[:10])}'
        )
    raise RecordingError(f'{folder} holds no recording: no file {" or ".join(SUFFIXES)}')


def files_read(places: Iterable[Path]) -> list[Path]:
    """Return the files on which reading a recording's storage files and folders depends."""
    files: list[Path] = []
    for place in places:
        beside = place.with_name(f'{place.name}-wal'), place.with_name(METADATA)
        inside = sorted(place.iterdir()) if place.is_dir() else []
        files += [path for path in inside if path.name == METADATA or _holds([path])]
        files += [place, *beside]
    return [path for path in dict.fromkeys(files) if path.is_file()]


def runs_in(folder: Path) -> list[Path]:
    """Return the folders of runs in a folder that is no run itself, by name.

    Folders without a recording are included, since their runs were lost and must be reported;
    but the result is empty if no folder has one.
    """
    if not folder.is_dir() or _holds(folder.iterdir()):
        return []
    inside = sorted(folder.iterdir(), key=_by_numbers)
    folders = [each for each in inside if each.is_dir() and not each.name.startswith('.')]
    return folders if any(_holds(each.iterdir()) for each in folders) else []


def _compresses_messages(folder: Path) -> bool:
    """Return whether messages are compressed, which readers can learn only from the metadata."""
    return str(_metadata(folder).get('compression_mode')).lower() == 'message'


def _named_files(folder: Path) -> list[str]:
    """Return the names of the files that the metadata name, without folders."""
    return [Path(name).name for name in _paths_named(folder)]


def _paths_named(folder: Path) -> list[str]:
    """Return the paths of the files that the metadata name."""
    paths = _metadata(folder).get('relative_file_paths')
    return list(map(str, paths)) if isinstance(paths, list) else []


def _metadata(folder: Path) -> dict[str, Any]:
    if not (folder / METADATA).is_file():
        return {}
    try:
        text = (folder / METADATA).read_text(encoding='utf-8')
        information = yaml.safe_load(text)['rosbag2_bagfile_information']
        return information if isinstance(information, dict) else {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError):
        return {}  # metadata may be lost, or have the format of ROS 2 Dashing


def _holds(paths: Iterable[Path]) -> bool:
    return any(path.suffix in (*SUFFIXES, _COMPRESSED) for path in paths)


def _by_numbers(path: Path) -> list[tuple[int, str]]:
    """Return a sort key that places run_10 after run_9."""
    return [(int(part), '') if part.isdigit() else (-1, part) for part in _parts(path.name)]


def _parts(name: str) -> list[str]:
    return [part for part in re.split(r'(\d+)', name) if part]
