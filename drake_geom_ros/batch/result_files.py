"""Files of results, .npz or Parquet, written block by block with constant memory.

Geometries are written as indices into ``geometries``, the names of all of them, or -1 for a state
without a pair; in Parquet as names. ``scene``, ``question`` and ``versions`` document the origin
of the answers, ``columns`` the meaning of each column. The states are written with their answers,
with the names of joints or frames as in a file of states, so that results can be computed again.
Texts in .npz are metadata in Parquet, lists of names as JSON.
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
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from drake_geom_ros.batch.questions import Columns
from drake_geom_ros.batch.running import BatchError
from drake_geom_ros.common.whole_files import whole_file
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface

SUFFIXES = ('.npz', '.parquet')
_ABOUT = ('scene', 'question', 'versions')
_STATES = ('states', 'poses')
_MEANINGS = {
    'states': 'joint values [rad] or [m], by `joints`',
    'poses': 'X_PF, x y z [m] qx qy qz qw, by `frames`; in Parquet one frame after the other',
    'state': 'the number of the state that a row is of',
    'offsets': 'answers of state s are rows offsets[s] to offsets[s + 1]',
    'collision': 'whether a pair overlaps or, with max_distance, is not certified to be beyond it',
    'distance': 'signed distance [m]; infinity: every pair is certified to be out of reach',
    'error_bound': 'the true distance is within distance +- error_bound [m]',
    'geometry_a': 'the first geometry: its place in `geometries`, -1: none; in Parquet its name',
    'geometry_b': 'the second geometry, likewise',
    'geometry': 'the geometry, likewise',
    'method': 'what computed it: 1 closed form, 2 iterative, 3 mesh, 4 bounds only',
    'nhat_BA_W': 'unit normal out of B into A, in World',
    'is_nhat_BA_W_unique': 'whether it is the only one',
    'p_WCa': 'witness point on A [m], in World',
    'p_WCb': 'witness point on B [m], in World',
    'gradient': 'derivative of the distance by the spatial velocities, angular before linear, of '
    'the frames of A (6) and B (6) in World; `geometry_frames` has their names',
    'joint_gradient': 'derivative of the distance by the joint values, by `joints`',
    'area': 'of the contact surface [m^2]; NaN: the pair overlaps and has none',
    'centroid': 'of the surface [m], in World; NaN: none',
    'centre_of_pressure': 'mean position weighted by pressure [m], in World; NaN: none',
    'force_on_A_W': 'of the pressure on A [N], in World; on B the opposite; NaN: unknown',
    'torque_on_A_Wo_W': 'of the pressure on A about the origin of World [N m]; NaN: unknown',
    'max_pressure': 'the largest of the surface [Pa]; NaN: none',
    'depth': 'how deep a pair without a surface overlaps [m]; NaN: it has one',
    'reason': 'why there is no surface: 0 there is one, '
    + ', '.join(f'{each.value} {each.name.lower().replace("_", " ")}' for each in NoSurface),
    'point_index': 'which point',
    'grad_W': 'gradient of the distance by the point, in World',
    'is_grad_W_unique': 'whether it is the only one',
    'p_GN': 'nearest point of the surface [m], in the frame of the geometry',
}
_PLACES = {'id_A': 'geometry_a', 'id_B': 'geometry_b', 'id_G': 'geometry'}


def check_suffix(path: Path) -> None:
    """Raise BatchError for a suffix of no format, or of one that is not installed."""
    if path.suffix not in SUFFIXES:
        raise BatchError(f'{path}: results are written as one of {", ".join(SUFFIXES)}')
    if path.suffix == '.parquet':
        _parquet()


def check_place(path: Path) -> None:
    """Raise BatchError if the path exists and has no results, which may be replaced."""
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
        metadata = _parquet().parquet.read_schema(path).metadata or {}
        return {key.encode() for key in _ABOUT} <= set(metadata)
    except (OSError, ValueError, zipfile.BadZipFile):  # pyarrow's errors are ValueErrors, too
        return False


class About(NamedTuple):
    """Metadata of a file of results."""

    texts: Mapping[str, str]
    geometries: Sequence[str]  # the names of all
    lists: Mapping[str, Sequence[str]]  # further names

    @classmethod
    def of(
        cls,
        texts: tuple[str, str, Mapping[str, str]],
        geometries: Sequence[str],
        lists: Mapping[str, Sequence[str]],
    ) -> About:
        """Return the metadata for a scene, a question, and versions."""
        scene, question, versions = texts
        said = {'scene': scene, 'question': question, 'versions': json.dumps(dict(versions))}
        return cls(said, geometries, lists)


def write(path: Path, blocks: Iterable[Columns], about: About) -> None:
    """Write blocks of columns, in order and each read once, to a file.

    The file appears only when it is complete.
    """
    with whole_file(path, 'wb') as file:
        if path.suffix == '.npz':
            # Temporary files go to the same disk, since that has space for the results.
            _write_npz(file, blocks, about, path.parent)
        else:
            _write_parquet(file, blocks, about)


def _meanings(columns: Iterable[str]) -> str:
    """Return the meanings of columns as JSON."""
    named = [_PLACES.get(name, 'offsets' if name == 'counts' else name) for name in columns]
    return json.dumps({name: _MEANINGS[name] for name in named})


class _Column:
    """Collects the blocks of one array of an .npz file, which must be written in one piece."""

    def __init__(self, first: NDArray[Any], file: IO[bytes]) -> None:
        """Begin with the type and width of a ``first`` block; ``file`` buffers the blocks."""
        self._header = npy.header_data_from_array_1_0(first)
        self._shape = first.shape[1:]
        self._rows = 0
        self._file = file

    def add(self, values: NDArray[Any]) -> None:
        self._rows += len(values)
        self._file.write(np.ascontiguousarray(values).tobytes())

    def move_to(self, file: zipfile.ZipFile, name: str) -> None:
        """Write the whole array, and release the buffer."""
        with self._file, file.open(f'{name}.npy', 'w', force_zip64=True) as stream:
            shape = (self._rows, *self._shape)
            npy.write_array_header_2_0(stream, {**self._header, 'shape': shape})
            self._file.seek(0)
            shutil.copyfileobj(self._file, stream)


def _write_npz(target: IO[bytes], blocks: Iterable[Columns], about: About, folder: Path) -> None:
    columns: dict[str, _Column] = {}
    end = np.zeros(1, dtype=np.int64)  # number of rows so far: the first row of the next state
    with ExitStack() as opened, zipfile.ZipFile(target, 'w') as file:

        def add(name: str, values: NDArray[Any]) -> None:
            if name not in columns:
                columns[name] = _Column(values, opened.enter_context(TemporaryFile(dir=folder)))
            columns[name].add(values)

        for key, names in {'geometries': about.geometries, **about.lists}.items():
            add(key, np.array(names, dtype=np.str_))
        for key, text in about.texts.items():
            add(key, np.array([text]))
        names_seen: dict[str, None] = {}
        for block in blocks:
            names_seen |= dict.fromkeys(block)
            for name, values in block.items():
                if name != 'counts':
                    add(_PLACES.get(name, name), values)
                    continue
                if 'offsets' not in columns:
                    add('offsets', end)
                ends = end + np.cumsum(values, dtype=np.int64)
                add('offsets', ends)
                end = ends[-1:] if len(ends) else end
        add('columns', np.array([_meanings(names_seen)]))
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


def _write_parquet(target: IO[bytes], blocks: Iterable[Columns], about: About) -> None:
    pyarrow, writer, first = _parquet(), None, 0
    lists = {key: json.dumps(list(names)) for key, names in about.lists.items()}
    try:
        for block in blocks:
            states = len(next(iter(block.values())))
            rows = np.arange(first, first + states)
            if 'counts' in block:
                rows = np.repeat(rows, block.pop('counts'))
            for name in _STATES:
                if name in block:
                    block[name] = block[name].reshape(states, -1)[rows - first]
            first += states
            columns = {'state': pyarrow.array(rows)}
            for name, values in block.items():
                columns[_PLACES.get(name, name)] = _column(pyarrow, name, values, about.geometries)
            said = {**about.texts, **lists, 'columns': _meanings(['state', *block])}
            table = pyarrow.table(columns).replace_schema_metadata(said)
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
