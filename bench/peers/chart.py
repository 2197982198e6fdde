"""Two charts: how many times as fast as pydrake each library is, by query and scene."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib import pyplot
from matplotlib.ticker import LogLocator

from bench.pages import legend_below
from bench.peers.report import LIBRARIES, Measurement, number
from bench.peers.scenes import QUERIES

matplotlib.use('Agg')

COLOURS = dict(
    zip(LIBRARIES, ('#1f6fb4', '#222222', '#d9822b', '#9a9a9a', '#56b4e9'), strict=True)
)
TITLES = {
    'penetration': 'penetrations',
    'candidates': 'candidate pairs',
    'near': 'signed distances within 0.1 m',
    'all': 'signed distances of all pairs',
    'points': '100 points',
    'has_collisions': 'is there any collision?',
}
# What the small chart shows, each with a colour and a mark.
SUMMARY = {
    'penetration': ('#1f6fb4', 'o'),
    'near': ('#d9822b', 's'),
    'points': ('#444444', '^'),
}
COLUMNS = 2
WIDTH = 10.0  # [in]
ROW = 0.3  # [in]
DPI = 110


def shown(measurements: list[Measurement]) -> list[Measurement]:
    """Return what the charts show: one pace, all bodies moving, and an answer of pydrake.

    The pace is that of robots, where it was measured: three bars a scene would be too many.
    """
    paces = {m.pace for m in measurements}
    pace = 'robot' if 'robot' in paces else min(paces, default='')
    return [
        m for m in measurements if m.pace == pace and '/' not in m.scene and m.ratio('pydrake')
    ]


def draw(measurements: list[Measurement], path: Path) -> None:
    """Write a PNG with a panel for each query that was measured beside pydrake."""
    told = shown(measurements)
    queries = [query for query in QUERIES if any(m.query == query for m in told)]
    if not queries:
        return
    rows = max(sum(m.query == query for m in told) for query in queries)
    columns = min(COLUMNS, len(queries))
    height = -(-len(queries) // columns)
    figure, axes = pyplot.subplots(
        height,
        columns,
        figsize=(WIDTH, height * (0.9 + ROW * rows) + 0.9),
        squeeze=False,
        layout='constrained',
    )
    for panel in axes.flat[len(queries) :]:
        panel.set_visible(False)
    for panel, query in zip(axes.flat, queries, strict=False):
        _panel(panel, query, [m for m in told if m.query == query])
    figure.suptitle(
        'How many times as fast as pydrake: to the right of 1 is faster\n'
        f'(poses and query, means of one run, all bodies move; pace: {told[0].pace})',
        fontsize=12,
    )
    legend_below(figure, 6)
    figure.savefig(path, dpi=DPI, bbox_inches='tight', pad_inches=0.15)
    pyplot.close(figure)


def draw_summary(measurements: list[Measurement], path: Path) -> None:
    """Write a PNG with one panel: three queries beside pydrake, a row for each scene."""
    told = [m for m in shown(measurements) if m.query in SUMMARY]
    if not told:
        return
    scenes = list(dict.fromkeys(m.scene for m in told))
    figure, axes = pyplot.subplots(
        figsize=(0.85 * WIDTH, ROW * len(scenes) + 1.8), layout='constrained'
    )
    for query, (colour, mark) in SUMMARY.items():
        points = [(m.ratio('pydrake'), scenes.index(m.scene)) for m in told if m.query == query]
        style = {'color': colour, 'ls': 'none', 'ms': 8, 'label': TITLES[query]}
        axes.plot(*zip(*points, strict=True), mark, **style)
    _ratios(axes, scenes)
    axes.set_title('How many times as fast as pydrake: to the right of 1 is faster', fontsize=12)
    legend_below(figure, len(SUMMARY) + 1)
    figure.savefig(path, dpi=DPI, bbox_inches='tight', pad_inches=0.15)
    pyplot.close(figure)


def _panel(panel: pyplot.Axes, query: str, measurements: list[Measurement]) -> None:
    """Draw a row for each scene, top to bottom."""
    for row, m in enumerate(measurements):
        ratio = m.ratio('pydrake')
        panel.barh(row, ratio - 1, left=1, color=COLOURS['ours'], height=0.55, label='ours')
        edge = {'transform': panel.get_yaxis_transform(), 'va': 'center', 'fontsize': 9}
        panel.text(1.01, row, number(ratio, 'x'), color=COLOURS['ours'], **edge)
        for name in LIBRARIES[2:]:
            theirs = m.mean(name)
            if theirs:
                speed = m.mean('pydrake') / theirs
                panel.plot(speed, row, 'o', color=COLOURS[name], ms=5, label=name)
    _ratios(panel, [m.scene for m in measurements])
    panel.set_title(TITLES[query], fontsize=11)


def _ratios(panel: pyplot.Axes, scenes: list[str]) -> None:
    """Give a panel its axes: ratios from left to right, scenes from top to bottom."""
    panel.axvline(1, color=COLOURS['pydrake'], lw=1, label='pydrake')
    panel.set_xscale('log')
    panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    panel.xaxis.set_major_formatter('{x:g}')
    panel.xaxis.set_minor_formatter('')
    panel.set_yticks(range(len(scenes)), scenes, fontsize=10)
    panel.invert_yaxis()
    panel.margins(x=0.1, y=0.02)
    panel.grid(axis='x', color='#dddddd', lw=0.6)
    panel.set_axisbelow(True)
