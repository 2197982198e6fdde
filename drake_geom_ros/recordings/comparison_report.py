"""Comparison of two runs as a table and a picture."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np

from drake_geom_ros.common.whole_files import whole_file
from drake_geom_ros.recordings.comparing import SetComparison
from drake_geom_ros.recordings.report_plot import plain

TABLE, PICTURE = 'comparison.csv', 'comparison.png'
_COLUMNS = 'set', 'from', 'to', 'distance_m', 'other_m', 'difference_m', 'all_known'
_DOTS = 110  # an inch


def write_comparison(comparisons: Sequence[SetComparison], folder: Path, other: str) -> list[Path]:
    """Write the files of a comparison with ``other``; return them."""
    with whole_file(folder / TABLE, newline='') as file:
        rows = csv.writer(file, lineterminator='\n')
        rows.writerow(_COLUMNS)
        for each in comparisons:
            columns = each.ends[:-1], each.ends[1:], each.run, each.other, each.difference
            for numbers, whole in zip(zip(*columns, strict=True), each.is_whole, strict=True):
                rows.writerow((each.name, *(repr(float(n)) for n in numbers), int(whole)))
    with whole_file(folder / PICTURE, 'wb') as picture:
        picture.write(_draw(comparisons, other))
    return [folder / TABLE, folder / PICTURE]


def _draw(comparisons: Sequence[SetComparison], other: str) -> bytes:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 1.0 + 3.4 * len(comparisons)), dpi=_DOTS, layout='constrained')
    FigureCanvasAgg(figure)
    axes = figure.subplots(len(comparisons), 1, sharex=True, squeeze=False)[:, 0]
    for place, each in zip(axes, comparisons, strict=True):
        starts, width = each.ends[:-1], each.ends[1] - each.ends[0]
        for k, begin in enumerate(starts[~each.is_whole]):
            label = None if k else 'not, or not all, known of both'
            place.axvspan(begin, begin + width, color='0.85', lw=0.5, zorder=0.5, label=label)
        place.plot(starts, each.other, color='tab:grey', lw=1.2, label='the other run')
        place.plot(starts, each.run, color='tab:blue', lw=1.2, label='this run')
        nearer = np.nan_to_num(each.difference, nan=0.0) < 0.0
        place.fill_between(
            starts,
            each.run,
            each.other,
            where=nearer,
            color='tab:orange',
            alpha=0.25,
            lw=0,
            label='this run is nearer',
        )
        place.set_title(plain(each.name), loc='left', fontsize='medium')
        place.set_ylabel('least distance [m]')
        place.legend(fontsize='x-small', loc='upper left', bbox_to_anchor=(1.0, 1.0))
    is_time = comparisons[0].by == 'time'
    axes[-1].set_xlabel('time since the recording began [s]' if is_time else 'phase of the motion')
    figure.suptitle(plain(f'This run beside {other}'))
    picture = BytesIO()
    figure.savefig(picture, format='png')
    return picture.getvalue()
