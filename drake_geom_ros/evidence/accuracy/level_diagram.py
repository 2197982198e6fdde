"""What each level costs, and how far off its answers are: the summary of the page, a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib
from matplotlib import pyplot

from drake_geom_ros.evidence.accuracy.diagrams import drawn
from drake_geom_ros.evidence.accuracy.ours import LEVELS
from drake_geom_ros.evidence.accuracy.results import OURS, Measured
from drake_geom_ros.evidence.accuracy.tables import LEVELS_PICTURE, by_family

matplotlib.use('Agg')

STYLES = dict(
    zip(
        LEVELS,
        (('#999999', 's'), ('#d9822b', '^'), ('#2e8b57', 'D'), ('#1f5fb4', 'o')),
        strict=True,
    )
)


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
    handles, labels = times.get_legend_handles_labels()
    first = dict(zip(labels, handles, strict=True))
    figure.legend(
        first.values(), first.keys(), loc='outside lower center', ncol=len(LEVELS), frameon=False
    )
    figure.savefig(folder / LEVELS_PICTURE, dpi=110, bbox_inches='tight', pad_inches=0.15)
    pyplot.close(figure)
    return [LEVELS_PICTURE]
