"""Distances over time as files: ``clearance.csv`` to be read, ``clearance.npz`` to be computed."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from io import StringIO
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.common.whole_files import whole_file
from drake_geom_ros.recordings.audit import Audit
from drake_geom_ros.recordings.results import Clearances, SetClearance

COLUMNS = (
    *('time_s', 'stamp_ns', 'set', 'state', 'distance_m', 'error_bound_m', 'known_distance_m'),
    *('geometry_a', 'geometry_b', 'ax_m', 'ay_m', 'az_m', 'bx_m', 'by_m', 'bz_m'),
    *('oldest_pose_s', 'pairs_left_out'),
)
CERTIFIED_COLUMNS = 'motion_before', 'certified_bound_m'
_MOTIONS = 'unknown', 'clear', 'contact'
_ROWS = 10_000  # that are written at once: memory stays flat


def write_csv(found: Clearances, path: Path) -> None:
    """Write a row for each state and set of pairs; ``distance_m`` is nan where not all is known.

    ``state`` is ``whole``, ``stale``, ``waiting`` or ``waiting, stale``.
    """
    with whole_file(path, newline='') as file:
        certified = any(pairs.motion is not None for pairs in found.sets.values())
        heads = (*COLUMNS, *(CERTIFIED_COLUMNS if certified else ()))
        csv.writer(file, lineterminator='\n').writerow(heads)
        for pairs in found.sets.values():
            for first in range(0, len(found.times), _ROWS):
                part = slice(first, first + _ROWS)
                rows = zip(*_columns(found, pairs, part), strict=True)
                file.writelines(','.join(row) + '\n' for row in rows)


def _columns(found: Clearances, pairs: SetClearance, part: slice) -> Iterator[Iterable[str]]:
    """Yield the columns of some rows as texts."""
    words = [_cell(text) for text in states_in_words(pairs)[part]]
    names = [*(_cell(name) for name in pairs.names), '']  # -1, the last one, for none
    yield _numbers(found.times[part])
    yield _numbers(found.stamps[part])
    yield repeat(_cell(pairs.name), len(words))
    yield words
    yield _numbers(pairs.distance[part])
    yield _numbers(pairs.error_bound[part])
    yield _numbers(pairs.known_distance[part])
    for places in (pairs.geometry_A, pairs.geometry_B):
        yield [names[place] for place in places[part].tolist()]
    for points in (pairs.p_WCa, pairs.p_WCb):
        for axis in range(3):
            yield _numbers(points[part, axis])
    yield _numbers(pairs.age[part].astype(np.float64))
    yield _numbers(pairs.left_out[part])
    if pairs.motion is not None and pairs.motion_bound is not None:
        yield [_MOTIONS[code] for code in pairs.motion[part].tolist()]
        yield _numbers(pairs.motion_bound[part])


def _numbers(values: NDArray[Any]) -> Iterator[str]:
    return map(repr, values.tolist())


def _cell(text: str) -> str:
    """Return a text as a cell of CSV."""
    cell = StringIO()
    csv.writer(cell, lineterminator='').writerow([text])
    return cell.getvalue()


def states_in_words(pairs: SetClearance) -> list[str]:
    """Return of each state whether it tells of all pairs, or why not."""
    flags = zip(pairs.is_waiting.tolist(), pairs.is_stale.tolist(), strict=True)
    words = {
        (False, False): 'whole',
        (False, True): 'stale',
        (True, False): 'waiting',
        (True, True): 'waiting, stale',
    }
    return [words[pair] for pair in flags]


def write_audit(audited: Audit, path: Path) -> None:
    """Write a row for each result and event that was computed again."""
    with whole_file(path, newline='') as file:
        rows = csv.writer(file, lineterminator='\n')
        rows.writerow(('time_s', 'topic', 'what', 'outcome', 'because'))
        for entry in audited.entries:
            rows.writerow((repr(entry.time), *entry[1:3], entry.outcome.value, entry.because))


def write_npz(found: Clearances, path: Path) -> None:
    """Write ``times`` (N,), ``stamps`` (N,) [ns], ``sets`` (k,), ``gaps`` (g, 2) [s].

    And of set k ``distance_k``, ``error_bound_k`` and the other fields of ``SetClearance``.
    """
    arrays: dict[str, Any] = {
        'times': found.times,
        'stamps': found.stamps,
        'sets': np.array(list(found.sets)),
        'gaps': np.array(found.gaps, dtype=np.float64).reshape(-1, 2),
    }
    for k, pairs in enumerate(found.sets.values()):
        for name in (
            *('distance', 'error_bound', 'known_distance', 'known_error_bound'),
            *('geometry_A', 'geometry_B', 'p_WCa', 'p_WCb', 'age', 'left_out', 'is_stale'),
        ):
            arrays[f'{name}_{k}'] = getattr(pairs, name)
        if pairs.motion is not None:
            arrays |= {f'motion_{k}': pairs.motion, f'motion_bound_{k}': pairs.motion_bound}
        arrays[f'names_{k}'] = np.array(pairs.names, dtype=np.str_)
    with whole_file(path, 'wb') as file:
        np.savez_compressed(file, **arrays)
