"""What a batch found, in a few lines and as a picture: counted block by block."""

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
        distances: list[Floats] = []
        for block in blocks:
            if 'collision' in block:
                self.states += len(block['collision'])
                self.colliding += int(block['collision'].sum())
                continue
            self.has_distances = True
            found = block['distance']
            self.states += len(block.get('counts', found))
            distances.append(found[np.isfinite(found)])
        self.distances: Floats = np.concatenate(distances) if distances else np.zeros(0)

    def lines(self) -> list[str]:
        """Return what there is to tell."""
        told = [f'states {self.states}']
        if not self.has_distances:
            share = self.colliding / max(self.states, 1)
            return [*told, f'colliding {self.colliding} ({100.0 * share:.2f} %)']
        told.append(f'distances {len(self.distances)}')
        if len(self.distances):
            low, middle, high = np.quantile(self.distances, [0.0, 0.5, 1.0])
            below = float((self.distances < 0.0).mean())
            told.append(f'least {low:.6g} m, median {middle:.6g} m, largest {high:.6g} m')
            told.append(f'below zero {100.0 * below:.2f} %')
        return told

    def draw(self, path: Path, title: str) -> None:
        """Draw the histogram of the distances; raises BatchError where there is none to draw."""
        if not len(self.distances):
            raise BatchError(f'{path}: there are no distances to draw a histogram of')
        try:
            from matplotlib.figure import Figure
        except ImportError as error:
            raise BatchError(f'a picture takes matplotlib: {error}') from None
        figure = Figure(figsize=(7.0, 4.0), layout='constrained')
        axes = figure.add_subplot()
        edges = np.histogram_bin_edges(self.distances, BINS)
        for part, colour, label in (
            (self.distances[self.distances < 0.0], 'tab:red', 'overlap'),
            (self.distances[self.distances >= 0.0], 'tab:blue', 'apart'),
        ):
            if len(part):
                share = f'{100.0 * len(part) / len(self.distances):.1f} %'
                axes.hist(part, edges, color=colour, label=f'{label}: {share}')
        axes.axvline(0.0, color='black', linewidth=1.0)
        axes.set_xlabel('signed distance [m]')
        axes.set_ylabel('number of states' if self.states == len(self.distances) else 'number')
        axes.set_title(title)
        axes.legend()
        figure.savefig(path, dpi=120)
