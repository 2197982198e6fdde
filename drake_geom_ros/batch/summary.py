"""Summary of a batch, in a few lines and as a picture, counted block by block.

Distances count by the ends of their certified intervals, so pairs reported as apart are certified.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from drake_geom_ros.batch.questions import Columns
from drake_geom_ros.batch.running import BatchError
from drake_geom_ros.math.array_types import Floats

BINS = 60


class Summary:
    """Numbers of states, answers and collisions, and the distribution of distances."""

    def __init__(self) -> None:
        self.states = self.colliding = self.surfaces = self.without = 0
        self.largest_force = 0.0  # [N]
        self.of_what = ''
        self._lower: list[Floats] = []
        self._upper: list[Floats] = []

    def of(self, blocks: Iterable[Columns]) -> Iterator[Columns]:
        """Yield blocks, and count each."""
        for block in blocks:
            self._add(block)
            yield block

    def _add(self, block: Columns) -> None:
        if 'area' in block:
            self._add_contacts(block)
            return
        if 'collision' in block:
            self.of_what = 'collision'
            self.states += len(block['collision'])
            self.colliding += int(block['collision'].sum())
            return
        self.of_what = 'distances'
        distance, bound = block['distance'], block['error_bound']
        self.states += len(block.get('counts', distance))
        finite = np.isfinite(distance)
        self._lower.append((distance - bound)[finite])
        self._upper.append((distance + bound)[finite])

    def _add_contacts(self, block: Columns) -> None:
        self.of_what = 'contacts'
        self.states += len(block['counts'])
        pressing = block['reason'] == 0
        self.surfaces += int(pressing.sum())
        self.without += int((~pressing).sum())
        of = np.repeat(np.arange(len(block['counts'])), block['counts'])
        self.colliding += len(np.unique(of))
        forces = np.linalg.norm(block['force_on_A_W'][pressing], axis=1)
        self.largest_force = max(self.largest_force, float(forces.max(initial=0.0)))

    def _contact_lines(self) -> list[str]:
        """Return the lines on contacts, which list overlapping pairs without a surface, too."""
        lines = [
            f'states with pairs that overlap {self.colliding}',
            f'contact surfaces {self.surfaces}, largest force {self.largest_force:.6g} N',
        ]
        if self.without:
            lines.append(
                f'PAIRS THAT OVERLAP WITHOUT A SURFACE {self.without}: area and force are NaN'
            )
        return lines

    @property
    def lower(self) -> Floats:
        """The lower ends [m] of all certified intervals."""
        return np.concatenate(self._lower) if self._lower else np.zeros(0)

    @property
    def upper(self) -> Floats:
        """The upper ends [m] of all certified intervals."""
        return np.concatenate(self._upper) if self._upper else np.zeros(0)

    def lines(self) -> list[str]:
        """Return the lines of the summary."""
        lines = [f'states {self.states}']
        if self.of_what == 'contacts':
            return [*lines, *self._contact_lines()]
        if self.of_what != 'distances':
            share = self.colliding / max(self.states, 1)
            return [*lines, f'colliding {self.colliding} ({100.0 * share:.2f} %)']
        lower = self.lower
        lines.append(f'distances {len(lower)}')
        if len(lower):
            low, middle, high = np.quantile(lower, [0.0, 0.5, 1.0])
            below, unsure = (float((ends < 0.0).mean()) for ends in (self.upper, lower))
            lines.append(
                f'certified lower bounds: least {low:.6g} m, median {middle:.6g} m, '
                f'largest {high:.6g} m'
            )
            lines.append(
                f'below zero {100.0 * below:.2f} %, '
                f'not certified to be above {100.0 * unsure:.2f} %'
            )
        return lines

    def draw(self, path: Path, title: str) -> None:
        """Draw the histogram of lower bounds; raises BatchError without distances."""
        lower = self.lower
        if not len(lower):
            raise BatchError(f'{path}: there are no distances to draw a histogram of')
        try:
            from matplotlib.figure import Figure
        except ImportError as error:
            raise BatchError(f'a picture takes matplotlib: {error}') from None
        figure = Figure(figsize=(7.0, 4.0), layout='constrained')
        axes = figure.add_subplot()
        # Zero is an edge, so that no bar holds states of both kinds.
        width = (float(np.ptp(lower)) or 1.0) / BINS
        first, last = np.floor(lower.min() / width), np.ceil(lower.max() / width)
        edges = width * np.arange(first, last + 2.0)
        for part, colour, label in (
            (lower[lower < 0.0], 'tab:orange', 'not certified to be apart'),
            (lower[lower >= 0.0], 'tab:blue', 'apart'),
        ):
            if len(part):
                share = f'{100.0 * len(part) / len(lower):.1f} %'
                axes.hist(part, edges, color=colour, label=f'{label}: {share}')
        axes.axvline(0.0, color='black', linewidth=1.0)
        axes.set_xlabel('certified lower bound of the signed distance [m]')
        axes.set_ylabel('number of states' if self.states == len(lower) else 'number')
        axes.set_title(title)
        axes.margins(y=0.25)  # room for the legend
        axes.legend(loc='upper left')
        figure.savefig(path, dpi=120)
