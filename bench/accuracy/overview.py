"""The picture at the top of docs/accuracy: time over accuracy, of pairs and of two arms.

Drawn from the tables that ``bench.accuracy.lengths`` and ``bench.accuracy.arms`` wrote.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Protocol

import matplotlib
import numpy as np
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from bench.accuracy.results import OURS
from bench.pages import PALETTE

matplotlib.use('Agg')

PICTURE, CELL_PICTURE = 'overview.png', 'cell.png'
FINEST, COARSEST = 1e-9, 1e-1  # [m]
COLOURS = (*PALETTE, '#009e73', '#cc79a7')
MARKERS = {'pydrake': 's', 'python-fcl': '^', 'Coal': '*', 'MuJoCo': 'D'}


class Timed(Protocol):
    """What both tables say of a family at an accuracy [m]; 0 for what has none."""

    family: str
    accuracy: float
    microseconds: float
    error_bound: float


class TimedPair(Timed, Protocol):
    """The same of pairs, ours or a peer's."""

    library: str


def draw(pairs: Iterable[TimedPair], arms: Iterable[Timed], path: Path) -> None:
    """Write the picture: a line a family, and peers as points at their largest error."""
    pairs = list(pairs)
    figure, (left, right) = pyplot.subplots(
        ncols=2, figsize=(11.0, 6.4), layout='constrained', sharex=True
    )
    colours = draw_lines(left, [row for row in pairs if row.library == OURS])
    peers = [row for row in pairs if row.library != OURS]
    for row in peers:
        left.plot(
            float(np.clip(row.error_bound, FINEST, COARSEST)),
            row.microseconds,
            MARKERS[row.library],
            color=colours[row.family],
            markeredgecolor='black',
            markersize=13 if row.library == 'Coal' else 8,
        )
    draw_lines(right, arms)
    left.set_title(
        'one pair, 2 mm to 0.2 m apart;\npeers at their worst error (left edge: that or less)'
    )
    right.set_title('two arms, all distances up to 0.2 m of a state')
    handles = left.get_legend_handles_labels()[0]
    handles += [
        Line2D([], [], marker=marker, color='white', markeredgecolor='black', label=name)
        for name, marker in MARKERS.items()
        if any(row.library == name for row in peers)
    ]
    left.legend(handles=handles, loc='upper center', bbox_to_anchor=(0.5, -0.13), ncols=2)
    right.legend(loc='upper center', bbox_to_anchor=(0.5, -0.13), ncols=1)
    figure.savefig(path, dpi=100)
    pyplot.close(figure)


def draw_lines(axes: Axes, rows: Iterable[Timed]) -> dict[str, str]:
    """Draw a line a family, time over accuracy; return their colours."""
    axes.set_xscale('log')
    axes.set_yscale('log')
    axes.set_xlabel('accuracy that is wanted, largest error [m]')
    axes.set_ylabel('time [us]')
    axes.grid(alpha=0.3)
    families: dict[str, list[Timed]] = {}
    for row in rows:
        if row.accuracy > 0.0:
            families.setdefault(row.family, []).append(row)
    colours = dict(zip(families, COLOURS, strict=False))
    for family, of_family in families.items():
        lengths, times = zip(*((r.accuracy, r.microseconds) for r in of_family), strict=True)
        axes.plot(lengths, times, 'o-', color=colours[family], label=family)
    return colours
