"""Draws what bench.images measured: time over pixels, primitives and triangles, by engine.

./run exec python -m bench.images.plot out/images.json docs/images_cost.png
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from matplotlib.figure import Figure

from bench.pages import PALETTE

BLUE, _, SKY, ORANGE, DARK = PALETTE

_LABELS = {
    'exact': 'MakeRenderEngineExact, one pass',
    'VTK': 'MakeRenderEngineVtk',
    'pydrake': 'pydrake, RenderEngineVtk',
    'moderngl': 'moderngl, tessellated',
}
_STYLES = {'exact': 'o-', 'VTK': 's--', 'pydrake': '^:', 'moderngl': 'd-.'}
_COLOURS = dict(zip(_LABELS, (BLUE, SKY, ORANGE, DARK), strict=True))
_TITLES = {
    'pixels': 'pixels (arms and table)',
    'primitives': 'primitives (640 x 480)',
    'triangles': 'triangles of a mesh (640 x 480)',
}


def draw(source: Path, target: Path) -> None:
    """Draw the figures of a file."""
    found = json.loads(source.read_text())
    figure = Figure(figsize=(9.0, 3.4), layout='constrained')
    for axes, (what, title) in zip(
        figure.subplots(1, 3, sharey=True), _TITLES.items(), strict=True
    ):
        for name, label in _LABELS.items():
            if told := found.get(name, {}).get(what):
                axes.loglog(
                    [int(count) for count in told],
                    list(told.values()),
                    _STYLES[name],
                    color=_COLOURS[name],
                    label=label,
                )
        axes.set_xlabel(title)
        axes.grid(visible=True, which='major', alpha=0.3)
    first = figure.axes[0]
    first.set_ylim(top=2e4)  # room for the legend
    first.set_ylabel('three images [ms of processor time]')
    first.legend(loc='upper left', fontsize='small')
    figure.savefig(target, dpi=110)


if __name__ == '__main__':
    draw(*map(Path, sys.argv[1:3]))
