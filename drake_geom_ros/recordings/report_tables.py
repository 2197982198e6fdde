"""Distances over time as files: ``clearance.csv`` for reading, ``clearance.npz`` for computing."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping
from io import StringIO
from itertools import repeat
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.whole_files import whole_file
from drake_geom_ros.recordings.audit import Audit
from drake_geom_ros.recordings.results import RunAnalysis, StateMinima
from drake_geom_ros.recordings.set_clearance import COLUMNS as SET_COLUMNS
from drake_geom_ros.recordings.set_clearance import MOTION_COLUMNS, SetClearance

COLUMNS = (
    *('time_s', 'stamp_ns', 'set', 'state', 'distance_m', 'error_bound_m', 'known_distance_m'),
    *('geometry_a', 'geometry_b', 'ax_m', 'ay_m', 'az_m', 'bx_m', 'by_m', 'bz_m'),
    *('oldest_pose_s', 'pairs_left_out'),
)
CERTIFIED_COLUMNS = 'motion_before', 'certified_bound_m'
_COMPUTED = 'distance', 'error_bound'  # derived from stored columns
_MOTIONS = 'unknown', 'clear', 'contact'
_ROWS = 10_000  # written at once, to bound memory


def write_csv(run: RunAnalysis, path: Path) -> None:
    """Write a row for each state and set of pairs; ``distance_m`` is nan in incomplete states.

    ``state`` is ``whole``, ``stale``, ``waiting`` or ``waiting, stale``.
    """
    with whole_file(path, newline='') as file:
        heads = (*COLUMNS, *(CERTIFIED_COLUMNS if run.is_certified else ()))
        csv.writer(file, lineterminator='\n').writerow(heads)
        for name in run.moments:
            for part in run.parts():
                for first in range(0, len(part.times), _ROWS):
                    rows = _columns(part, name, slice(first, first + _ROWS))
                    file.writelines(','.join(row) + '\n' for row in zip(*rows, strict=True))


def _columns(states: StateMinima, name: str, part: slice) -> Iterator[Iterable[str]]:
    """Yield the columns of some rows as texts."""
    pairs = states.sets[name].some(part)
    words = [_cell(text) for text in states_in_words(pairs)]
    names = [*(_cell(name) for name in pairs.names), '']  # -1, the last one, for none
    yield _numbers(pairs.times)
    yield _numbers(states.stamps[part])
    yield repeat(_cell(name), len(words))
    yield words
    yield _numbers(pairs.distance)
    yield _numbers(pairs.error_bound)
    yield _numbers(pairs.known_distance)
    for places in (pairs.geometry_A, pairs.geometry_B):
        yield [names[place] for place in places.tolist()]
    for points in (pairs.p_WCa, pairs.p_WCb):
        for axis in range(3):
            yield _numbers(points[:, axis])
    yield _numbers(pairs.age.astype(np.float64))
    yield _numbers(pairs.left_out)
    if pairs.motion is not None and pairs.motion_bound is not None:
        yield [_MOTIONS[code] for code in pairs.motion.tolist()]
        yield _numbers(pairs.motion_bound)


def _numbers(values: NDArray[Any]) -> Iterator[str]:
    return map(repr, values.tolist())


def _cell(text: str) -> str:
    """Return a text as a cell of CSV."""
    cell = StringIO()
    csv.writer(cell, lineterminator='').writerow([text])
    return cell.getvalue()


def states_in_words(pairs: SetClearance) -> list[str]:
    """Return a word for each state: whole, or the reason why it is incomplete."""
    flags = zip(pairs.is_waiting.tolist(), pairs.is_stale.tolist(), strict=True)
    words = {
        (False, False): 'whole',
        (False, True): 'stale',
        (True, False): 'waiting',
        (True, True): 'waiting, stale',
    }
    return [words[pair] for pair in flags]


def write_audit(audited: Audit, path: Path) -> None:
    """Write a row for each audited result and event."""
    with whole_file(path, newline='') as file:
        rows = csv.writer(file, lineterminator='\n')
        rows.writerow(('time_s', 'topic', 'what', 'outcome', 'because'))
        for entry in audited.entries:
            rows.writerow((repr(entry.time), *entry[1:3], entry.outcome.value, entry.because))


def write_npz(run: RunAnalysis, path: Path) -> None:
    """Write ``times`` (N,), ``stamps`` (N,) [ns], ``sets`` (k,), ``gaps`` (g, 2) [s], and columns.

    Columns of set k are ``distance_k``, ``error_bound_k`` and the other fields of
    ``SetClearance``. Arrays are written part by part.
    """
    with whole_file(path, 'wb') as file, ZipFile(file, 'w', ZIP_DEFLATED) as archive:

        def put(name: str, parts: Iterable[NDArray[Any]], count: int) -> None:
            _put_array(archive, name, parts, count)

        gaps = np.array(run.gaps, dtype=np.float64).reshape(-1, 2)
        put('times', (part.times for part in run.parts()), run.count)
        put('stamps', (part.stamps for part in run.parts()), run.count)
        put('sets', [np.array(list(run.moments))], len(run.moments))
        put('gaps', [gaps], len(gaps))
        columns = (*_COMPUTED, *SET_COLUMNS, *(MOTION_COLUMNS if run.is_certified else ()))
        for k, name in enumerate(run.moments):
            names = dict.fromkeys(n for part in run.parts() for n in part.sets[name].names)
            places = {each: place for place, each in enumerate(names)}
            for column in columns:
                put(f'{column}_{k}', _column(run, name, column, places), run.count)
            put(f'names_{k}', [np.array(list(names), dtype=np.str_)], len(names))


def _column(
    run: RunAnalysis, name: str, column: str, places: Mapping[str, int]
) -> Iterator[NDArray[Any]]:
    """Yield a column of a set part by part; geometries become indices into all names."""
    for part in run.parts():
        pairs = part.sets[name]
        values = getattr(pairs, column)
        if column.startswith('geometry_'):
            yield np.array([*(places[each] for each in pairs.names), -1], dtype=np.int32)[values]
        else:
            yield values


def _put_array(archive: ZipFile, name: str, parts: Iterable[NDArray[Any]], count: int) -> None:
    """Write an array of ``count`` rows in NumPy's format, part by part."""
    with archive.open(f'{name}.npy', 'w', force_zip64=True) as file:
        head: dict[str, Any] = {}
        for part in parts:
            if not head:
                descr = np.lib.format.dtype_to_descr(part.dtype)
                head = {'descr': descr, 'fortran_order': False, 'shape': (count, *part.shape[1:])}
                np.lib.format.write_array_header_2_0(file, head)
            file.write(np.ascontiguousarray(part).tobytes())
