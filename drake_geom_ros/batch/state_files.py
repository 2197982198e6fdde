"""Readers of states from files: joint values or poses, as .npy, .npz or .csv."""

from __future__ import annotations

import contextlib
import csv
import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.file_rows import FileRows
from drake_geom_ros.scene_files import SceneFileError

_SHOWN = 60  # characters of a value in messages
SUFFIXES = ('.npy', '.npz', '.csv')


class StateRows(NamedTuple):
    """Rows (N, q) of joint values or (N, n, 7) of poses, and their names.

    Names are of joints, ``robot::joint``, or of frames, ``source::frame``. They are None if the
    file has none, which means all joints of the scene.
    """

    rows: NDArray[np.float64] | FileRows
    names: tuple[str, ...] | None

    @property
    def are_poses(self) -> bool:
        """True if the rows are poses of frames."""
        return self.rows.ndim == 3

    @property
    def digest(self) -> str:
        """The hash of the rows that were read; a file may change afterwards."""
        if isinstance(self.rows, FileRows):
            return self.rows.digest
        rows = np.ascontiguousarray(self.rows)
        return hashlib.sha256(repr(rows.shape).encode() + rows.tobytes()).hexdigest()


def read_states(path: str | Path, names: Sequence[str] | None = None) -> StateRows:
    """Return the states of a file; ``names`` are used if it has none.

    ``.npy`` has only the rows, which are read block by block, with constant memory. ``.npz`` has
    ``states`` and optionally ``joints``, their names; or ``poses`` and ``frames``. ``.csv`` has a
    header with the names of joints. Raises SceneFileError for another form, and for a file that
    changes while it is read; for ``.npy`` also later, for a changed block.
    """
    path, own = Path(path), None if names is None else tuple(names)
    if path.suffix not in SUFFIXES:
        raise SceneFileError(f'a file of states ends with one of {", ".join(SUFFIXES)}', str(path))
    try:
        if path.suffix == '.npy':
            rows: Any = FileRows.of(path)
            if rows is None:  # of another order, or of a type that is refused below
                with _unchanged(path):
                    rows = np.load(path)
        elif path.suffix == '.npz':
            with _unchanged(path):
                rows, own = _from_npz(path, own)
        else:
            with _unchanged(path):
                rows, own = _from_csv(path)
    except SceneFileError:
        raise
    except OSError as error:
        if error.strerror is None:  # NumPy's about what is no array
            raise SceneFileError(f'cannot be read as states: {error}', str(path)) from None
        raise SceneFileError(f'cannot be read: {error.strerror}', str(path)) from None
    except Exception as error:
        # There are many kinds: errors of zip files, their compression, arrays and tables.
        reason = ' '.join(str(error).split()) or repr(error)
        raise SceneFileError(f'cannot be read as states: {reason}', str(path)) from None
    is_poses = rows.ndim == 3 and rows.shape[2] == 7
    if rows.dtype != np.float64 or not (rows.ndim == 2 or is_poses):
        raise SceneFileError(
            'states must be float64, joint values (N, q) or poses (N, n, 7); there are '
            f'{rows.dtype} {rows.shape}',
            str(path),
        )
    if own is None and is_poses:
        raise SceneFileError('poses need the names of their frames: --names', str(path))
    if own is not None and len(own) != rows.shape[1]:
        raise SceneFileError(f'{len(own)} names for {rows.shape[1]} columns', str(path))
    return StateRows(rows, own)


@contextlib.contextmanager
def _unchanged(path: Path) -> Iterator[None]:
    """Raise ValueError if a file was written to during the block."""
    before = path.stat()
    yield
    after = path.stat()
    if any(
        getattr(before, name) != getattr(after, name)
        for name in ('st_dev', 'st_ino', 'st_size', 'st_mtime_ns', 'st_ctime_ns')
    ):
        raise ValueError('the file was written to while it was read')


def _from_npz(path: Path, names: tuple[str, ...] | None) -> tuple[Any, tuple[str, ...] | None]:
    with np.load(path) as file:
        rows, key = (file['poses'], 'frames') if 'poses' in file else (file['states'], 'joints')
        if key not in file:
            return rows, names
        own = file[key]
        if own.ndim != 1 or own.dtype.kind != 'U':
            raise ValueError(f'{key!r} must be a list of names; it is {own.dtype} {own.shape}')
        return rows, tuple(own.tolist())


def _from_csv(path: Path) -> tuple[Any, tuple[str, ...]]:
    with path.open(newline='', encoding='utf-8-sig') as file:
        lines = list(csv.reader(file))
    while lines and not any(map(str.strip, lines[-1])):  # blank lines at the end
        lines.pop()
    if not lines:
        raise ValueError('it is empty; a header with the names of joints is needed')
    names = tuple(map(str.strip, lines[0]))
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        if len(line) != len(names):
            raise ValueError(f'row {number} has {len(line)} values, the header {len(names)}')
        try:
            rows.append([float(value) for value in line])
        except ValueError:
            bad = next(value for value in line if not _is_number(value))
            raise ValueError(f'row {number}: {bad[:_SHOWN]!r} is no number') from None
    return np.array(rows, dtype=np.float64).reshape(-1, len(names)), names


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
