"""Results to files, .npz or Parquet, block by block: memory stays flat however many states.

Geometries are written as their place in ``geometries``, the names of all of them, or -1 where a
state has no pair; in Parquet as the names themselves. ``scene``, ``question`` and ``versions`` say
where the answers come from.
"""

from __future__ import annotations

import json
import os
import shutil
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from drake_geom_ros.batch.questions import Columns
from drake_geom_ros.batch.running import BatchError
from drake_geom_ros.common.whole_files import whole_file

SUFFIXES = ('.npz', '.parquet')
_ABOUT = ('scene', 'question', 'versions')
_PLACES = {'id_A': 'geometry_a', 'id_B': 'geometry_b', 'id_G': 'geometry'}


def check_suffix(path: Path) -> None:
    """Raise BatchError for a name that no format belongs to, or one that is not installed."""
    if path.suffix not in SUFFIXES:
        raise BatchError(f'{path}: results are written as one of {", ".join(SUFFIXES)}')
    if path.suffix == '.parquet':
        _parquet()


def check_place(path: Path) -> None:
    """Raise BatchError where something is that is not to be replaced: anything but results."""
    if not os.path.lexists(path):
        return
    if not path.is_file() or not _holds_results(path):
        raise BatchError(
            f'{path} is there, and not as results of a batch: it stays as it is. Give another '
            'name, or remove it'
        )


def _holds_results(path: Path) -> bool:
    try:
        if path.suffix == '.npz':
            with zipfile.ZipFile(path) as file:
                return {f'{key}.npy' for key in _ABOUT} <= set(file.namelist())
        told = _parquet().parquet.read_schema(path).metadata or {}
        return {key.encode() for key in _ABOUT} <= set(told)
    except (OSError, ValueError, zipfile.BadZipFile):  # pyarrow's errors are ValueErrors, too
        return False


def write(
    path: Path, blocks: Iterable[Columns], names: Sequence[str], about: Mapping[str, str]
) -> None:
    """Write blocks of columns, in order and each taken once, to a file.

    It is there only when it is whole.
    """
    with whole_file(path, 'wb') as file:
        if path.suffix == '.npz':
            # Where there is room for the results there is for what is kept of them.
            _write_npz(file, blocks, names, about, path.parent)
        else:
            _write_parquet(file, blocks, names, about)


class _Column:
    """One array of an .npz file, which has to be written in one piece, as its blocks come."""

    def __init__(self, first: NDArray[Any], file: IO[bytes]) -> None:
        """``file`` keeps what has come."""
        self._header = npy.header_data_from_array_1_0(first)
        self._shape = first.shape[1:]
        self._rows = 0
        self._file = file

    def add(self, values: NDArray[Any]) -> None:
        self._rows += len(values)
        self._file.write(np.ascontiguousarray(values).tobytes())

    def move_to(self, file: zipfile.ZipFile, name: str) -> None:
        """Write the whole array, and let go of what was kept of it."""
        with self._file, file.open(f'{name}.npy', 'w', force_zip64=True) as stream:
            shape = (self._rows, *self._shape)
            npy.write_array_header_2_0(stream, {**self._header, 'shape': shape})
            self._file.seek(0)
            shutil.copyfileobj(self._file, stream)


def _write_npz(
    target: IO[bytes],
    blocks: Iterable[Columns],
    names: Sequence[str],
    about: Mapping[str, str],
    folder: Path,
) -> None:
    columns: dict[str, _Column] = {}
    end = np.zeros(1, dtype=np.int64)  # of the rows until now: where the next state's begin
    with ExitStack() as opened, zipfile.ZipFile(target, 'w') as file:

        def add(name: str, values: NDArray[Any]) -> None:
            if name not in columns:
                columns[name] = _Column(values, opened.enter_context(TemporaryFile(dir=folder)))
            columns[name].add(values)

        add('geometries', np.array(names))
        for key, text in about.items():
            add(key, np.array([text]))
        for block in blocks:
            for name, values in block.items():
                if name != 'counts':
                    add(_PLACES.get(name, name), values)
                    continue
                if 'offsets' not in columns:
                    add('offsets', end)
                ends = end + np.cumsum(values, dtype=np.int64)
                add('offsets', ends)
                end = ends[-1:] if len(ends) else end
        for name, column in columns.items():
            column.move_to(file, name)


def _parquet() -> Any:
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise BatchError(
            f'Parquet takes pyarrow, which cannot be imported ({error}): pip install pyarrow, or '
            "this package with its extra 'parquet'"
        ) from None
    return pyarrow


def _write_parquet(
    target: IO[bytes],
    blocks: Iterable[Columns],
    names: Sequence[str],
    about: Mapping[str, str],
) -> None:
    pyarrow, writer, first = _parquet(), None, 0
    try:
        for block in blocks:
            states = len(next(iter(block.values())))
            rows = np.arange(first, first + states)
            if 'counts' in block:
                rows = np.repeat(rows, block.pop('counts'))
            first += states
            columns = {'state': pyarrow.array(rows)}
            for name, values in block.items():
                columns[_PLACES.get(name, name)] = _column(pyarrow, name, values, names)
            table = pyarrow.table(columns).replace_schema_metadata(dict(about))
            writer = writer or pyarrow.parquet.ParquetWriter(target, table.schema)
            writer.write_table(table)
    finally:
        if writer is not None:
            writer.close()


def _column(pyarrow: Any, name: str, values: NDArray[Any], names: Sequence[str]) -> Any:
    if name in _PLACES:
        places = pyarrow.array(values.astype(np.int32), mask=values < 0)
        return pyarrow.DictionaryArray.from_arrays(places, pyarrow.array(list(names)))
    if values.ndim == 2:
        flat = pyarrow.array(np.ascontiguousarray(values).reshape(-1))
        return pyarrow.FixedSizeListArray.from_arrays(flat, values.shape[1])
    return pyarrow.array(values)


def about(scene: str, question: str, versions: Mapping[str, str]) -> dict[str, str]:
    """Return what a file says of its answers."""
    return {'scene': scene, 'question': question, 'versions': json.dumps(dict(versions))}
