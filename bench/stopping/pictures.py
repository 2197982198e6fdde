"""The table and the picture of an hour by each strategy."""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path

import matplotlib as mpl

mpl.use('Agg')
from matplotlib import pyplot as plt

from bench.pages import legend_below, table
from bench.stopping.room import ROBOTS

Rows = list[dict[str, str]]
_COLOURS = {'arm': '#1f5fa8', 'base': '#e66100'}


def read(path: Path) -> dict[str, Rows]:
    """Return the rows of a table by strategy."""
    rows = defaultdict(list)
    with path.open() as file:
        for row in csv.DictReader(file):
            rows[row['strategy']].append(row)
    return dict(rows)


def total(rows: Rows, column: str) -> float:
    """Return the sum of a column."""
    return sum(float(row[column]) for row in rows)


def motion(rows: Rows, robot: str) -> float:
    """Return the time that a robot's way takes at its nominal speed, in percent of the time."""
    return 100.0 * total(rows, robot) / total(rows, 'seconds')


def page_table(path: Path) -> str:
    """Return the table of the page: one row a strategy."""
    columns = 'strategy', 'simulated', *(f'{robot}: motion' for robot in ROBOTS)
    rows = [
        (
            name,
            f'{total(rows, "seconds") / 60.0:.0f} min',
            *(f'{motion(rows, robot):.1f} %' for robot in ROBOTS),
            f'{total(rows, "contacts"):.0f}',
        )
        for name, rows in read(path).items()
    ]
    return table((*columns, 'hundredths of a second in contact while moving'), rows)


def plot(path: Path, target: Path) -> None:
    """Draw the motion of each robot by strategy."""
    runs = read(path)
    figure, axes = plt.subplots(figsize=(6.5, 3.2), layout='constrained')
    for k, robot in enumerate(ROBOTS):
        shares = [motion(rows, robot) for rows in runs.values()]
        places = [n + 0.36 * k for n in range(len(runs))]
        bars = axes.bar(places, shares, 0.34, color=_COLOURS[robot], label=robot)
        axes.bar_label(bars, fmt='%.0f')
    axes.set_xticks([n + 0.18 for n in range(len(runs))], list(runs))
    axes.set_ylabel('motion [% of the time]')
    axes.margins(y=0.12)
    legend_below(figure, 2)
    figure.savefig(target, dpi=110)
