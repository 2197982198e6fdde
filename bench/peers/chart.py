"""The chart: how many times faster than pydrake each library is, by query and scene."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib import pyplot
from matplotlib.ticker import LogLocator

from bench.peers.report import LIBRARIES, Measurement, number, over_pydrake
from bench.peers.scenes import QUERIES

matplotlib.use('Agg')

COLOURS = dict(
    zip(LIBRARIES, ('#1f6fb4', '#222222', '#d9822b', '#9a9a9a', '#4d9a5b'), strict=True)
)
TITLES = {
    'penetration': 'penetration',
    'candidates': 'candidates',
    'near': 'signed distance up to 0.1 m',
    'all': 'signed distance, all pairs',
    'points': '100 points',
    'has_collisions': 'has collisions',
}


def draw(measurements: list[Measurement], path: Path) -> None:
    """Write a PNG with a panel for each query that was measured beside pydrake.

    It shows the pace of robots, where that was measured: three bars a scene would be too many.
    """
    paces = {m.pace for m in measurements}
    pace = 'robot' if 'robot' in paces else min(paces, default='')
    told = [m for m in measurements if m.pace == pace and m.ratio('pydrake')]
    queries = [query for query in QUERIES if any(m.query == query for m in told)]
    if not queries:
        return
    rows = max(sum(m.query == query for m in told) for query in queries)
    columns = min(3, len(queries))
    height = -(-len(queries) // columns)
    figure, axes = pyplot.subplots(
        height,
        columns,
        figsize=(5.6 * columns, height * (1.2 + 0.26 * rows)),
        squeeze=False,
        layout='constrained',
    )
    for panel in axes.flat[len(queries) :]:
        panel.set_visible(False)
    for panel, query in zip(axes.flat, queries, strict=False):
        _panel(panel, query, [m for m in told if m.query == query])
    handles = {
        label: handle
        for panel in axes.flat
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    figure.suptitle(f'Times faster than pydrake, poses and query, means of one run; pace: {pace}')
    figure.legend(
        handles.values(), handles.keys(), loc='outside lower center', ncol=6, frameon=False
    )
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def _panel(panel: pyplot.Axes, query: str, measurements: list[Measurement]) -> None:
    """Draw a row for each scene, top to bottom."""
    for row, m in enumerate(measurements):
        ratio = m.ratio('pydrake')
        panel.barh(row, ratio - 1, left=1, color=COLOURS['ours'], height=0.55, label='ours')
        edge = {'transform': panel.get_yaxis_transform(), 'va': 'center', 'fontsize': 8}
        panel.text(1.01, row, number(ratio, 'x'), color=COLOURS['ours'], **edge)
        bar = over_pydrake(m.scene, query)
        panel.plot([bar, bar], [row - 0.42, row + 0.42], color='#c0392b', lw=2, label='bar')
        for name in LIBRARIES[2:]:
            theirs = m.mean(name)
            if theirs:
                speed = m.mean('pydrake') / theirs
                panel.plot(speed, row, 'o', color=COLOURS[name], ms=5, label=name)
    panel.axvline(1, color=COLOURS['pydrake'], lw=1, label='pydrake')
    panel.set_xscale('log')
    panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    panel.xaxis.set_major_formatter('{x:g}')
    panel.xaxis.set_minor_formatter('')
    panel.set_yticks(range(len(measurements)), [m.scene for m in measurements], fontsize=8)
    panel.invert_yaxis()
    panel.margins(x=0.1, y=0.01)
    panel.set_title(TITLES[query], fontsize=10)
    panel.grid(axis='x', color='#dddddd', lw=0.6)
    panel.set_axisbelow(True)
