"""Robots among people, with a referee.

::

    python -m bench.stopping hour      # an hour by each strategy: docs/accuracy/stopping.csv
    python -m bench.stopping options   # levels, resolution, budget: docs/accuracy
    python -m bench.stopping page      # the table of docs/stopping.md, and its picture

A run of ten minutes is one seed. Times are of the processes of one run: compare them, do not
quote them.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterable
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from bench.stopping.room import ROBOTS
from bench.stopping.runs import run_strategy
from bench.stopping.strategies import STRATEGIES

DOCS = Path(__file__).resolve().parents[2] / 'docs'
HOUR = DOCS / 'accuracy/stopping.csv'
_COLUMNS = ('strategy', 'seed', 'seconds', *ROBOTS, 'contacts', 'median_ms')


def _write(path: Path, rows: Iterable[dict[str, Any]]) -> None:
    """Write rows as they come."""
    with path.open('w', newline='') as file:
        table = csv.DictWriter(file, _COLUMNS, lineterminator='\n')
        table.writeheader()
        for row in rows:
            table.writerow(row)
            file.flush()
            print(row)


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('what', choices=('hour', 'options', 'page'))
    parser.add_argument('--processes', type=int, default=2)
    options = parser.parse_args()
    if options.what == 'page':
        from bench.stopping.pictures import page_table, plot  # needs matplotlib

        plot(HOUR, DOCS / 'stopping.png')
        print(page_table(HOUR))
        return
    if options.what == 'options':
        from bench.stopping.options import write  # needs matplotlib

        write(DOCS / 'accuracy')
        return
    jobs = [(name, seed) for name in reversed(STRATEGIES) for seed in range(1, 7)]
    with get_context('spawn').Pool(options.processes) as pool:
        _write(HOUR, pool.imap(run_strategy, jobs))


if __name__ == '__main__':
    main()
