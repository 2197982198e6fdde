"""Where more workers stop helping a batch, drawn from what ``bench.batches --cluster`` measured.

    python -m bench.batches.plot --microseconds 24 --task 2.3 --bytes 330 --out docs/batches.png

Workers compute, the scheduler hands out tasks one after the other, and one machine sends all
states and takes all results by its link: a batch is as fast as the slowest of the three.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bench.pages import PALETTE

BLOCKS = (10_000, 100_000)  # states a task
LINKS = {'1 Gbit/s': 117e6, '10 Gbit/s': 1170e6}  # bytes a second that get through
MOST = 2000  # workers


def main() -> None:
    """Draw the plot, and print where each limit is met."""
    parser = argparse.ArgumentParser(prog='bench.batches.plot', description=__doc__)
    parser.add_argument('--microseconds', type=float, required=True, help='a state')
    parser.add_argument('--task', type=float, required=True, help='of the scheduler [ms]')
    parser.add_argument('--bytes', type=float, required=True, help='a state, in and out')
    parser.add_argument('--out', type=Path, required=True)
    given = parser.parse_args()
    one = 1e6 / given.microseconds  # states a second
    workers = np.geomspace(1, MOST, 200)
    figure = Figure(figsize=(7.0, 5.0), layout='constrained')
    axes = figure.add_subplot()
    axes.plot(workers, workers * one, 'k', label=f'workers: {one:,.0f} states/s each')
    limits = {
        **{f'scheduler, {size:,} states a task': 1e3 * size / given.task for size in BLOCKS},
        **{f'link of {name}': speed / given.bytes for name, speed in LINKS.items()},
    }
    blue, *_, orange, _ = PALETTE
    styles = ((orange, '--'), (orange, ':'), (blue, '--'), (blue, ':'))
    for (name, speed), (colour, line) in zip(limits.items(), styles, strict=True):
        axes.axhline(
            speed, color=colour, linestyle=line, label=f'{name}: {speed / one:.0f} workers'
        )
        print(f'{name}: {speed:,.0f} states a second, met at {speed / one:.0f} workers')
    axes.set(xscale='log', yscale='log', xlabel='workers', ylabel='states a second')
    axes.set_title('Minimum distances of two arms: the lowest line limits a batch')
    axes.grid(which='both', alpha=0.3)
    figure.legend(loc='outside lower center', ncols=2)
    figure.savefig(given.out, dpi=110)


if __name__ == '__main__':
    main()
