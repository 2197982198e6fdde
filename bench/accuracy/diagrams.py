"""Pictures: the worst error over the time a pair, a panel a family; and what each level costs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib import patheffects, pyplot

from bench.accuracy.results import OURS, Measured
from bench.accuracy.tables import LEVELS_PICTURE, QUERY_TITLES, by_family
from bench.pages import PALETTE, legend_below
from truth.judging.asking import LEVELS, QUERIES

matplotlib.use('Agg')

BLUE, AMBER, SKY, ORANGE, DARK = PALETTE
COLOURS = {'pydrake': ORANGE, 'python-fcl': AMBER, 'Coal': SKY, 'MuJoCo': DARK}
MARKS = ('o', 's', '^', 'D', 'v', 'P')
SPARE = '#444444'  # of a peer without a colour of its own
MOST_DRAWN = 10.0  # [m] larger than any body and any gap
ROOM_BELOW = 0.02  # of the least error that is drawn: for the names of the levels
LEAST_PART = 0.1  # of a peer's time that is drawn for the computation, at least
COLUMNS = 2  # legible at the width of a page
# The families that are drawn: solved in closed form or not, solids, a scene; all are in tables.
CHOSEN = (
    *('hulls, 64 vertices', 'cylinders', 'solid meshes, 1300 triangles', 'two arms'),
    *('points', 'points to hulls, 8 vertices', 'points to hulls, 64 vertices'),
    'points to solid meshes, 1300 triangles',
)
STYLES = dict(
    zip(
        LEVELS,
        (('#999999', 's'), (ORANGE, '^'), (SKY, 'D'), (BLUE, 'o')),
        strict=True,
    )
)


def draw(records: Sequence[Measured], folder: Path) -> list[str]:
    """Write a PNG for each query that was measured; return their names.

    Where no family of CHOSEN was measured, all that were are drawn.
    """
    families = by_family(records)
    written = []
    for query in QUERIES:
        panels = {family: rs for (q, family), rs in families.items() if q == query}
        panels = {family: panels[family] for family in CHOSEN if family in panels} or panels
        if panels:
            _figure(query, panels, folder / f'{query}.png')
            written.append(f'{query}.png')
    return written


def _figure(query: str, panels: dict[str, list[Measured]], path: Path) -> None:
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure, axes = pyplot.subplots(
        rows,
        columns,
        figsize=(9.0, 2.9 * rows + 2.2),
        sharex=True,
        sharey=True,
        squeeze=False,
        layout='constrained',
    )
    for panel in axes.flat[len(panels) :]:
        panel.set_visible(False)
    for panel, (family, settings) in zip(axes.flat, panels.items(), strict=False):
        _panel(panel, family, settings)
    for number, panel in enumerate(axes.flat[: len(panels)]):
        if number + columns >= len(panels):
            panel.set_xlabel('time per pair [us]')
            panel.tick_params(labelbottom=True)
        if number % columns == 0:
            panel.set_ylabel('error [m]')
    figure.suptitle(
        f'{QUERY_TITLES[query]}: lower is more accurate, further left is faster\n'
        'marks: worst error; thin lines: down to the median error, left to the computation alone',
        fontsize=11,
    )
    lowest = min(drawn(0.0, r) for rs in panels.values() for r in rs)
    axes[0, 0].set_ylim(bottom=ROOM_BELOW * lowest)
    legend_below(figure, 2)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def _panel(panel: Any, family: str, settings: Sequence[Measured]) -> None:
    mine = [r for r in settings if r.setting.library == OURS and r.answers and r.whole]
    _levels(panel, mine)
    seen: dict[str, int] = {}
    for r in settings:
        if r.setting.library == OURS or not r.answers or not r.whole:
            continue
        number = seen[r.setting.library] = seen.get(r.setting.library, -1) + 1
        colour = COLOURS.get(r.setting.library, SPARE)
        _spread(panel, r, colour)
        panel.plot(
            *(r.whole * 1e6, drawn(r.error(1.0), r)),
            marker=MARKS[number % len(MARKS)],
            color=colour,
            ms=6.5,
            ls='none',
            label=f'{r.setting.library}, {_words(r.setting.label)}',
        )
    panel.set_title(family, fontsize=10)
    panel.margins(x=0.08, y=0.1)
    panel.set_xscale('log')
    panel.set_yscale('log')
    panel.xaxis.set_major_formatter('{x:g}')
    panel.grid(color='#dddddd', lw=0.6)
    panel.set_axisbelow(True)


def _levels(panel: Any, mine: Sequence[Measured]) -> None:
    """Draw our levels: the line of worst errors, names, and the worst bounds above them."""
    if not mine:
        return
    times = [r.whole * 1e6 for r in mine if r.whole]
    worst = [drawn(r.error(1.0), r) for r in mine]
    bounds = [drawn(r.worst_bound(), r) for r in mine]
    panel.plot(times, worst, '-o', color=BLUE, ms=5, lw=1.6, label='ours: worst error', zorder=3)
    panel.plot(
        *(times, bounds, '_'), color=BLUE, ms=13, mew=2, label='ours: worst certified bound'
    )
    for r in mine:
        _spread(panel, r, BLUE)
    labels = [r.setting.label for r in mine]
    for x, y, words in level_names(list(zip(times, worst, labels, strict=True))):
        several = ' ' in words
        panel.annotate(
            *(words, (x, y)),
            xytext=(14 if several else -5, -13 if several else -11),
            textcoords='offset points',
            ha='right',
            fontsize=9,
            color=BLUE,
            path_effects=[patheffects.withStroke(linewidth=2.5, foreground='white')],
        )


def level_names(points: list[tuple[float, float, str]]) -> list[tuple[float, float, str]]:
    """Return where names stand; those of points that lie close share a place."""
    places: list[tuple[float, float, list[str]]] = []
    for x, y, word in points:
        for px, py, words in places:
            if abs(math.log10(x / px)) < 0.6 and abs(math.log10(y / py)) < 1.0:
                words.append(word)
                break
        else:
            places.append((x, y, [word]))
    return [
        (x, y, words[0] if len(words) == 1 else f'{words[0]} to {words[-1]}')
        for x, y, words in places
    ]


def _spread(panel: Any, r: Measured, colour: str) -> None:
    """Draw thin lines from the worst error to the median, and to the time without the call."""
    x, y = (r.whole or 0.0) * 1e6, drawn(r.error(1.0), r)
    panel.plot([x, x], [drawn(r.error(0.5), r), y], color=colour, lw=0.7, alpha=0.6)
    inside = (r.inside or 0.0) * 1e6
    if r.setting.library != OURS:
        # The difference of two times, of which little more can be told.
        inside = max(inside, LEAST_PART * x)
    panel.plot([inside, x], [y, y], color=colour, lw=0.7, alpha=0.6)


def drawn(value: float, r: Measured) -> float:
    """Return an error [m] as it is drawn.

    0 and rounding become the spacing of floats at that size; a peer's 1.8e308 becomes MOST_DRAWN.
    """
    return min(max(value, r.rounding()), MOST_DRAWN)


def _words(label: str) -> str:
    return f'tolerance {label}' if label[0].isdigit() else label


def draw_levels(records: Sequence[Measured], folder: Path) -> list[str]:
    """Write the picture of signed distances, a row a family; return its name, if any was made."""
    families = {
        family: [r for r in settings if r.setting.library == OURS and r.errors and r.whole]
        for (query, family), settings in by_family(records).items()
        if query == 'signed_distance'
    }
    families = {family: mine for family, mine in families.items() if mine}
    if not families:
        return []
    figure, (times, errors) = pyplot.subplots(
        1, 2, sharey=True, figsize=(9.0, 0.32 * len(families) + 1.9), layout='constrained'
    )
    for row, mine in enumerate(families.values()):
        for r in mine:
            colour, mark = STYLES[r.setting.label]
            style = {'color': colour, 'marker': mark, 'ms': 7, 'ls': 'none', 'alpha': 0.8}
            times.plot((r.whole or 0.0) * 1e6, row, label=r.setting.label, **style)
            errors.plot(drawn(r.error(1.0), r), row, **style)
    for axes in (times, errors):
        axes.set_xscale('log')
        axes.grid(color='#dddddd', lw=0.6)
        axes.set_axisbelow(True)
    times.set_yticks(range(len(families)), families, fontsize=10)
    times.invert_yaxis()
    times.set_xlabel('time per pair [us]')
    times.xaxis.set_major_formatter('{x:g}')
    errors.set_xlabel('worst error [m]')
    figure.suptitle('Signed distance at each accuracy level: time on the left, error on the right')
    legend_below(figure, len(LEVELS))
    figure.savefig(folder / LEVELS_PICTURE, dpi=110, bbox_inches='tight', pad_inches=0.15)
    pyplot.close(figure)
    return [LEVELS_PICTURE]
