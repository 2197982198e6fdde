"""results.csv: the closest pairs of every result by name."""

import csv
from pathlib import Path

from drake_geom_ros.ros.demo.recording import Recording

COLUMNS = (
    'time', 'geometry_a', 'geometry_b', 'distance', 'depth', 'error_bound', 'method', 'age'
)  # fmt: skip


def write_results(recording: Recording, path: Path) -> int:
    """Write the file and return the number of its rows.

    ``time`` [s] counts from the first result; ``distance`` and ``error_bound`` [m] are those of
    ~/signed_distances, ``depth`` [m] that of ~/penetrations for the same poses, empty where the
    pair does not penetrate; ``method`` is a METHOD_* constant, ``age`` [s] the answer's.
    """
    rows = 0
    with open(path, 'w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for pairs in recording.pairs:
            for k in range(len(pairs.distance)):
                a, b = int(pairs.id_a[k]), int(pairs.id_b[k])
                depth = recording.depth_of.get((pairs.time, a, b))
                writer.writerow(
                    [
                        f'{pairs.time - recording.start:.4f}',
                        recording.scene[a].full_name,
                        recording.scene[b].full_name,
                        f'{pairs.distance[k]:.9g}',
                        '' if depth is None else f'{depth:.9g}',
                        f'{pairs.error_bound[k]:.3g}',
                        int(pairs.method[k]),
                        f'{pairs.age:.6f}',
                    ]
                )
                rows += 1
    return rows
