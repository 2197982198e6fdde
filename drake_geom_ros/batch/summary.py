"""What a batch found, in a few lines and as a picture: counted block by block.

Distances count by the ends of their certified intervals: what is told as apart is certified to be.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.questions import Columns
from drake_geom_ros.batch.running import BatchError

BINS = 60
Floats = NDArray[np.float64]


class Summary:
    """How many states and answers there are, how many collide, and how distances are spread."""

    def __init__(self, blocks: Iterable[Columns]) -> None:
        self.states = self.colliding = self.answers = 0
        self.has_distances = False
        lower: list[Floats] = []
        upper: list[Floats] = []
        for block in blocks:
            if 'collision' in block:
                self.states += len(block['collision'])
                self.colliding += int(block['collision'].sum())
                continue
            self.has_distances = True
            found, bound = block['distance'], block['error_bound']
            self.states += len(block.get('counts', found))
            there = np.isfinite(found)
            lower.append((found - bound)[there])
            upper.append((found + bound)[there])
        self.lower: Floats = np.concatenate(lower) if lower else np.zeros(0)
        self.upper: Floats = np.concatenate(upper) if upper else np.zeros(0)

    def lines(self) -> list[str]:
        """Return what there is to tell."""
        told = [f'states {self.states}']
        if not self.has_distances:
            share = self.colliding / max(self.states, 1)
            return [*told, f'colliding {self.colliding} ({100.0 * share:.2f} %)']
        told.append(f'distances {len(self.lower)}')
        if len(self.lower):
            low, middle, high = np.quantile(self.lower, [0.0, 0.5, 1.0])
            below, unsure = (float((ends < 0.0).mean()) for ends in (self.upper, self.lower))
            told.append(
                f'certified lower bounds: least {low:.6g} m, median {middle:.6g} m, '
                f'largest {high:.6g} m'
            )
            told.append(
                f'below zero {100.0 * below:.2f} %, '
                f'not certified to be above {100.0 * unsure:.2f} %'
            )
        return told

    def draw(self, path: Path, title: str) -> None:
        """Draw the histogram of lower bounds; raises BatchError where there is none to draw."""
        if not len(self.lower):
            raise BatchError(f'{path}: there are no distances to draw a histogram of')
        try:
            from matplotlib.figure import Figure
        except ImportError as error:
            raise BatchError(f'a picture takes matplotlib: {error}') from None
        figure = Figure(figsize=(7.0, 4.0), layout='constrained')
        axes = figure.add_subplot()
        edges = np.histogram_bin_edges(self.lower, BINS)
        for part, colour, label in (
            (self.lower[self.lower < 0.0], 'tab:red', 'not certified to be apart'),
            (self.lower[self.lower >= 0.0], 'tab:blue', 'apart'),
        ):
            if len(part):
                share = f'{100.0 * len(part) / len(self.lower):.1f} %'
                axes.hist(part, edges, color=colour, label=f'{label}: {share}')
        axes.axvline(0.0, color='black', linewidth=1.0)
        axes.set_xlabel('certified lower bound of the signed distance [m]')
        axes.set_ylabel('number of states' if self.states == len(self.lower) else 'number')
        axes.set_title(title)
        axes.legend()
        figure.savefig(path, dpi=120)
