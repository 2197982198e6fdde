"""Distances over time as files: ``clearance.csv`` to be read, ``clearance.npz`` to be computed."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros.common.whole_files import whole_file
from drake_geom_ros.recordings.results import Clearances, SetClearance

COLUMNS = (
    *('time_s', 'stamp_ns', 'set', 'state', 'distance_m', 'error_bound_m', 'known_distance_m'),
    *('geometry_a', 'geometry_b', 'ax_m', 'ay_m', 'az_m', 'bx_m', 'by_m', 'bz_m'),
    *('oldest_pose_s', 'pairs_left_out'),
)


def write_csv(found: Clearances, path: Path) -> None:
    """Write a row for each state and set of pairs; ``distance_m`` is nan where not all is known.

    ``state`` is ``whole``, ``stale``, ``waiting`` or ``waiting, stale``.
    """
    with whole_file(path, newline='') as file:
        rows = csv.writer(file, lineterminator='\n')
        rows.writerow(COLUMNS)
        for pairs in found.sets.values():
            for k, words in enumerate(states_in_words(pairs)):
                at, whole = pairs.at(k), words == 'whole'
                known = (at.distance, at.error_bound)
                numbers = (*(known if whole else (np.nan, np.nan)), at.distance)
                points = (*at.p_WCa.tolist(), *at.p_WCb.tolist())
                rows.writerow(
                    (
                        *(repr(at.time), int(found.stamps[k]), pairs.name, words),
                        *(repr(float(number)) for number in numbers),
                        *(at.name_A, at.name_B),
                        *(repr(number) for number in points),
                        *(repr(float(pairs.age[k])), int(pairs.left_out[k])),
                    )
                )


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
        arrays[f'names_{k}'] = np.array(pairs.names, dtype=np.str_)
    with whole_file(path, 'wb') as file:
        np.savez_compressed(file, **arrays)
